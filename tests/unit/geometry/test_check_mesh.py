"""The report of a mesh: exact where the mesh is, and off where a bug is planted in it."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, Box, MeshFile, check_mesh
from sphsolid.geometry.__main__ import main
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.check_mesh import cell_quality
from sphsolid.geometry.mesh import HexMesh, Mesh, TetMesh
from tests.oracles.gmsh_text import write_mesh

DATA = Path(__file__).parents[2] / "data" / "meshes"
STUDY = Path(__file__).parents[3] / "studies" / "meshes"


def bent(mesh: Mesh) -> Mesh:
    """Facets that are no planes, far from the origin."""
    x, y, z = mesh.vertices.T
    bow = np.stack([y * z, x**2, x * y], axis=1)
    return replace(mesh, vertices=mesh.vertices + 0.1 * bow + [30.0, -20.0, 10.0])


MESHES = {
    "lattice": Box(upper=(1.0, 0.8, 1.2)).mesh(0.2),
    "jitter": Box(upper=(1.0, 0.8, 1.2), jitter=0.6, seed=2).mesh(0.2),
    "bent hexahedra": bent(Box(jitter=0.3).mesh(0.25)),
    "tetrahedra": MeshFile(DATA / "prism_tet_1.vtu").mesh(AS_MESHED),
    "bent tetrahedra": bent(MeshFile(DATA / "prism_tet_2.vtu").mesh(AS_MESHED)),
    "plate": MeshFile(STUDY / "plate_with_hole_hex.msh").mesh(AS_MESHED),
}


@pytest.mark.parametrize("name", MESHES)
def test_volume_moments_and_closure_agree_to_round_off(name):
    mesh = MESHES[name]
    report = check_mesh(mesh)
    distance = np.linalg.norm(mesh.vertices.mean(axis=0)) / report.size
    assert report.volume_error < 1e-13
    assert report.moment_error < 1e-14 * (1.0 + distance)
    assert report.open_area < 1e-14
    assert report.area == pytest.approx(sum(tag.area for tag in report.tags), rel=1e-15)
    assert sum(tag.facets for tag in report.tags) == len(mesh.boundary)


def test_neighbours_are_counted_in_local_spacings() -> None:
    """A lattice has 6 + 12 + 8 points nearer than two spacings; a corner sees 3 + 3 + 1."""
    fewest, mean, most = check_mesh(Box().mesh(0.2)).neighbours
    assert (fewest, most) == (7, 26)
    assert 7 < mean < 26
    assert "7 to 26 of a vertex" in str(check_mesh(Box().mesh(0.2)))


def one_facet_turned(mesh: Mesh) -> Mesh:
    name = max(mesh.faces, key=lambda tag: len(mesh.faces[tag]))
    facets = mesh.faces[name].copy()
    facets[0] = facets[0, ::-1]
    return replace(mesh, faces={**mesh.faces, name: facets})


def one_facet_missing(mesh: Mesh) -> Mesh:
    name = max(mesh.faces, key=lambda tag: len(mesh.faces[tag]))
    return replace(mesh, faces={**mesh.faces, name: mesh.faces[name][1:]})


def one_facet_twice(mesh: Mesh) -> Mesh:
    name = max(mesh.faces, key=lambda tag: len(mesh.faces[tag]))
    facets = mesh.faces[name]
    return replace(mesh, faces={**mesh.faces, name: np.concatenate([facets, facets[:1]])})


def one_cell_missing(mesh: Mesh) -> Mesh:
    """One in the middle, none of whose vertices it leaves alone."""
    middle = mesh.vertices.mean(axis=0)
    centre = mesh.vertices[mesh.cells].mean(axis=1)
    cell = np.argmin(np.linalg.norm(centre - middle, axis=1))
    return replace(mesh, cells=np.delete(mesh.cells, cell, axis=0))


@pytest.mark.parametrize("name", ["jitter", "tetrahedra", "bent tetrahedra", "plate"])
@pytest.mark.parametrize(
    ("bug", "opens"),
    [
        (one_facet_turned, True),
        (one_facet_missing, True),
        (one_facet_twice, True),
        (one_cell_missing, False),
    ],
)
def test_a_planted_bug_shows(name, bug, opens):
    report = check_mesh(bug(MESHES[name]))
    assert report.volume_error > 1e-5
    assert report.moment_error > 1e-6
    assert (report.open_area > 1e-5) == opens


def test_all_facets_turned_show_in_the_volume():
    """A closed boundary seen from inside is closed; its volume is negative."""
    mesh = MESHES["jitter"]
    inside_out = replace(mesh, faces={k: v[:, ::-1] for k, v in mesh.faces.items()})
    report = check_mesh(inside_out)
    assert report.open_area < 1e-14
    assert report.volume_in_boundary == pytest.approx(-0.96, rel=1e-13)
    assert report.volume_error == pytest.approx(2.0)


def test_it_measures_what_is_known_of_a_lattice():
    report = check_mesh(Box(lower=(1.0, 2.0, 3.0), upper=(2.0, 2.8, 4.2)).mesh(0.2))
    assert (report.cells, report.vertices, report.parts) == (120, 210, 1)
    assert report.volume_of_cells == pytest.approx(0.96, rel=1e-14)
    assert report.centroid_of_particles == pytest.approx((1.5, 2.4, 3.6), rel=1e-14)
    assert report.size == pytest.approx(np.sqrt(1.0 + 0.64 + 1.44), rel=1e-15)
    lengths = ("spacing", "smallest_spacing", "largest_spacing", "smallest_distance")
    for length in lengths:
        assert getattr(report, length) == pytest.approx(0.2, rel=1e-13)
    assert report.worst_quality == pytest.approx(1.0, rel=1e-13)
    areas = {tag.name: (tag.facets, tag.area) for tag in report.tags}
    assert list(areas) == ["X+", "X-", "Y+", "Y-", "Z+", "Z-"]
    assert areas["X-"] == (24, pytest.approx(0.96))
    assert areas["Y+"] == (30, pytest.approx(1.2))
    assert areas["Z-"] == (20, pytest.approx(0.8))


def test_parts_are_pieces_that_share_a_facet():
    """Two cubes that meet in an edge are two parts; in a face, one."""
    cube = ((0, 0, 0), (1, 1, 1))
    for other, parts in ((((1, 1, 0), (2, 2, 1)), 2), (((1, 0, 0), (2, 1, 1)), 1)):
        assert check_mesh(Blocks((cube, other)).mesh(0.5)).parts == parts


def test_quality_of_cells_that_are_known():
    regular = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    flat = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.3, 1e-9]])
    cells = np.array([[0, 1, 2, 3]])
    for X, expected in ((regular[[0, 2, 1, 3]], 1.0), (corner, np.sqrt(0.5)), (flat, 0.0)):
        quality = cell_quality(TetMesh(X, cells, {}, 1.0, False))
        np.testing.assert_allclose(quality, [expected], atol=1e-8)
        assert quality[0] > 0.0
    sheared = Box(aspect=(1.0, 2.0, 0.5)).mesh(0.5)
    X = sheared.vertices + np.outer(sheared.vertices[:, 1], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(cell_quality(replace(sheared, vertices=X)), np.sqrt(0.5))
    # A corner pushed in past the plane of its neighbours: negative though the volume is not.
    X = Box().mesh(1.0).vertices.copy()
    X[np.all(X == 1.0, axis=1)] = 0.6
    assert cell_quality(HexMesh(X, Box().mesh(1.0).cells, {}, 1.0, False))[0] < 0.0


def test_an_inverted_cell_is_refused():
    mesh = MESHES["lattice"]
    cells = mesh.cells.copy()
    cells[7] = cells[7, [4, 5, 6, 7, 0, 1, 2, 3]]
    with pytest.raises(InputError, match="cell 7 .* inverted"):  # noqa: RUF043
        check_mesh(replace(mesh, cells=cells))


def test_the_report_prints_every_value_with_its_unit():
    text = str(check_mesh(MESHES["tetrahedra"], unused_vertices=3, midside_vertices=17))
    for part in (
        "cells        150 of type tetrahedron, in 1 part(s)",
        "vertices     64 (3 unused, 17 midside left out)",
        "volume       2.625 m^3; ",
        "centroid     (0.880952, 0.47619, 0.75) m; ",
        "boundary     ",
        "m; smallest distance",
        "scaled Jacobian",
        "tag         facets    area [m^2]",
        "clamped         18           1.5",
        "boundary        68",
        "top side        16          1.75",
    ):
        assert part in text
    assert max(len(line) for line in text.splitlines()) <= 110


# ------------------------------------------------------------- command line
def test_the_command_prints_the_report(capsys):
    assert main([str(DATA / "prism_tet_mm.msh"), "--unit", "mm"]) == 0
    out, err = capsys.readouterr()
    assert "lengths in mm" in out
    assert "volume       2.625 m^3" in out
    assert err == ""
    assert main([str(DATA / "prism_hex_2.inp"), "--unit", "0.5"]) == 0
    out = capsys.readouterr().out
    assert "volume       0.328125 m^3" in out
    assert "75 midside left out" in out


def test_the_command_says_that_a_file_is_left_handed(tmp_path, capsys):
    box = Box().mesh(0.5)
    path = write_mesh(tmp_path / "b.msh", box, cells=box.cells[:, [4, 5, 6, 7, 0, 1, 2, 3]])
    assert main([str(path)]) == 0
    assert "all cells of the file were inverted" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere.msh"], "nowhere.msh does not exist"),
        ([str(DATA / "make_meshes.py")], "allowed extensions"),
        ([str(DATA / "save_all_22.msh")], "tag 'clamped' has no facets"),
        ([str(DATA / "prism_tet_mm.msh"), "--unit", "furlong"], "unit = 'furlong'"),
    ],
)
def test_the_command_fails_with_one_line(capsys, arguments, said):
    assert main(arguments) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.startswith("error: ")
    assert err.count("\n") == 1


def test_it_runs_as_a_module():
    command = [sys.executable, "-m", "sphsolid.geometry", "nowhere.msh"]
    ended = subprocess.run(
        command, cwd=STUDY.parents[1], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 1
    assert ended.stderr.startswith("error: mesh file nowhere.msh does not exist")
    assert "Traceback" not in ended.stderr


# ----------------------------------------------------- the meshes of studies
NAMES = {
    "plate": {"hole", "symmetry_x", "symmetry_y", "pull", "side", "front", "back"},
    "cylinder": {"bottom", "top", "wall"},
    "cube": {"X-", "X+", "Y-", "Y+", "Z-", "Z+"},
}
#: Volume of the smooth body; a mesh of chords is off by no more than the share that follows.
VOLUMES = {
    "plate": (0.05 * (0.25 - np.pi * 0.01 / 4), 1e-4),
    "cylinder": (np.pi / 4, 1e-2),
    "cube": (1.0, 1e-13),
}


@pytest.mark.parametrize("path", sorted(STUDY.glob("*.msh")), ids=lambda path: path.stem)
def test_meshes_of_studies_are_sound(path):
    body = path.stem.split("_")[0]
    found = MeshFile(path).read()
    report = check_mesh(found.mesh, unused_vertices=found.unused_vertices)
    assert {tag.name for tag in report.tags} == NAMES[body]
    exact, share = VOLUMES[body]
    assert abs(report.volume_of_cells / exact - 1.0) < share
    assert report.volume_error < 1e-13
    assert report.parts == 1
    assert report.unused_vertices == 0
    assert report.worst_quality > (0.15 if "tet" in path.stem else 0.7)
    assert path.stat().st_size < 700_000


def test_all_meshes_of_studies_are_there():
    assert {path.stem for path in STUDY.glob("*.msh")} == {
        "plate_with_hole_hex", "plate_with_hole_tet", "cylinder_hex", "cylinder_tet",
        "cube_tet_4", "cube_tet_8", "cube_hex_8",
    }  # fmt: skip


@pytest.mark.parametrize("cell", ["hex", "tet"])
def test_the_plate_is_graded_to_its_hole_and_stands_where_its_names_say(cell):
    mesh = MeshFile(STUDY / f"plate_with_hole_{cell}.msh").mesh(AS_MESHED)
    X = {name: mesh.vertices[mesh.face_particles(name)] for name in mesh.faces}
    np.testing.assert_allclose(np.hypot(*X["hole"][:, :2].T), 0.1, atol=1e-9)
    for name, axis, value in (("symmetry_x", 0, 0), ("symmetry_y", 1, 0), ("pull", 1, 0.5),
                              ("side", 0, 0.5), ("back", 2, 0), ("front", 2, 0.05)):  # fmt: skip
        np.testing.assert_allclose(X[name][:, axis], value, atol=1e-12)
    assert 2500 <= len(mesh.vertices) <= 4500
    report = check_mesh(mesh)
    assert 2.0 < report.largest_spacing / report.smallest_spacing < 5.0


def test_neighbours_across_a_gap_do_not_count():
    """Two cubes a tenth of a spacing apart: each as alone, and the pairs between left out."""
    cube = ((0, 0, 0), (1, 1, 1))
    alone = check_mesh(Blocks((cube,)).mesh(0.25))
    both = check_mesh(Blocks((cube, ((0, 0, 1.025), (1, 1, 2.025)))).mesh(0.25))
    assert alone.left_out == 0
    assert both.left_out > 100
    assert both.neighbours == pytest.approx(alone.neighbours)
    assert both.smallest_distance == pytest.approx(0.25)
    assert f"left out     {both.left_out} pairs" in str(both)
