"""Legal Gmsh and VTU files: read as their plain twins are, or refused by what they have more."""

from __future__ import annotations

import base64
import re
import struct
import zlib
from pathlib import Path

import meshio
import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile
from tests.oracles.gmsh_text import write_mesh

DATA = Path(__file__).parents[2] / "data" / "meshes"
HEX_22, HEX_41 = (DATA / f"prism_hex_1_{version}_text.msh" for version in (22, 41))
BINARY_41 = DATA / "prism_hex_1_41_binary.msh"
MESH = Box().mesh(0.5)


def changed(tmp_path: Path, source: Path, *changes: tuple[bytes, bytes]) -> Path:
    data = source.read_bytes()
    for old, new in changes:
        data, count = re.subn(old, new, data, count=1, flags=re.M | re.S)
        assert count == 1, old
    path = tmp_path / f"body{source.suffix}"
    path.write_bytes(data)
    return path


def refused(path: Path, named: str) -> None:
    with pytest.raises(InputError) as caught:
        MeshFile(path).read()
    said = str(caught.value)
    assert re.search(named, said), said
    assert "truncated" not in said
    assert "damaged" not in said
    assert "\n" not in said


# --------------------------------------------------------------------- Gmsh
@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("partitioned_41", "is partitioned .Mesh.Partition., .* save it without partitions"),
        ("one_of_two_22", "holds one partition of a mesh that was saved in several files"),
        ("parametric_22", "nodes with parametric coordinates .* save it without them"),
        ("parametric_41", "nodes have parametric coordinates .* save it without them"),
    ],
)
def test_a_gmsh_file_is_refused_by_its_feature(name, named):
    refused(DATA / f"{name}.msh", named)


def test_a_whole_partitioned_file_of_22_is_read():
    mesh = MeshFile(DATA / "partitioned_22.msh").read().mesh
    assert MeshFile(DATA / "partitioned_22.msh").volume == pytest.approx(2.625, rel=1e-14)
    assert set(mesh.faces) == {"clamped", "slant", "top side", "boundary"}


PERIODIC = b"$Periodic\n1\n0 1 2\n0\n1\n1 2\n$EndPeriodic\n"
GMSH_READ = {
    "line ends of Windows": [],
    "comments at the beginning": [(rb"\A", b"$Comments\nby hand\n$EndComments\n")],
    "sections that are not known": [(rb"\Z", b"$Mine\n1 2 3\n$EndMine\n")],
    "periodic nodes": [(rb"\Z", PERIODIC)],
    "results at some nodes and cells": [
        (
            rb"\Z",
            b'$NodeData\n1\n"T"\n1\n0.0\n3\n0\n1\n2\n3 1.0\n9 2.0\n$EndNodeData\n'
            b'$ElementData\n1\n"e"\n1\n0.0\n3\n0\n1\n1\n7 1.0\n$EndElementData\n',
        )
    ],
    "a group that turns its surfaces": [(rb"^(17 1.5 0 0 2 1 1.5) 1 2 ", rb"\1 1 -2 ")],
}


@pytest.mark.parametrize("name", GMSH_READ)
def test_a_gmsh_file_is_read(tmp_path, name):
    path = changed(tmp_path, HEX_41, *GMSH_READ[name])
    if name == "line ends of Windows":
        path.write_bytes(HEX_41.read_bytes().replace(b"\n", b"\r\n"))
    plain, mesh = MeshFile(HEX_41).read().mesh, MeshFile(path).read().mesh
    np.testing.assert_array_equal(mesh.vertices, plain.vertices)
    assert {tag: len(facets) for tag, facets in mesh.faces.items()} == {
        tag: len(facets) for tag, facets in plain.faces.items()
    }


@pytest.mark.parametrize(
    ("source", "changes", "named"),
    [
        (HEX_22, [(rb"\A", b"\xef\xbb\xbf")], "begins with a byte order mark"),
        (HEX_22, [(rb'"slant"', b'"schr\xe4g"')], "names of physical groups are not in UTF-8"),
        (HEX_22, [(rb"\A.*(?=\$Nodes)", b""), (rb"\$Nodes", b"$NOD")],
         "is in Gmsh format 1; allowed are 2.2 and 4.1"),
        (HEX_22, [(rb"^(\d+) 5 2 ", rb"\1 140 2 ")], "elements of a type that is not read"),
        (HEX_41, [(rb"^3 1 5 ", rb"3 1 140 ")], "elements of a type that is not read"),
        (BINARY_41, [(rb"^\$EndEntities\n",
                      b"$EndEntities\n$PartitionedEntities\n$EndPartitionedEntities\n")],
         "is partitioned"),
    ],
)  # fmt: skip
def test_a_changed_gmsh_file_is_refused_by_its_feature(tmp_path, source, changes, named):
    refused(changed(tmp_path, source, *changes), named)


