"""Abaqus input: surfaces by face number, sets in all their spellings, faces from node sets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.cell_shape import CORNERS, TETRAHEDRON
from sphsolid.geometry.integrals import area_vectors
from sphsolid.geometry.mesh import Mesh, TetMesh
from sphsolid.geometry.mesh_defects import boundary_facets

STUDY = Path(__file__).parents[3] / "studies" / "meshes"
BOX = Box(upper=(1.0, 0.8, 1.2), jitter=0.3, seed=1).mesh(0.2)
TET = MeshFile(STUDY / "cube_tet_4.msh").mesh(AS_MESHED)


def coarse_cylinder(sides: int, layers: int) -> tuple[TetMesh, dict]:
    """Tetrahedra between polygons whose every second corner is cut off by one triangle.

    The mesh has one tag; the dictionary has the facets of ``bottom``, ``top`` and ``wall``.
    """
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    layer = np.concatenate([ring, np.zeros((1, 2))])
    ears = [(k, k + 1, (k + 2) % sides) for k in range(0, sides, 2)]
    fan = [(k, (k + 2) % sides, sides) for k in range(0, sides, 2)]
    triangles = np.sort(np.array(ears + fan), axis=1)
    cells = []
    for z in range(layers):
        low = triangles + z * (sides + 1)
        prism = np.concatenate([low, low + sides + 1], axis=1)
        cells += [prism[:, columns] for columns in ([0, 1, 2, 5], [0, 1, 4, 5], [0, 3, 4, 5])]
    X = np.concatenate([np.insert(layer, 2, z, axis=1) for z in range(layers + 1)])
    found = np.concatenate(cells)
    inverted = np.linalg.det(X[found[:, 1:]] - X[found[:, :1]]) < 0.0
    found[inverted] = found[inverted][:, [1, 0, 2, 3]]
    loops, cells_of = boundary_facets("", X, found, TETRAHEDRON)
    boundary = loops[cells_of == 1]
    height = X[boundary, 2]
    faces = {"bottom": np.all(height == 0, axis=1), "top": np.all(height == layers, axis=1)}
    faces["wall"] = ~(faces["bottom"] | faces["top"])
    mesh = TetMesh(X, found, {"boundary": boundary}, 1.0, is_lattice=False)
    return mesh, {name: boundary[member] for name, member in faces.items()}


def listed(numbers) -> str:
    """Eight numbers a line, as programs write them, and a comma at the end."""
    numbers = list(numbers)
    return "".join(
        ", ".join(str(n) for n in numbers[k : k + 8]) + ",\n" for k in range(0, len(numbers), 8)
    )


def text_of(mesh: Mesh, more: str = "", kind: str = "") -> str:
    """Nodes from 11 and elements from 101 on, then ``more``."""
    kind = kind or {4: "C3D4", 8: "C3D8R"}[mesh.shape.corners]
    nodes = "".join(
        f"{k}, {x!r}, {y!r}, {z!r}\n" for k, (x, y, z) in enumerate(mesh.vertices.tolist(), 11)
    )
    elements = "".join(
        f"{k}, " + ", ".join(str(n + 11) for n in row) + "\n"
        for k, row in enumerate(mesh.cells.tolist(), 101)
    )
    return (
        f"*Heading\n** a comment, with a comma\n*Node\n{nodes}"
        f"*Element, type={kind}, elset=Body\n{elements}{more}*Step\n*Static\n1., 1.\n*End Step\n"
    )


def read(tmp_path: Path, text: str) -> Mesh:
    path = tmp_path / "body.inp"
    path.write_text(text)
    return MeshFile(path).mesh(AS_MESHED)


def same_facets(one: Mesh, facets, other) -> None:
    np.testing.assert_allclose(area_vectors(one, facets), area_vectors(one, other), atol=1e-15)
    assert len(facets) == len(other)


@pytest.mark.parametrize(
    ("kind", "corners", "faces"),
    [
        (
            "C3D8",
            CORNERS.tolist(),
            [(0, 0, -1), (0, 0, 1), (0, -1, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0)],
        ),
        (
            "C3D4",
            [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
            [(0, 0, -0.5), (0, -0.5, 0), (0.5, 0.5, 0.5), (-0.5, 0, 0)],
        ),
    ],
)
def test_faces_of_an_element_are_numbered_as_in_the_manual(tmp_path, kind, corners, faces):
    """S1 is that of nodes 1, 2, 3 (4), S2 of a tetrahedron that of nodes 1, 4, 2, and so on."""
    nodes = "".join(f"{k}, {x}, {y}, {z}\n" for k, (x, y, z) in enumerate(corners, 1))
    element = f"*ELEMENT, TYPE={kind}\n7, " + ", ".join(str(k + 1) for k in range(len(corners)))
    surfaces = "".join(f"*SURFACE, NAME=f{k}\n7, S{k}\n" for k in range(1, len(faces) + 1))
    mesh = read(tmp_path, f"*NODE\n{nodes}{element}\n{surfaces}")
    assert len(mesh.faces) == len(faces)
    for k, expected in enumerate(faces, 1):
        area = area_vectors(mesh, mesh.face(f"f{k}")).sum(axis=0)
        np.testing.assert_allclose(area, expected, atol=1e-15)


def test_surfaces_sets_in_parts_and_any_case(tmp_path):
    """Element sets by numbers, ranges and other sets; a surface of two rows; case is no matter."""
    hexes = BOX
    centres = hexes.vertices[hexes.cells].mean(axis=1)
    low = 101 + np.flatnonzero(centres[:, 0] < 0.2)
    high = 101 + np.flatnonzero(centres[:, 0] > 0.8)
    half = len(low) // 2
    first, last = 101, 100 + len(hexes.cells)
    more = (
        f"*ELSET, ELSET=LOW\n{listed(low[:half])}*Elset, elset=Low\n{listed(low[half:])}"
        f"*ELSET, ELSET=_ends, INTERNAL\nlow,\n{listed(high)}"
        f"*ELSET, ELSET=all, GENERATE\n{first}, {last}, 1\n"
        "*SURFACE, TYPE=ELEMENT,\n NAME=ends\nLOW, S6\n"
        f"*ELSET, ELSET=right\n{listed(high)}*SURFACE, NAME=right side\nRIGHT, S4\n"
    )
    mesh = read(tmp_path, text_of(hexes, more))
    assert set(mesh.faces) == {"ends", "right side", "boundary"}
    np.testing.assert_array_equal(mesh.vertices, hexes.vertices)
    same_facets(mesh, mesh.faces["ends"], hexes.faces["X-"])
    same_facets(mesh, mesh.faces["right side"], hexes.faces["X+"])


@pytest.mark.parametrize("mesh", [BOX, TET], ids=["hex", "tet"])
def test_node_sets_tag_the_faces_they_are_chosen_on(tmp_path, mesh):
    sets = "".join(
        f"*NSET, NSET={name}\n{listed(11 + np.unique(facets))}"
        for name, facets in mesh.faces.items()
    )
    # Sets that are no face: a corner, all nodes, one with a node inside, an edge.
    inside = np.setdiff1d(mesh.cells, mesh.boundary)[0]
    edge = np.intersect1d(mesh.faces["X-"], mesh.faces["Y-"])
    sets += f"*NSET, NSET=corner\n{listed([11 + edge[0]])}*NSET, NSET=edge\n{listed(11 + edge)}"
    sets += f"*NSET, NSET=everything, GENERATE\n11, {10 + len(mesh.vertices)}\n"
    sets += f"*NSET, NSET=inside\n{listed([11 + inside, *(11 + np.unique(mesh.faces['X-']))])}"
    sets += "*NSET, NSET=of elements, ELSET=Body\n"
    found = read(tmp_path, text_of(mesh, sets))
    assert set(found.faces) == set(mesh.faces)
    for name, facets in mesh.faces.items():
        same_facets(found, found.faces[name], facets)


@pytest.mark.parametrize("names", [("bottom", "top", "wall"), ("wall",), ("bottom", "wall")])
@pytest.mark.parametrize("sides", [6, 16])
def test_a_facet_at_an_edge_belongs_to_the_face_it_goes_on_in(tmp_path, names, sides):
    """Half the triangles of the ends have all vertices on the rim, hence in the wall's set."""
    mesh, faces = coarse_cylinder(sides, 2)
    assert np.isin(faces["bottom"], faces["wall"]).all(axis=1).sum() == sides // 2
    sets = "".join(
        f"*NSET, NSET={name}\n{listed(11 + np.unique(faces[name]))}" for name in names
    )
    found = read(tmp_path, text_of(mesh, sets))
    assert set(found.faces) == {*names, *(("boundary",) if len(names) < 3 else ())}
    for name in names:
        same_facets(found, found.faces[name], faces[name])


