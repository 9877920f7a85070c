"""Gmsh files, read through meshio."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from sphsolid.errors import InputError, require
from sphsolid.geometry.file_content import SURFACE_CORNERS, Block, FileContent, Indices
from sphsolid.geometry.meshio_reading import blocks_of, by_number, index, read_guarded
from sphsolid.geometry.unread_features import GMSH_REASONS, refuse_gmsh_features

#: Sections of a Gmsh file that hold results.
_RESULTS = re.compile(
    rb"^\$(NodeData|ElementData|ElementNodeData|InterpolationScheme)\s*$.*?^\$End\1\s*?$",
    re.M | re.S,
)


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
            tags.setdefault(name, []).append(Block(block.type, index(block.data[rows])))
    return FileContent(
        mesh.points,
        blocks_of(mesh),
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