def test_a_binary_file_whose_nodes_have_gaps_in_their_numbers(tmp_path):
    """In 2.2; the parts of a mesh that was saved in several files are such."""
    data = (DATA / "prism_hex_1_22_binary.msh").read_bytes()
    at = data.index(b"$Nodes\n36\n") + len(b"$Nodes\n36\n") + 35 * 28
    path = tmp_path / "body.msh"
    path.write_bytes(data[:at] + struct.pack("<i", 99) + data[at + 4 :])
    refused(path, r"nodes are not numbered 1, 2, 3, .* as MSH 4\.1")


# ---------------------------------------------------------------------- VTU
def vtu(tmp_path: Path, types=(12,) * 8, cells=MESH.cells, more: str = "") -> Path:
    """The eight cubes in plain text, with other numbers of their kinds if given."""
    ends = np.cumsum([len(row) for row in cells])
    flat = " ".join(str(node) for row in cells for node in row)
    array = '<DataArray type="{}" Name="{}" format="ascii" {}>{}</DataArray>'
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" '
        'byte_order="LittleEndian">\n<UnstructuredGrid>'
        f'<Piece NumberOfPoints="27" NumberOfCells="{len(types)}">\n<Points>'
        + array.format("Float64", "Points", 'NumberOfComponents="3"',
                       " ".join(repr(x) for x in MESH.vertices.ravel().tolist()))
        + "</Points>\n<Cells>" + array.format("Int64", "connectivity", "", flat)
        + array.format("Int64", "offsets", "", " ".join(map(str, ends)))
        + array.format("UInt8", "types", "", " ".join(map(str, types)))
        + more + "</Cells>\n</Piece></UnstructuredGrid>\n</VTKFile>\n"
    )  # fmt: skip
    path = tmp_path / "body.vtu"
    path.write_text(text)
    return path


def appended(tmp_path: Path, encoding: str, header: str, compressed: bool) -> Path:
    """The eight cubes with their numbers at the end of the file."""
    arrays = {
        "Points": MESH.vertices, "connectivity": MESH.cells.ravel(),
        "offsets": 8 * np.arange(1, 9), "types": np.full(8, 12, np.uint8),
    }  # fmt: skip
    size = {"UInt32": "<I", "UInt64": "<Q"}[header]
    offsets, data = [], b""
    for values in arrays.values():
        offsets.append(len(data))
        parts = [struct.pack(size, values.nbytes), values.tobytes()]
        if compressed:
            packed = zlib.compress(values.tobytes())
            numbers = (1, values.nbytes, 0, len(packed))
            parts = [b"".join(struct.pack(size, n) for n in numbers), packed]
        elif encoding == "base64":
            parts = [b"".join(parts)]
        data += b"".join(base64.b64encode(p) if encoding == "base64" else p for p in parts)
    tags = [
        f'<DataArray type="{kind}" Name="{name}" {extra} format="appended" offset="{offset}"/>'
        for kind, name, extra, offset in zip(
            ("Float64", "Int64", "Int64", "UInt8"), arrays,
            ('NumberOfComponents="3"', "", "", ""), offsets, strict=True,
        )
    ]  # fmt: skip
    packing = 'compressor="vtkZLibDataCompressor"' if compressed else ""
    head = (
        f'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
        f'header_type="{header}" {packing}><UnstructuredGrid><Piece NumberOfPoints="27" '
        f'NumberOfCells="8"><Points>{tags[0]}</Points><Cells>{"".join(tags[1:])}</Cells></Piece>'
        f'</UnstructuredGrid>\n<AppendedData encoding="{encoding}">\n_'
    )
    path = tmp_path / "body.vtu"
    path.write_bytes(head.encode() + data + b"\n</AppendedData>\n</VTKFile>\n")
    return path


@pytest.mark.parametrize("encoding", ["raw", "base64"])
@pytest.mark.parametrize("header", ["UInt32", "UInt64"])
@pytest.mark.parametrize("compressed", [False, True])
def test_appended_data_are_read(tmp_path, encoding, header, compressed):
    mesh = MeshFile(appended(tmp_path, encoding, header, compressed)).read().mesh
    np.testing.assert_array_equal(mesh.vertices, MESH.vertices)
    np.testing.assert_array_equal(mesh.cells, MESH.cells)


@pytest.mark.parametrize("compression", [None, "zlib", "lzma"])
def test_binary_data_are_read_compressed_or_not(tmp_path, compression):
    path = tmp_path / "body.vtu"
    cells = [("quad", MESH.faces["X+"]), ("hexahedron", MESH.cells)]
    mesh = meshio.Mesh(MESH.vertices, cells, cell_data={"end": [np.ones(4, int), np.zeros(8, int)]})
    meshio.vtu.write(str(path), mesh, compression=compression)
    assert {tag: len(facets) for tag, facets in MeshFile(path).read().mesh.faces.items()} == {
        "end": 4, "boundary": 20
    }  # fmt: skip


def test_marks_and_quotes_of_xml_do_not_matter(tmp_path):
    plain = vtu(tmp_path).read_text()
    for text in ("\ufeff" + plain, plain.replace('"', "'"), plain.replace("\n", "\r\n"),
                 plain.replace("<VTK", f"<!-- {'x' * 5000} --><VTK"),
                 plain + f"<!-- {'x' * 5000} -->"):  # fmt: skip
        path = tmp_path / "other.vtu"
        path.write_text(text, encoding="utf-8", newline="")
        assert MeshFile(path).volume == pytest.approx(1.0, rel=1e-15)


