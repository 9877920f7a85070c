"""Gmsh and VTU files through meshio: the one place that knows what meshio does and leaves undone.

Each reader is called by itself: ``meshio.read`` tries several formats on a ``.msh`` file, prints
blank lines for those that fail and ends the process when none fits.
"""

from __future__ import annotations

import contextlib
import io
import re
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from sphsolid.errors import InputError, require
from sphsolid.geometry.file_content import SURFACE_CORNERS, Block, FileContent, Indices
from sphsolid.geometry.unread_features import (
    GMSH_REASONS,
    VTU_REASONS,
    Reasons,
    refuse_gmsh_features,
    refuse_vtu_features,
)

#: Arrays that number surfaces; the first of these that a VTU file has is taken before any other.
TAG_ARRAYS = ("gmsh:physical", "tag", "tags", "boundary", "facet", "CellEntityIds", "medit:ref")
#: Sections of a Gmsh file that hold results.
_RESULTS = re.compile(
    rb"^\$(NodeData|ElementData|ElementNodeData|InterpolationScheme)\s*$.*?^\$End\1\s*?$",
    re.M | re.S,
)
#: Integer arrays that never name a part of the boundary.
_NEVER_TAGS = ("gmsh:geometrical", "vtkOriginalCellIds", "GlobalIds", "vtkGhostType")


def read_gmsh(path: Path) -> FileContent:
    """Gmsh ``.msh`` 2.2 or 4.1, text or binary: the physical surfaces are the tags.

    Their names come from ``$PhysicalNames``, read here because meshio keeps one name where a
    surface and a volume share it; a physical surface without a name is called by its number.
    """
    data = path.read_bytes()
    refuse_gmsh_features(path, data)
    header = re.match(rb"\s*(?:\$Comments.*?\$EndComments\s*)?\$MeshFormat\s+(\S+)", data, re.S)
    if header is None:
        raise InputError(f"{path} is not a Gmsh mesh: it does not begin with $MeshFormat")
    version = header.group(1).decode(errors="replace")
    require(
        version in ("2", "2.2", "4.1"),
        f"{path} is in Gmsh format {version}; allowed are 2.2 and 4.1: save it with "
        "Mesh.MshFileVersion = 4.1",
    )
    for section in (b"MeshFormat", b"PhysicalNames", b"Entities", b"Nodes", b"Elements"):
        opened = re.search(rb"^\$" + section + rb"\s*$", data, re.M) is not None
        name = section.decode()
        require(
            opened or section not in (b"Nodes", b"Elements"),
            f"{path} has no section ${name}: it is truncated, or was saved without a mesh; "
            "mesh the model in 3D and save it again",
        )
        require(
            not opened or b"$End" + section in data,
            f"{path} is truncated: its section ${name} has no $End{name}; copy or save it again",
        )
    names = _physical_names(path, data)
    mesh = _without_results(path, data, f"Gmsh {version}")
    tags: dict[str, list[Block]] = {name: [] for name in names.values()}
    numbers = mesh.cell_data.get("gmsh:physical")
    # A surface in two groups: 2.2 repeats its cells, 4.1 says so in the cell sets only.
    sets = {
        name: mesh.cell_sets[name]
        for name in tags
        if name in mesh.cell_sets and mesh.field_data[name][1] == 2
    }
    for k, block in enumerate(mesh.cells):
        if block.type not in SURFACE_CORNERS:
            continue
        members: dict[str, Indices] = {}
        if numbers is not None:
            # A negative number turns the elements of its group round.
            for number, rows in by_number(np.abs(numbers[k])):
                members[names.get(number, str(number))] = rows
        for name, its in sets.items():
            if len(its[k]):
                rows = np.asarray(its[k]).astype(np.int64)
                members[name] = np.union1d(members.get(name, rows), rows)
        for name, rows in members.items():
            tags.setdefault(name, []).append(Block(block.type, _index(block.data[rows])))
    return FileContent(
        mesh.points,
        _blocks(mesh),
        {name: tuple(blocks) for name, blocks in tags.items()},
        way_out="mesh the body in 3D; where Gmsh has physical groups it saves only those: put the "
        "volume into one, too",
    )


def _without_results(path: Path, data: bytes, what: str) -> Any:
    """The mesh of a Gmsh file, from a copy without results, if it has any.

    meshio takes results only where every node or element has one.
    """
    if (bare := _RESULTS.sub(b"", data)) == data:
        return read_guarded(meshio.gmsh.read, path, what, GMSH_REASONS)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "mesh.msh"
        copy.write_bytes(bare)
        return read_guarded(lambda _: meshio.gmsh.read(str(copy)), path, what, GMSH_REASONS)


def _physical_names(path: Path, data: bytes) -> dict[int, str]:
    """Number -> name of the physical surfaces."""
    section = re.search(rb"^\$PhysicalNames\s+\d+\s(.*?)\$EndPhysicalNames", data, re.M | re.S)
    names: dict[int, str] = {}
    if section is None:
        return names
    for line in section.group(1).decode("utf-8", errors="replace").strip().splitlines():
        entry = re.fullmatch(r'\s*([0-3])\s+(-?\d+)\s+"(.*)"\s*', line)
        if entry is None:
            raise InputError(
                f"{path}: $PhysicalNames has the line {line.strip()!r}; "
                'wanted: dimension number "name"'
            )
        if entry.group(1) == "2":
            name = entry.group(3)
            require(
                name not in names.values(),
                f"{path}: two physical surfaces are both named {name!r}; give each its own name",
            )
            names[int(entry.group(2))] = name
    return names