def test_a_node_set_may_end_in_the_middle_of_a_face(tmp_path):
    """An end and half of the face beside it: one tag, and none of the facets are lost."""
    bottom = BOX.faces["Y-"]
    half = bottom[BOX.vertices[bottom, 0].max(axis=1) < 0.5]
    patch = np.concatenate([BOX.faces["X-"], half])
    assert 0 < len(half) < len(bottom)
    found = read(tmp_path, text_of(BOX, f"*NSET, NSET=patch\n{listed(11 + np.unique(patch))}"))
    same_facets(found, found.faces["patch"], patch)


def test_a_set_of_all_nodes_is_no_tag_where_all_are_on_the_boundary(tmp_path):
    mesh = Box().mesh(1.0)
    sets = "*NSET, NSET=all, GENERATE\n11, 18\n"
    sets += f"*NSET, NSET=end\n{listed(11 + np.unique(mesh.faces['X-']))}"
    assert set(read(tmp_path, text_of(mesh, sets)).faces) == {"end", "boundary"}


def test_a_node_set_gives_way_to_a_surface_and_to_its_own_elements(tmp_path):
    quads = "".join(
        f"{k}, " + ", ".join(str(n + 11) for n in row) + "\n"
        for k, row in enumerate(BOX.faces["Y-"].tolist(), 9001)
    )
    more = (
        f"*ELEMENT, TYPE=S4R, ELSET=Surface4\n{quads}"
        f"*ELSET, ELSET=base\n{listed(range(9001, 9001 + len(BOX.faces['Y-'])))}"
        f"*NSET, NSET=base\n{listed(11 + np.unique(BOX.faces['Y-']))}"
        f"*NSET, NSET=same\n{listed(11 + np.unique(BOX.faces['Y-']))}"
        f"*NSET, NSET=end\n{listed(11 + np.unique(BOX.faces['X-']))}"
    )
    mesh = read(tmp_path, text_of(BOX, more))
    assert set(mesh.faces) == {"base", "end", "boundary"}
    same_facets(mesh, mesh.faces["base"], BOX.faces["Y-"])
    same_facets(mesh, mesh.faces["end"], BOX.faces["X-"])


