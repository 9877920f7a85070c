"""Legal features of Gmsh and VTU files that are not read: each has a name and a way out.

So that a file is called damaged only where it is.
"""

from __future__ import annotations

import re
from pathlib import Path

import meshio.gmsh.common

from sphsolid.errors import InputError, require

#: Pattern of what a reader of meshio says, and what to say of the feature behind it.
Reasons = tuple[tuple[str, str], ...]

_KNOWN = "|".join(str(number) for number in meshio.gmsh.common._gmsh_to_meshio_type)
GMSH_REASONS: Reasons = (
    (
        "Incompatible cell data 'gmsh:physical'",
        "it was saved with Mesh.SaveAll and some of its entities are in no physical "
        "group, which meshio cannot read; save without Mesh.SaveAll",
    ),
    (
        "parametric nodes",
        "its nodes have parametric coordinates (Mesh.SaveParametric), which are not read; save "
        "it without them",
    ),
    (
        rf"^KeyError (np\.int32\()?(?!({_KNOWN})\b)\d+",
        "it has elements of a type that is not read, such as those of an order above two; save it "
        "with Mesh.ElementOrder = 1 or 2",
    ),
    (
        "^ReadError *$|^ValueError all the input array dimensions",
        "its nodes are not numbered 1, 2, 3, ..., or it is partitioned, which a binary file of "
        "2.2 is not read with; save the mesh as MSH 4.1, without partitions",
    ),
)
VTU_REASONS: Reasons = (
    (
        "combinations of polyhedra|single set of cells",
        "it holds polyhedra, which are not read; mesh the body with tetrahedra or hexahedra "
        "(ParaView: Tetrahedralize)",
    ),
    (
        "Unknown VTU file version",
        "files of this version of the format are not read; save it as version 1.0 or 0.1",
    ),
    (
        "Illegal data type",
        "it has arrays that are no numbers, such as text; save it without them",
    ),
    (
        r"DataArray\[@offset",
        "its appended raw data are laid out in a way that is not read; save it as ASCII or "
        "base64 (ParaView: Data Mode)",
    ),
    ("NoneType.*strip", "one of its arrays is empty, as in a grid without cells"),
    (
        "Expected type UnstructuredGrid",
        "it is VTK of another kind; save it as an unstructured grid (ParaView: Append Datasets)",
    ),
)


def refuse_gmsh_features(path: Path, data: bytes) -> None:
    """Raises ``InputError`` for what can be told from the text of a ``.msh`` file."""
    require(
        not data.startswith((b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff")),
        f"{path} begins with a byte order mark, which is not read; save it without (as UTF-8 "
        "without BOM, or ASCII)",
    )
    require(
        re.match(rb"\s*\$NOD\b", data) is None,
        f"{path} is in Gmsh format 1; allowed are 2.2 and 4.1: save it with "
        "Mesh.MshFileVersion = 4.1",
    )
    require(
        not _has(data, "PartitionedEntities"),
        f"{path} is partitioned (Mesh.Partition), which is not read in MSH 4.1; save it without "
        "partitions (Gmsh: Unpartition, then save)",
    )
    require(
        not _has(data, "ParametricNodes"),
        f"{path} has nodes with parametric coordinates (Mesh.SaveParametric), which are not read; "
        "save it without them",
    )
    names = re.search(rb"^\$PhysicalNames\b(.*?)^\$EndPhysicalNames", data, re.M | re.S)
    try:
        (names.group(1) if names else b"").decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: names of physical groups are not in UTF-8 ({error.reason}); give them names "
            "of plain letters, or save the file as UTF-8"
        ) from error
    if re.match(rb".*?^\$MeshFormat\s+2\S*\s+0\s", data, re.M | re.S):
        _refuse_one_partition(path, data)


def _refuse_one_partition(path: Path, data: bytes) -> None:
    """A text file of MSH 2.2 whose elements all belong to one partition is one of several."""
    section = re.search(rb"^\$Elements\s+\d+\s(.*?)^\$EndElements", data, re.M | re.S)
    if section is None:
        return
    owners = set()
    for line in section.group(1).strip().split(b"\n"):
        # number kind tags group entity partitions owner ...
        words = line.split(None, 7)
        if len(words) < 8 or not words[2].isdigit() or int(words[2]) < 4:
            return
        owners.add(words[6])
        if len(owners) > 1:
            return
    require(
        len(owners) != 1,
        f"{path} holds one partition of a mesh that was saved in several files "
        "(Mesh.PartitionSplitMeshFiles); save the whole body in one file, without partitions",
    )


def refuse_vtu_features(path: Path, data: bytes) -> None:
    """Raises ``InputError`` for what can be told from the text of a ``.vtu`` file."""
    text = re.search(rb"""<Array\b[^>]*""", data.partition(b"<AppendedData")[0])
    if text is not None:
        name = re.search(rb"""Name\s*=\s*["']([^"']*)""", text.group())
        raise InputError(
            f"{path}: its array {(name.group(1) if name else b'').decode(errors='replace')!r} is "
            "text and no numbers (<Array>), which is not read; save it without (ParaView: Pass "
            "Arrays)"
        )
    begin = data.index(b"<VTKFile")
    head = data[begin : data.index(b">", begin)]
    compressor = re.search(rb"""compressor\s*=\s*["'](\w+)""", head)
    if compressor is not None:
        name = compressor.group(1).decode()
        require(
            name in ("vtkZLibDataCompressor", "vtkLZMADataCompressor"),
            f"{path} is compressed with {name}, which is not read; save it with ZLib, LZMA or "
            "without compression",
        )
    require(
        re.search(rb"""<(DataArray|Array)\b[^>]*\bName\s*=\s*["']faces["']""", data) is None
        or not _polyhedra(data),
        f"{path} holds polyhedra, which are not read: mesh the body with tetrahedra or hexahedra "
        "(ParaView: Tetrahedralize)",
    )


def _polyhedra(data: bytes) -> bool:
    """Whether an array of faces of polyhedra that stands in plain text is not empty."""
    text = re.search(
        rb"""<DataArray\b[^>]*\bName\s*=\s*["']faces["'][^>]*>([^<]*)</DataArray>""", data
    )
    return text is not None and bool(text.group(1).strip())


def _has(data: bytes, section: str) -> bool:
    return re.search(rb"^\$" + section.encode() + rb"\s*$", data, re.M) is not None
