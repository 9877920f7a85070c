"""Bad files: each gets one error of one line that names the file, the culprit and its place."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.cell_shape import HEXAHEDRON
from sphsolid.geometry.mesh_defects import boundary_facets
from tests.oracles.gmsh_text import write_gmsh, write_mesh

DATA = Path(__file__).parents[2] / "data" / "meshes"
TEXT, TEXT_41 = (DATA / f"prism_tet_1_{version}_text.msh" for version in (22, 41))
#: Eight cubes of edge 1/2, vertices by Z, then Y, then X: the middle one is 13.
BOX = Box().mesh(0.5)
TETRA = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]

Make = Callable[[Path], Path]
BAD: dict[str, tuple[Make, str]] = {}


def case(named: str) -> Callable[[Make], Make]:
    """Register a maker of a bad file and the pattern of what has to be said of it."""

    def add(make: Make) -> Make:
        BAD[make.__name__] = (make, named)
        return make

    return add


def edited(folder: Path, source: Path, *changes: tuple[str, str]) -> Path:
    """A copy of a text file with each pattern replaced once; it has to be there."""
    text = source.read_text()
    for pattern, new in changes:
        text, count = re.subn(pattern, new, text, count=1, flags=re.S | re.M)
        assert count == 1, pattern
    path = folder / f"bad{source.suffix}"
    path.write_text(text)
    return path


def cut(folder: Path, source: Path, share: float) -> Path:
    data = source.read_bytes()
    path = folder / f"bad{source.suffix}"
    path.write_bytes(data[: int(share * len(data))])
    return path


def box(folder: Path, points=BOX.vertices, cells=BOX.cells, **surfaces) -> Path:
    """The eight cubes with changed points or cells and named surfaces of quadrilaterals."""
    numbers = list(enumerate(surfaces, start=1))
    return write_gmsh(
        folder / "bad.msh",
        points,
        [
            *(("quad", surfaces[name], k) for k, name in numbers if len(surfaces[name])),
            ("hexahedron", cells, 99),
        ],
        [(2, k, name) for k, name in numbers],
    )


# ------------------------------------------------------------ files as such
@case(r"bad.msh does not exist \(looked in /.*bad.msh\)")
def missing(folder):
    return folder / "bad.msh"


@case(r"bad.stl: allowed extensions are \['.inp', '.msh', '.vtu'\]")
def wrong_extension(folder):
    return folder / "bad.stl"


@case("bad.msh is not a file")
def a_folder(folder):
    (folder / "bad.msh").mkdir()
    return folder / "bad.msh"


@case("bad.msh is empty")
def nothing_in_it(folder):
    (folder / "bad.msh").write_text("")
    return folder / "bad.msh"


@case(r"bad.msh is not a Gmsh mesh: it does not begin with \$MeshFormat")
def another_kind_of_file(folder):
    (folder / "bad.msh").write_bytes((DATA / "prism_tet_1.vtu").read_bytes())
    return folder / "bad.msh"


@case("bad.msh is in Gmsh format 4.0; allowed are 2.2 and 4.1")
def old_format(folder):
    return edited(folder, TEXT_41, (r"^4.1 0 8", "4.0 0 8"))


@case("bad.inp is not an Abaqus input file")
def not_abaqus(folder):
    (folder / "bad.inp").write_text("1, 2, 3\n")
    return folder / "bad.inp"


@case("bad.vtu is not a VTK XML file")
def not_vtk(folder):
    (folder / "bad.vtu").write_bytes(TEXT.read_bytes())
    return folder / "bad.vtu"


@case("bad.vtu cannot be read as VTU: .*Expected type UnstructuredGrid, found PolyData")
def another_kind_of_vtk(folder):
    return edited(folder, DATA / "prism_tet_1.vtu", ('type="UnstructuredGrid"', 'type="PolyData"'))


# ---------------------------------------------------------------- truncated
@case(r"bad.msh is truncated: its section \$Nodes has no \$EndNodes")
def cut_in_the_nodes(folder):
    return cut(folder, TEXT, 0.25)


@case(r"bad.msh is truncated: its section \$Elements has no \$EndElements")
def cut_in_the_elements(folder):
    return cut(folder, TEXT, 0.8)


@case(r"bad.msh is truncated: its section \$Elements has no \$EndElements")
def cut_binary(folder):
    return cut(folder, DATA / "prism_hex_2_41_binary.msh", 0.9)


@case(r"bad.msh has no section \$Elements: it is truncated")
def cut_between_sections(folder):
    return edited(folder, TEXT, (r"\$Elements.*", ""))


@case("bad.vtu is truncated: it does not end with </VTKFile>")
def cut_vtu(folder):
    return cut(folder, DATA / "prism_tet_1.vtu", 0.7)


@case("bad.inp, line 68, .ELEMENT: elements use 1 nodes .* first is node 45 of element 7: add")
def missing_node(folder):
    return edited(folder, DATA / "prism_tet_1.inp", (r"^45, [^\n]*\n", ""))


@case("bad.inp is truncated: it ends in the middle of line 236; ")
def cut_abaqus(folder):
    return cut(folder, DATA / "prism_tet_1.inp", 0.75)


@case("bad.inp, line 126, .ELEMENT: elements of type C3D4 need 4 nodes and element 55 has 3; ")
def missing_number(folder):
    return edited(folder, DATA / "prism_tet_1.inp", (r"(C3D4[^\n]*\n\d+), \d+", r"\1"))


@case("bad.msh cannot be read as Gmsh 2.2: it is truncated or damaged")
def missing_lines(folder):
    return edited(folder, TEXT, (r"^6 [^\n]*\n7 [^\n]*\n", ""))


@case("bad.msh cannot be read as Gmsh 4.1: it is truncated or damaged")
def letters_among_numbers(folder):
    return edited(folder, TEXT_41, (r"^0 1 0$", "0 one 0"))


# ------------------------------------------------------------- kinds of cells
@case(r"bad.msh has no cells of a volume \(24 quad\): mesh the body in 3D")
def a_surface(folder):
    return write_gmsh(folder / "bad.msh", BOX.vertices, [("quad", BOX.boundary, 1)])


@case(r"bad.msh has no cells of a volume \(no cells\)")
def points_only(folder):
    return write_gmsh(folder / "bad.msh", BOX.vertices, [])


@case("bad.msh mixes tetrahedra and hexahedra .8 hexahedron, 1 tetra.")
def mixed(folder):
    points = np.concatenate([BOX.vertices, np.add(TETRA, 5.0)])
    return write_gmsh(
        folder / "bad.msh", points, [("hexahedron", BOX.cells, 1), ("tetra", [range(27, 31)], 1)]
    )


@case("bad.msh holds cells of kind wedge .in all: 8 hexahedron, 1 wedge.; allowed are")
def wedges(folder):
    cells = [("hexahedron", BOX.cells, 1), ("wedge", [range(6)], 1)]
    return write_gmsh(folder / "bad.msh", BOX.vertices, cells)


@case("bad.vtu holds cells of kind pyramid ")
def pyramids(folder):
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)]
    meshio.write(folder / "bad.vtu", meshio.Mesh(points, [("pyramid", [range(5)])]))
    return folder / "bad.vtu"


@case("bad.vtu holds cells of kinds that cannot be read .voxels")
def voxels(folder):
    """Cells of type 11, which meshio skips with a warning."""
    path = folder / "bad.vtu"
    meshio.vtu.write(
        str(path), meshio.Mesh(BOX.vertices, [("hexahedron", BOX.cells)]), compression=None
    )
    hexahedra, others = (
        base64.b64encode(np.uint32(64).tobytes() + np.full(8, kind).tobytes()).decode()
        for kind in (12, 11)
    )
    return edited(folder, path, (re.escape(hexahedra), others))


@case("bad.vtu has 2 pieces; only one can be read")
def two_pieces(folder):
    return edited(folder, DATA / "prism_tet_1.vtu", (r"(<Piece.*</Piece>)", r"\1\1"))


# ----------------------------------------------------------- vertices, cells
@case(r"bad.msh: 1 vertices, the first of them number 13, .* not finite: \[0.5, nan, 0.5\]")
def not_a_number(folder):
    points = BOX.vertices.copy()
    points[13, 1] = np.nan
    return box(folder, points)


@case(r"bad.inp: 1 vertices, the first of them number 4, have .* not finite: \[.*inf.*\]")
def infinite(folder):
    return edited(folder, DATA / "prism_hex_1.inp", (r"^5, 0,", "5, inf,"))


@case(r"bad.msh: 9 pairs of vertices .* X = \(1, 0, 0\) m \(vertices 18 and 27\).*Coherence")
def parts_that_are_not_joined(folder):
    points = np.concatenate([BOX.vertices, np.add(BOX.vertices, [1.0 + 1e-11, 0.0, 0.0])])
    return box(folder, points, np.concatenate([BOX.cells, BOX.cells + 27]))


@case(r"bad.msh: 3 of 8 cells are inverted, the first of them number 1 at X = \(0.25, 0.25, 0.75\)")
def some_inverted(folder):
    cells = BOX.cells.copy()
    cells[[1, 4, 6]] = cells[[1, 4, 6]][:, [4, 5, 6, 7, 0, 1, 2, 3]]
    return box(folder, cells=cells)


@case(r"bad.msh: [1-8] of 8 cells are inverted, .*smallest Jacobian -")
def folded(folder):
    points = BOX.vertices.copy()
    points[13] = [1.4, 0.5, 0.5]
    return box(folder, points)


@case(r"bad.msh: 1 cells are flat \(no volume\), .* number 1 at X = \(1.25, 1.25, 1\) m")
def flat(folder):
    points = [*TETRA, (0.5, 0.5, 1), (2, 1, 1), (1, 2, 1), (1.5, 1.5, 1)]
    return write_gmsh(folder / "bad.msh", points, [("tetra", [range(4), range(4, 8)], 1)])


@case(r"bad.msh: 1 cells, the first of them number 2 at .*, use a vertex twice \(a wedge")
def collapsed(folder):
    cells = BOX.cells.copy()
    cells[2, 3], cells[2, 7] = cells[2, 2], cells[2, 6]
    return box(folder, cells=cells)


@case(r"bad.msh: 1 cells are there twice, .* number 5 at X = \(0.75, 0.25, 0.75\)")
def the_same_cell_twice(folder):
    turned = BOX.cells[[5]][:, [1, 2, 3, 0, 5, 6, 7, 4]]
    return box(folder, cells=np.concatenate([BOX.cells, turned]))


@case(r"bad.msh: 1 facets belong to more than two cells, the first at X = \(0.3.*\) m to 3")
def three_cells_at_a_facet(folder):
    points = [*TETRA, (0, 0, -1), (0.2, 0.2, -2)]
    cells = [(0, 1, 2, 3), (0, 2, 1, 4), (0, 2, 1, 5)]
    return write_gmsh(folder / "bad.msh", points, [("tetra", cells, 1)])


@case(r"bad.msh: 1 pairs of cells on the same side .* overlap; the first are cells 0 and 1 at")
def overlapping(folder):
    points = [*TETRA, (0.2, 0.2, 2)]
    return write_gmsh(
        folder / "bad.msh", points, [("tetra", [(0, 1, 2, 3), (0, 1, 2, 4)], 1)]
    )


@case("bad.vtu: 1 cells, the first of them number 3, use vertices that .* .it has 27.")
def a_vertex_that_is_not_there(folder):
    cells = BOX.cells.copy()
    cells[3, 6] = 27
    meshio.vtu.write(
        str(folder / "bad.vtu"), meshio.Mesh(BOX.vertices, [("hexahedron", cells)])
    )
    return folder / "bad.vtu"


@case("bad.msh cannot be read as Gmsh 2.2: .*index 77")
def a_vertex_that_is_not_there_in_gmsh(folder):
    cells = BOX.cells.copy()
    cells[3, 6] = 77
    return box(folder, cells=cells)


# --------------------------------------------------------------------- tags
@case(r"bad.msh: tag 'pull' has no facets; tags with facets are \['hold', 'wall'\]")
def empty_tag(folder):
    return box(folder, wall=BOX.faces["X-"], pull=[], hold=BOX.faces["Y-"])


@case(r"save_all_22.msh: tag 'clamped' has no facets; .*without Mesh.SaveAll")
def groups_dropped_by_gmsh(folder):
    return DATA / "save_all_22.msh"


@case("save_all_41.msh cannot be read as Gmsh 4.1: .*save without Mesh.SaveAll")
def groups_that_meshio_cannot_read(folder):
    return DATA / "save_all_41.msh"


@case(r"bad.msh: tag 'cut': 4 of its 8 facets .* \(4 lie between two cells, 0 .*'cut', 'hold'\]")
def inner_tag(folder):
    inner = BOX.cells[[4, 5, 6, 7]][:, [0, 4, 7, 3]]
    return box(folder, hold=BOX.faces["Y-"], cut=np.concatenate([BOX.faces["X-"], inner]))


@case(r"bad.msh: tag 'cut': 1 of its 5 facets .*\(0 lie between two cells, 1 are no facet of any\)")
def tag_beside_the_body(folder):
    return box(folder, cut=np.concatenate([BOX.faces["X-"], [[0, 2, 8, 6]]]))


@case(r"bad.msh: tags 'hold' and 'lift' share 4 facets, the first at X = \(.*\) m; a facet")
def overlapping_tags(folder):
    both = np.concatenate([BOX.faces["X-"], BOX.faces["Y-"]])
    return box(folder, hold=BOX.faces["Y-"], lift=both)


@case("bad.msh: tags 'slant' and 'top side' share 4 facets, the first at")
def a_surface_in_two_groups(folder):
    """In MSH 4.1 only the entity says so: its cells are there once."""
    source = DATA / "prism_hex_1_41_text.msh"
    return edited(folder, source, (r"^(17 1.5 0 0 2 1 1.5) 1 2 ", r"\1 2 2 3 "))


@case("bad.msh: tags 'slant' and 'top side' share 4 facets, the first at X")
def cells_in_two_groups(folder):
    """In MSH 2.2 they are there twice."""
    source = DATA / "prism_hex_1_22_text.msh"
    text = source.read_text()
    slant = re.findall(r"^\d+( 3 2) 2( .*)$", text, re.M)
    again = "".join(f"{900 + k}{kind} 3{rest}\n" for k, (kind, rest) in enumerate(slant))
    count = int(re.search(r"\$Elements\n(\d+)", text).group(1))
    return edited(
        folder,
        source,
        (r"\$Elements\n\d+", f"$Elements\n{count + len(slant)}"),
        (r"\$EndElements", again + "$EndElements"),
    )


@case("bad.msh: tag 'hold' has 1 cells of kind triangle and the body is made of .* kind quad")
def triangles_on_hexahedra(folder):
    cells = [("triangle", [BOX.faces["X-"][0, :3]], 1), ("hexahedron", BOX.cells, 2)]
    return write_gmsh(folder / "bad.msh", BOX.vertices, cells, [(2, 1, "hold")])


@case("bad.msh: two physical surfaces are both named 'slant'")
def a_name_twice(folder):
    return edited(folder, TEXT, ('"clamped"', '"slant"'))


@case("bad.msh: .PhysicalNames has the line '2 1 clamped'; wanted: dimension number")
def a_name_without_quotes(folder):
    return edited(folder, TEXT, ('"clamped"', "clamped"))


@case("bad.msh: part of the boundary has no tag and both .'boundary', 'untagged'. are taken")
def no_name_left(folder):
    return box(folder, boundary=BOX.faces["Y-"], untagged=BOX.faces["Y+"])


@case(r"bad.vtu: each of the arrays \['part', 'zone'\] may number the tags")
def two_arrays_of_tags(folder):
    cells = [("quad", BOX.faces["X-"]), ("hexahedron", BOX.cells)]
    data = {name: [np.full(4, 2), np.full(8, 3)] for name in ("part", "zone")}
    meshio.write(folder / "bad.vtu", meshio.Mesh(BOX.vertices, cells, cell_data=data))
    return folder / "bad.vtu"


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_gets_one_clear_error(tmp_path, capfd, name):
    make, named = BAD[name]
    path = make(tmp_path)
    with pytest.raises(InputError) as caught:
        MeshFile(path).mesh(AS_MESHED)
    said = str(caught.value)
    assert re.search(named, said), said
    assert "\n" not in said
    assert capfd.readouterr() == ("", "")


def test_there_are_enough_of_them():
    assert len(BAD) >= 40
    assert len({named for _, named in BAD.values()}) >= len(BAD) - 1


def test_the_good_ones_they_are_made_from_are_read(tmp_path):
    """So that it is the change that is refused."""
    for path in (TEXT, TEXT_41, DATA / "prism_tet_1.vtu", DATA / "prism_tet_1.inp"):
        assert len(MeshFile(path).mesh(AS_MESHED).cells) == 150
    assert len(MeshFile(box(tmp_path, hold=BOX.faces["Y-"])).mesh(AS_MESHED).cells) == 8
    assert len(MeshFile(write_mesh(tmp_path / "b.msh", BOX)).mesh(AS_MESHED).boundary) == 24


@pytest.mark.parametrize("unit", ["km", "", 0.0, -1.0, np.inf, np.nan])
def test_a_unit_that_is_none_is_refused(unit):
    with pytest.raises(InputError, match=r"unit = .* allowed are m, .*, ft, or a positive number"):
        MeshFile(TEXT, unit)


def test_hexahedra_that_cross_the_edges_of_a_facet_are_refused():
    """Two cells around the same four vertices in different orders."""
    low, high = [0, 1, 2, 3, 4, 5, 6, 7], [4, 6, 5, 7, 8, 9, 10, 11]
    points = np.random.default_rng(0).uniform(size=(12, 3))
    with pytest.raises(InputError, match=r"do not agree on the edges .* cells 0 and 1"):
        boundary_facets("bad.msh", points, np.array([low, high]), HEXAHEDRON)