def test_the_set_of_an_element_line_is_a_tag_where_nothing_else_names_it(tmp_path):
    quads = [
        "".join(
            f"{k}, " + ", ".join(str(n + 11) for n in row) + "\n"
            for k, row in enumerate(BOX.faces[name].tolist(), start)
        )
        for name, start in (("Y-", 9001), ("Y+", 9501))
    ]
    more = f"*ELEMENT, TYPE=M3D4, ELSET=low\n{quads[0]}*ELEMENT, ELSET=high, TYPE=CPS4\n{quads[1]}"
    more += "*ELEMENT, TYPE=T3D2, ELSET=truss\n99991, 11, 12\n"
    mesh = read(tmp_path, text_of(BOX, more))
    assert set(mesh.faces) == {"low", "high", "boundary"}
    same_facets(mesh, mesh.faces["high"], BOX.faces["Y+"])


@pytest.mark.parametrize(
    ("card", "named"),
    [
        ("*Nset, nset=a\n999999", r"line \d+, \*NSET: the set has 1 members"),
        ("*Elset, elset=a\nb", r"\*ELSET.*set 'b' is not defined.*'Body'"),
        ("*Surface, name=a\nBody, S7", r"have no face 'S7'; allowed are S1 to S6"),
        ("*Surface, name=a\nBody, P1", r"have no face 'P1'; allowed are S1 to S6"),
        ("*Surface\nBody, S1", r"\*SURFACE: its parameters .*NAME"),
        ("*Surface, name=a\nBody, S1", r"tag 'a': .* lie between two cells"),
        ("*Element, type=C3D99", r"\*ELEMENT: element type 'C3D99' is unknown"),
        ("*Node\n11, 0, 0, 0", "node 11 is defined twice"),
        ("*Element, type=C3D8\n101, 1, 2, 3, 4, 5, 6, 7, 8", "element 101 is def"),
        ("*Node\n5, 0, 0", r"line \d+, \*NODE: a node needs"),
        ("*Node\n5, 0, 0, zero", r"\*NODE: its parameters or data .* ' zero'"),
        ("*Element, type=C3D8\n7, 1, 2", "C3D8 need 8 nodes and element 7 has 2; complete it"),
        ("*Element, type=C3D4\n7, 11, 12, 13, 5", "not defined; the first is node 5 of element 7"),
        ("*Ngen\n1, 5", r"\*NGEN: it makes, moves or fetches nodes"),
        ("*Instance, name=b\n1., 0., 0.", r"\*INSTANCE: its parameters do not say PART"),
        ("*Include, input=more.inp", r"\*INCLUDE: it makes, moves or fetches"),
    ],
)
def test_bad_input_is_refused_with_its_line(tmp_path, card, named):
    with pytest.raises(InputError, match=named) as caught:
        read(tmp_path, text_of(BOX, card + "\n"))
    assert "body.inp" in str(caught.value)
    assert "\n" not in str(caught.value)
