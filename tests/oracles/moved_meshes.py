"""One body in other units, mirrored, turned, renumbered, elsewhere, twice: meshes and what maps."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.mesh import HexMesh, Mesh

Array = NDArray[np.float64]


def scaled(mesh: Mesh, unit: float) -> Mesh:
    """The same body where a metre is ``unit``."""
    return dataclasses.replace(mesh, vertices=unit * mesh.vertices, spacing=unit * mesh.spacing)


def elsewhere(mesh: Mesh, by: tuple[float, float, float]) -> Mesh:
    """The body moved by ``by`` [m]."""
    return dataclasses.replace(mesh, vertices=mesh.vertices + np.array(by))


def mirrored(mesh: Mesh) -> Mesh:
    """``x -> -x``, corners reordered so that no cell is inside out."""
    turn = [1, 0, 3, 2, 5, 4, 7, 6] if isinstance(mesh, HexMesh) else [1, 0, 2, 3]
    faces = {name: loops[:, ::-1].copy() for name, loops in mesh.faces.items()}
    return dataclasses.replace(
        mesh, vertices=mesh.vertices * [-1.0, 1.0, 1.0], cells=mesh.cells[:, turn], faces=faces
    )


def turned(mesh: Mesh) -> Mesh:
    """``(x, y, z) -> (y, z, x)``."""
    return dataclasses.replace(mesh, vertices=np.ascontiguousarray(mesh.vertices[:, [1, 2, 0]]))


def renumbered(mesh: Mesh, order: NDArray[np.int64]) -> Mesh:
    """Vertex ``order[i]`` becomes ``i``."""
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    faces = {name: place[loops] for name, loops in mesh.faces.items()}
    return dataclasses.replace(
        mesh, vertices=mesh.vertices[order], cells=place[mesh.cells], faces=faces
    )


def twice(mesh: Mesh, by: tuple[float, float, float]) -> Mesh:
    """The body and a copy of it moved by ``by`` [m], as two parts of one mesh."""
    n = len(mesh.vertices)
    return dataclasses.replace(
        mesh,
        vertices=np.concatenate([mesh.vertices, mesh.vertices + np.array(by)]),
        cells=np.concatenate([mesh.cells, mesh.cells + n]),
        faces={name: np.concatenate([f, f + n]) for name, f in mesh.faces.items()},
    )


def sheared(mesh: Mesh) -> Mesh:
    """A simple shear and a stretch: cells at an angle and longer than wide."""
    slope = np.array([[1.0, 0.3, 0.0], [0.0, 0.8, 0.0], [0.1, 0.0, 1.2]])
    return dataclasses.replace(mesh, vertices=mesh.vertices @ slope.T, is_lattice=False)


def block_with_hole(around: int = 12, rings: int = 3, layers: int = 8) -> HexMesh:
    """A mesher's block: a square with a round hole, extruded in layers half as wide as a cell.

    20 x 20 x 10 mm, a hole of 8 mm along z; one tag.
    """
    angle = 2.0 * np.pi * np.arange(around) / around
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    square = circle / np.max(np.abs(circle), axis=1, keepdims=True)
    share = np.linspace(0.0, 1.0, rings + 1)[:, None, None]
    plane = (4.0e-3 * (1.0 - share) * circle + 10.0e-3 * share * square).reshape(-1, 2)
    height = np.linspace(0.0, 10.0e-3, layers + 1)
    vertices = np.concatenate(
        [np.column_stack([plane, np.full(len(plane), z)]) for z in height]
    )
    r, a, k = np.meshgrid(
        np.arange(rings), np.arange(around), np.arange(layers), indexing="ij"
    )
    n = len(plane)

    def at(r: Any, a: Any, k: Any) -> Any:
        return (n * k + around * r + a % around).ravel()

    low = [at(r, a, k), at(r + 1, a, k), at(r + 1, a + 1, k), at(r, a + 1, k)]
    cells = np.stack([*low, *(corner + n for corner in low)], axis=1)
    sides = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6],
                      [3, 0, 4, 7]])  # fmt: skip
    loops = cells[:, sides].reshape(-1, 4)
    _, number, count = np.unique(
        np.sort(loops, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    outside = loops[count[number.ravel()] == 1]
    spacing = float(np.cbrt((20.0 * 20.0 - np.pi * 16.0) * 10.0e-9 / len(cells)))
    return HexMesh(vertices, cells, {"surface": outside}, spacing, False)
