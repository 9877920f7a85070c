"""Meshes written as Gmsh 2.2 text, right or wrong: to feed the reader with what is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

#: Gmsh's number of a kind of cell.
KINDS = {
    "line": 1, "triangle": 2, "quad": 3, "tetra": 4, "hexahedron": 5, "wedge": 6, "pyramid": 7,
}  # fmt: skip


def write_gmsh(
    path: Path,
    points: Sequence,
    cells: Sequence[tuple[str, Sequence, int]],
    names: Sequence[tuple[int, int, str]] = (),
) -> Path:
    """Write ``cells`` (kind, rows of points from zero, physical number) with their ``names``.

    A name comes with its dimension and number.
    """
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    if names:
        lines += ["$PhysicalNames", str(len(names))]
        lines += [f'{dimension} {number} "{name}"' for dimension, number, name in names]
        lines += ["$EndPhysicalNames"]
    lines += ["$Nodes", str(len(points))]
    for k, point in enumerate(np.asarray(points, dtype=float).tolist(), start=1):
        lines.append(" ".join([str(k), *(repr(x) for x in point)]))
    rows = [
        f"{KINDS[kind]} 2 {number} 1 " + " ".join(str(1 + int(node)) for node in row)
        for kind, block, number in cells
        for row in block
    ]
    lines += ["$EndNodes", "$Elements", str(len(rows))]
    lines += [f"{k} {row}" for k, row in enumerate(rows, start=1)]
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    return path


def write_mesh(path: Path, mesh, **changes) -> Path:
    """A mesh with its tags as physical surfaces, with other ``points`` or ``cells`` if given."""
    names = [(2, k, name) for k, name in enumerate(sorted(mesh.faces), start=1)]
    surfaces = [(mesh.shape.vtk_facet, mesh.faces[name], k) for _, k, name in names]
    return write_gmsh(
        path,
        changes.get("points", mesh.vertices),
        [*surfaces, (mesh.shape.vtk, changes.get("cells", mesh.cells), 99)],
        [*names, (3, 99, "body")],
    )