def read_vtu(path: Path) -> FileContent:
    """VTK ``.vtu``: integer arrays on the surface cells are the tags.

    An array of zeros and ones is a tag of the array's name; one with other values numbers tags,
    which are called by their number, where zero and negative are no tag.  Raises ``InputError``
    if several arrays number tags and none has one of the names ``TAG_ARRAYS``.
    """
    data = path.read_bytes()
    require(b"<VTKFile" in data, f"{path} is not a VTK XML file: it has no <VTKFile>")
    require(
        b"</VTKFile>" in data,
        f"{path} is truncated: it does not end with </VTKFile>; copy or save it again",
    )
    refuse_vtu_features(path, data)
    pieces = re.findall(rb"<Piece\b[^>]*>", data)
    # meshio keeps the cells of the last piece and says nothing.
    require(
        len(pieces) <= 1,
        f"{path} has {len(pieces)} pieces; only one can be read: merge them before writing "
        "(ParaView: Merge Blocks)",
    )
    mesh = read_guarded(meshio.vtu.read, path, "VTU", VTU_REASONS)
    polyhedra = sum(len(b.data) for b in mesh.cells if b.type.startswith("polyhedron"))
    require(
        polyhedra == 0,
        f"{path} holds {polyhedra} polyhedra, which are not read: mesh the body with tetrahedra or "
        "hexahedra (ParaView: Tetrahedralize)",
    )
    count = sum(len(block.data) for block in mesh.cells)
    declared = re.search(rb"""NumberOfCells\s*=\s*["']\s*(\d+)""", pieces[0]) if pieces else None
    require(
        declared is None or int(declared.group(1)) == count,
        f"{path} holds cells of kinds that cannot be read (voxels, polyhedra, ...); allowed are "
        f"tetrahedra or hexahedra and their facets",
    )
    tags: dict[str, list[Block]] = {}
    for name, array in _tag_arrays(path, mesh).items():
        for k, block in enumerate(mesh.cells):
            if block.type in SURFACE_CORNERS:
                for number, rows in by_number(array[k]):
                    nodes = _index(block.data[rows])
                    tags.setdefault(name or str(number), []).append(Block(block.type, nodes))
    return FileContent(
        mesh.points, _blocks(mesh), {name: tuple(blocks) for name, blocks in tags.items()}
    )


def _tag_arrays(path: Path, mesh: Any) -> dict[str, list[Indices]]:
    """Arrays by the name of their tag; an array that numbers tags under no name."""
    surface = [k for k, block in enumerate(mesh.cells) if block.type in SURFACE_CORNERS]
    numbering, named = [], {}
    for name, array in mesh.cell_data.items():
        values = [array[k] for k in surface]
        if name in _NEVER_TAGS or any(v.ndim != 1 or v.dtype.kind not in "iub" for v in values):
            continue
        found = set(np.concatenate([np.zeros(0, dtype=int), *values]).tolist())
        if found - {0, 1}:
            numbering.append(name)
        elif 1 in found:
            named[name] = array
    chosen = [name for name in TAG_ARRAYS if name in numbering][:1] or numbering
    require(
        len(chosen) <= 1,
        f"{path}: each of the arrays {chosen} may number the tags of the boundary; "
        f"keep one, or name it {TAG_ARRAYS[1]!r}",
    )
    for name in chosen:
        named[""] = mesh.cell_data[name]
    return named


def read_guarded(
    reader: Callable[[str], Any], path: Path, what: str, reasons: Reasons = ()
) -> Any:
    """What a reader of meshio returns; whatever it raises becomes an ``InputError``.

    ``reasons``: a pattern of what meshio says of a feature that it does not read, and what to say
    of it instead of that the file is damaged.
    """
    said = io.StringIO()
    with (
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(said),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        try:
            return reader(str(path))
        except (Exception, SystemExit) as error:
            reason = " ".join(f"{type(error).__name__} {error} {said.getvalue()}".split())
            hints = [hint for pattern, hint in reasons if re.search(pattern, reason)]
            hint = [*hints, "it is truncated or damaged, or not what its name says"][0]
            raise InputError(f"{path} cannot be read as {what}: {hint} ({reason})") from error


def by_number(values: Any) -> list[tuple[int, Indices]]:
    """Each number above zero with the rows ``(k,)`` that have it; all of them by one sort."""
    order = np.argsort(values, kind="stable")
    order = order[values[order] > 0]
    starts = np.flatnonzero(np.diff(values[order].astype(np.int64), prepend=0))
    parts = np.split(order, starts[1:]) if len(order) else []
    return [(int(values[rows[0]]), rows) for rows in parts]


def _index(nodes: Any) -> Indices:
    return np.asarray(nodes).astype(np.int64)


def _blocks(mesh: Any) -> tuple[Block, ...]:
    return tuple(Block(block.type, _index(block.data)) for block in mesh.cells)
