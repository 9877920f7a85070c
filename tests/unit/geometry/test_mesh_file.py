"""Bodies from files: the same mesh, tags and exact volume from every format."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial import cKDTree

from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile, Region, Tagged
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.facets import same_vertices, turns
from sphsolid.geometry.integrals import area_vectors, vertex_volumes
from sphsolid.geometry.mesh import HexMesh, TetMesh
from tests.oracles.gmsh_text import write_gmsh, write_mesh

DATA = Path(__file__).parents[2] / "data" / "meshes"
FILES = sorted(path.name for path in DATA.glob("prism_*_[12]*.*"))
#: The prism: 0 <= Y <= 1, 0 <= X <= 2 - Y/2, 0 <= Z <= 1.5.
VOLUME = 2.625
MOMENT = np.array([1.5 * 37 / 24, 1.5 * 5 / 6, 0.75 * VOLUME])
AREA_VECTORS = {
    "clamped": (-1.5, 0.0, 0.0),
    "slant": (1.5, 0.75, 0.0),
    "top side": (0.0, 0.0, 1.75),
    "boundary": (0.0, 1.5 * 1.5 - 1.5 * 2.0, -1.75),
}


def mesh_of(name: str | Path, unit: str | float = "m") -> HexMesh | TetMesh:
    return MeshFile(DATA / name, unit).mesh(AS_MESHED)


def tag_of(path: str, name: str) -> str:
    """Gmsh writes no blanks into Abaqus files."""
    return name.replace(" ", "_") if path.endswith(".inp") else name


def test_all_formats_are_there():
    kinds = itertools.product(("tet", "hex"), (1, 2))
    wanted = {
        f"prism_{cell}_{order}{form}"
        for cell, order in kinds
        for form in (".inp", ".vtu", "_22_text.msh", "_22_binary.msh", "_41_text.msh",
                     "_41_binary.msh")
    }  # fmt: skip
    assert set(FILES) == wanted
    assert sum(path.stat().st_size for path in DATA.iterdir() if path.is_file()) < 1e6


@pytest.mark.parametrize("name", FILES)
def test_volume_moments_and_closure_are_exact(name):
    mesh = mesh_of(name)
    # Gmsh writes Abaqus files with 15 digits.
    tolerance = 1e-13 if name.endswith(".inp") else 1e-14
    V, A = vertex_volumes(mesh), area_vectors(mesh, mesh.boundary)
    assert isinstance(mesh, TetMesh if "tet" in name else HexMesh)
    assert not mesh.is_lattice
    assert np.all(V > 0.0)
    assert V.sum() == pytest.approx(VOLUME, rel=tolerance)
    assert MeshFile(DATA / name).volume == pytest.approx(VOLUME, rel=tolerance)
    np.testing.assert_allclose(V @ mesh.vertices, MOMENT, rtol=tolerance)
    np.testing.assert_allclose(A.sum(axis=0), 0.0, atol=1e-14)
    np.testing.assert_allclose(A.T @ mesh.vertices, VOLUME * np.eye(3), atol=10 * tolerance)


@pytest.mark.parametrize("name", FILES)
def test_names_survive_on_outward_facets(name):
    mesh = mesh_of(name)
    assert set(mesh.faces) == {tag_of(name, tag) for tag in AREA_VECTORS}
    for tag, expected in AREA_VECTORS.items():
        facets = mesh.face(tag_of(name, tag))
        found = area_vectors(mesh, facets)
        np.testing.assert_allclose(found.sum(axis=0), expected, atol=1e-13)
        if tag != "boundary":  # plane: each facet points out of it
            direction = np.array(expected) / np.linalg.norm(expected)
            alone = np.array([area_vectors(mesh, facet[None]).sum(axis=0) for facet in facets])
            assert np.all(alone @ direction > 0.0)


@pytest.mark.parametrize("name", FILES)
def test_every_format_holds_the_same_mesh(name):
    """The cells and tagged facets of the 2.2 text file, whatever their order in the file."""
    cell = name.split("_")[1]
    reference, mesh = mesh_of(f"prism_{cell}_1_22_text.msh"), mesh_of(name)
    distance, place = cKDTree(reference.vertices).query(mesh.vertices)
    assert distance.max() < 1e-13
    np.testing.assert_array_equal(np.sort(place), np.arange(len(reference.vertices)))
    assert rows(place[mesh.cells]) == rows(reference.cells)
    for tag in AREA_VECTORS:
        assert rows(place[mesh.face(tag_of(name, tag))]) == rows(reference.face(tag))


def rows(vertices):
    return sorted(map(tuple, np.sort(vertices, axis=1).tolist()))


@pytest.mark.parametrize("name", FILES)
def test_of_second_order_cells_the_corners_are_taken(name):
    found = MeshFile(DATA / name).read()
    # Midside vertices: the edges of the cells, and for 27 nodes facets and cells, too.
    edges = {"tet": 274, "hex": 75}[name.split("_")[1]]
    complete = 52 + 12 if "hex" in name and not name.endswith(".inp") else 0
    assert found.midside_vertices == (edges + complete if "_2" in name[9:11] else 0)
    assert found.unused_vertices == 0
    assert len(found.mesh.vertices) == {"tet": 64, "hex": 36}[name.split("_")[1]]


def test_a_unit_scales_the_body():
    mesh, small = mesh_of("prism_tet_mm.msh", "mm"), mesh_of("prism_tet_mm.msh", 2.0e-3)
    assert vertex_volumes(mesh).sum() == pytest.approx(VOLUME, rel=1e-14)
    np.testing.assert_allclose(small.vertices, 2.0 * mesh.vertices, rtol=1e-15)
    assert small.spacing == pytest.approx(2.0 * mesh.spacing, rel=1e-14)
    assert MeshFile(DATA / FILES[0], "in").volume == pytest.approx(VOLUME * 0.0254**3, rel=1e-13)
    assert MeshFile(DATA / FILES[0], "cm").volume == pytest.approx(VOLUME * 1e-6, rel=1e-13)


@pytest.mark.parametrize(("name", "cube"), [("prism_tet_1.vtu", 6.0), ("prism_hex_1.vtu", 1.0)])
def test_the_nominal_spacing_is_the_edge_of_a_cube_of_mean_volume(name, cube):
    mesh = mesh_of(name)
    assert mesh.spacing == pytest.approx((cube * VOLUME / len(mesh.cells)) ** (1 / 3), rel=1e-14)


def test_a_spacing_is_refused():
    with pytest.raises(InputError, match=r"spacing = 0.1 m was given and .*prism.* has its own"):
        MeshFile(DATA / FILES[0]).mesh(0.1)


def test_a_file_of_a_box_is_the_box(tmp_path):
    """Cells, vertices and tags of a mesh that was not made by a mesher come back unchanged."""
    box = Box(upper=(1.0, 0.7, 1.2), jitter=0.4, seed=3).mesh(0.2)
    mesh = mesh_of(write_mesh(tmp_path / "box.msh", box))
    np.testing.assert_array_equal(mesh.vertices, box.vertices)
    np.testing.assert_array_equal(mesh.cells, box.cells)
    assert set(mesh.faces) == set(box.faces)
    for tag, facets in box.faces.items():
        assert rows(mesh.faces[tag]) == rows(facets)
        np.testing.assert_allclose(
            area_vectors(mesh, mesh.faces[tag]), area_vectors(box, facets), atol=1e-16
        )


def test_the_body_fits_into_others():
    """Regions of a named face, by the same body as any."""
    body = Tagged(
        MeshFile(DATA / "prism_hex_1.vtu"),
        (Region("patch", "top side", lambda X: X[:, 0] < 0.6),),
    )
    faces = body.mesh(AS_MESHED).faces
    assert (len(faces["patch"]), len(faces["top side"])) == (2, 4)


def test_an_edited_file_is_read_again(tmp_path):
    path = write_mesh(tmp_path / "box.msh", Box().mesh(0.5))
    assert MeshFile(path).volume == pytest.approx(1.0)
    write_mesh(path, Box(upper=(1.0, 1.0, 2.25)).mesh(0.5))
    assert MeshFile(path).volume == pytest.approx(2.25)


def test_a_left_handed_file_is_mirrored(tmp_path):
    """All cells inverted: corners are turned, vertices and tags stay."""
    for box in (Box(jitter=0.4).mesh(0.5), mesh_of("prism_tet_1.vtu")):
        turned = [4, 5, 6, 7, 0, 1, 2, 3] if isinstance(box, HexMesh) else [0, 2, 1, 3]
        found = MeshFile(
            write_mesh(tmp_path / "box.msh", box, cells=box.cells[:, turned])
        ).read()
        assert found.left_handed
        np.testing.assert_allclose(
            vertex_volumes(found.mesh), vertex_volumes(box), rtol=1e-13, atol=1e-16
        )
        for tag, facets in box.faces.items():
            area = area_vectors(found.mesh, found.mesh.face(tag))
            np.testing.assert_allclose(area, area_vectors(box, facets), atol=1e-15)
    assert not MeshFile(DATA / "prism_hex_1.vtu").read().left_handed


def test_vertices_of_no_cell_are_left_out_and_counted(tmp_path):
    box = Box(jitter=0.4).mesh(0.5)
    points = np.insert(box.vertices, [0, 5, 27], [[np.nan, 0, 0], [9, 9, 9], [8, 8, 8]], axis=0)
    shift = np.arange(27) + 1 + (np.arange(27) >= 5)
    moved = dataclasses.replace(
        box, cells=shift[box.cells], faces={k: shift[v] for k, v in box.faces.items()}
    )
    found = MeshFile(write_mesh(tmp_path / "box.msh", moved, points=points)).read()
    assert (found.unused_vertices, found.midside_vertices) == (3, 0)
    np.testing.assert_array_equal(found.mesh.vertices, box.vertices)
    np.testing.assert_array_equal(found.mesh.cells, box.cells)


def test_a_name_that_a_surface_shares_with_the_body_is_not_lost(tmp_path):
    """meshio keeps one of the two."""
    for name in ("prism_tet_1_22_text.msh", "prism_hex_2_41_text.msh"):
        text = (DATA / name).read_text().replace('"body"', '"slant"')
        path = tmp_path / name
        path.write_text(text)
        assert rows(mesh_of(path).faces["slant"]) == rows(mesh_of(name).faces["slant"])


def test_a_physical_surface_without_a_name_is_called_by_its_number(tmp_path):
    box = Box().mesh(0.5)
    path = write_gmsh(
        tmp_path / "box.msh",
        box.vertices,
        [("quad", box.faces["X-"], 41), ("quad", box.faces["X+"], 7), ("line", [[0, 1]], 3),
         ("hexahedron", box.cells, 1)],
        [(2, 7, "right"), (1, 3, "an edge")],
    )  # fmt: skip
    faces = mesh_of(path).faces
    assert {name: len(facets) for name, facets in faces.items()} == {
        "41": 4, "right": 4, "boundary": 16
    }  # fmt: skip


def test_what_has_no_tag_gets_one_that_is_free(tmp_path):
    box = Box().mesh(0.5)
    faces = {"boundary": box.faces["X-"]}
    mesh = mesh_of(write_mesh(tmp_path / "b.msh", dataclasses.replace(box, faces=faces)))
    assert {name: len(facets) for name, facets in mesh.faces.items()} == {
        "boundary": 4, "untagged": 20
    }  # fmt: skip
    assert len(mesh.boundary) == 24


def test_nothing_is_printed(capfd):
    """meshio prints blank lines and warnings of its own."""
    MeshFile(DATA / "prism_tet_1_41_text.msh").read()
    MeshFile(DATA / "prism_tet_1.vtu").read()
    assert capfd.readouterr() == ("", "")


# ---------------------------------------------------------------------- VTU
def write_vtu(path: Path, box: HexMesh, arrays: dict) -> Path:
    cells = [("quad", facets) for facets in box.faces.values()] + [("hexahedron", box.cells)]
    names = list(box.faces)
    data = {
        key: [np.full(len(nodes), values.get(name, values.get("rest", 0)))
              for name, (_, nodes) in zip([*names, "body"], cells, strict=True)]
        for key, values in arrays.items()
    }  # fmt: skip
    meshio.write(path, meshio.Mesh(box.vertices, cells, cell_data=data))
    return path


@pytest.mark.parametrize(
    ("arrays", "tags"),
    [
        ({}, {"boundary"}),
        ({"part": {"X-": 3, "Y+": 12, "Z-": -1, "body": 5}}, {"3", "12", "boundary"}),
        ({"pull": {"X-": 1}, "hold": {"Y+": 1, "Z+": 1}}, {"pull", "hold", "boundary"}),
        ({"part": {"X-": 3}, "hold": {"Y+": 1}}, {"3", "hold", "boundary"}),
        ({"part": {"X-": 3}, "tag": {"Y+": 5}}, {"5", "boundary"}),
        ({"gmsh:physical": {"X-": 3}, "gmsh:geometrical": {"rest": 9}}, {"3", "boundary"}),
        ({"density": {"rest": 2.5}, "GlobalIds": {"rest": 2}}, {"boundary"}),
    ],
)
def test_integer_arrays_of_a_vtu_file_are_tags(tmp_path, arrays, tags):
    box = Box().mesh(0.5)
    mesh = mesh_of(write_vtu(tmp_path / "box.vtu", box, arrays))
    assert set(mesh.faces) == tags
    for tag, face in (("3", "X-"), ("12", "Y+"), ("pull", "X-")):
        if tag in tags:
            assert rows(mesh.faces[tag]) == rows(box.faces[face])
    if tags == {"pull", "hold", "boundary"}:
        assert len(mesh.faces["hold"]) == 8


# ------------------------------------------------------------------- facets
def test_rows_of_the_same_vertices_have_the_same_number():
    rng = np.random.default_rng(2)
    for width in (3, 4, 8):
        some = np.array([rng.permutation(12)[:width] for _ in range(300)])
        again = rng.permuted(some, axis=1)
        number = same_vertices(np.concatenate([some, again]))
        np.testing.assert_array_equal(number[:300], number[300:])
        sets = {frozenset(row) for row in some.tolist()}
        assert len(np.unique(number)) == len(sets) == number.max() + 1


def test_the_sense_of_a_loop_does_not_depend_on_where_it_starts():
    for loop in ([4, 7, 2], [4, 7, 2, 9]):
        turned = np.array([np.roll(loop, k) for k in range(len(loop))])
        sense, opposite = turns(turned)
        back, across = turns(turned[:, ::-1])
        assert len(set(sense)) == len(set(opposite)) == 1
        assert not np.any(sense == back)
        np.testing.assert_array_equal(opposite, across)
    crossed = turns(np.array([[4, 7, 2, 9], [4, 2, 7, 9]]))[1]
    assert crossed[0] != crossed[1]