def faces_of_polyhedra() -> str:
    rows, ends = [], []
    for cell in MESH.cells:
        quads = [cell[list(q)] for q in ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5),
                                         (2, 3, 7, 6), (3, 0, 4, 7))]  # fmt: skip
        rows += [6, *(n for quad in quads for n in (4, *quad))]
        ends.append(len(rows))
    return "".join(
        f'<DataArray type="Int64" Name="{name}" format="ascii">{" ".join(map(str, values))}'
        "</DataArray>"
        for name, values in (("faces", rows), ("faceoffsets", ends))
    )


def test_a_vtu_file_is_refused_by_its_feature(tmp_path):
    wide = [*MESH.cells[:7], MESH.cells[7][:4]]
    refused(vtu(tmp_path, (42,) * 8, more=faces_of_polyhedra()), "holds polyhedra, .*Tetrahedral")
    refused(vtu(tmp_path, (42, *(12,) * 7), more=faces_of_polyhedra()), "polyhedra")
    refused(vtu(tmp_path, (*(12,) * 7, 11)), "kinds that cannot be read .voxels")
    refused(vtu(tmp_path, (*(12,) * 7, 10), wide), "mixes tetrahedra and hexahedra .7 hexa")
    refused(vtu(tmp_path, (72,) * 8), "cells of kind VTK_LAGRANGE_HEXAHEDRON")
    refused(vtu(tmp_path, (), []), "one of its arrays is empty")
    text = vtu(tmp_path).read_text()
    for old, new, named in (
        ('version="0.1"', 'version="2.3"', "this version of the format .* save it as version"),
        ("byte_order", 'compressor="vtkLZ4DataCompressor" byte_order', "vtkLZ4.* save it with"),
        ("<UnstructuredGrid>", '<UnstructuredGrid><FieldData><DataArray type="String" Name="a" '
         'format="ascii">65 0</DataArray></FieldData>', "arrays that are no numbers, such as text"),
    ):  # fmt: skip
        (tmp_path / "body.vtu").write_text(text.replace(old, new, 1))
        refused(tmp_path / "body.vtu", named)


#: An array on the cells or points, and how the file is refused, if it is.
ARRAYS = {
    "hidden": ("CellData", "vtkGhostType", [32, *[0] * 7],
               r"1 cells are ghosts by the array 'vtkGhostType' \(1 hidden, .* Threshold on"),
    "duplicate": ("CellData", "vtkGhostType", [0, 1, 1, *[0] * 5], "2 cells are ghosts"),
    "both": ("CellData", "vtkGhostType", [33] * 8, "8 cells are ghosts"),
    "of an old version": ("CellData", "vtkGhostLevels", [*[0] * 7, 1], "'vtkGhostLevels'"),
    "none": ("CellData", "vtkGhostType", [0] * 8, ""),
    "hidden points": ("PointData", "vtkGhostType", [2, *[0] * 26], "1 points are hidden"),
    "duplicate points": ("PointData", "vtkGhostType", [1, *[0] * 26], ""),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_cells_that_are_marked_as_none_of_the_body_are_refused(tmp_path, name):
    where, array, values, named = ARRAYS[name]
    path = vtu(tmp_path)
    data = f'<DataArray type="UInt8" Name="{array}" format="ascii">{" ".join(map(str, values))}'
    path.write_text(path.read_text().replace(
        "</Piece>", f"<{where}>{data}</DataArray></{where}></Piece>"
    ))  # fmt: skip
    if named:
        refused(path, named)
    else:
        assert len(MeshFile(path).read().mesh.cells) == 8


@pytest.mark.parametrize(("before", "holder"), [("<Piece", "FieldData"), ("</Piece>", "CellData")])
def test_an_array_of_text_is_refused_by_its_name(tmp_path, before, holder):
    path = vtu(tmp_path)
    text = '<Array type="String" Name="part" format="ascii">98 111 120 0</Array>'
    path.write_text(path.read_text().replace(before, f"<{holder}>{text}</{holder}>{before}", 1))
    refused(path, r"its array 'part' is text and no numbers .* save it without")


def test_a_byte_order_mark_before_xml_is_no_news(tmp_path):
    path = vtu(tmp_path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert len(MeshFile(path).read().mesh.cells) == 8


def test_voxels_in_single_quotes_are_not_lost(tmp_path):
    """meshio leaves them out; their number gives it away."""
    path = vtu(tmp_path, (*(12,) * 7, 11))
    path.write_text(path.read_text().replace('"', "'"))
    refused(path, "kinds that cannot be read")


def test_only_what_has_no_end_is_called_truncated(tmp_path):
    whole = write_mesh(tmp_path / "box.msh", MESH).read_bytes()
    for share in (0.2, 0.5, 0.9):
        path = tmp_path / "body.msh"
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(InputError, match="is truncated"):
            MeshFile(path).read()
