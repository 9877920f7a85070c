"""Is a body a full box of lattice points, and which of them is which particle?"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.mesh import Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: How far from its grid point a vertex may lie, in spacings: round-off of positions far away.
_OFF = 1.0e-6


@dataclass(frozen=True)
class NoBox:
    """The body is no full box of lattice points; ``reason`` says what it is."""

    reason: str


@dataclass(frozen=True, eq=False)
class BoxLattice:
    """``number (nx, ny, nz)`` is the particle at each grid point; ``dx`` [m] a spacing an axis."""

    number: Indices
    dx: tuple[float, float, float]

    @property
    def counts(self) -> tuple[int, int, int]:
        """Points along X, Y and Z."""
        nx, ny, nz = self.number.shape
        return nx, ny, nz

    @cached_property
    def directions(self) -> tuple[int, int, int]:
        """The axes from slow to fast in memory as they should be: the longest is the fastest.

        A cyclic order of X, Y, Z; of equally long axes the last.
        """
        fast = max(range(3), key=lambda axis: (self.counts[axis], axis))
        return (fast + 1) % 3, (fast + 2) % 3, fast

    @property
    def is_arranged(self) -> bool:
        """True where the particles are numbered like that."""
        line = self.number.transpose(self.directions).ravel()
        return bool(np.array_equal(line, np.arange(len(line))))


def box_of(mesh: Mesh) -> BoxLattice | NoBox:
    """The grid of ``mesh``, whatever its numbering."""
    if not mesh.is_lattice:
        return NoBox("its particles do not lie on a lattice")
    X = mesh.vertices
    low, high = X.min(axis=0), X.max(axis=0)
    counts, dx = [], []
    for axis in range(3):
        steps = np.diff(np.sort(X[:, axis]))
        apart = steps[steps > _OFF * (high[axis] - low[axis])]
        counts.append(len(apart) + 1)
        dx.append(float((high[axis] - low[axis]) / max(1, len(apart))))
    cells = int(np.prod([n - 1 for n in counts]))
    if int(np.prod(counts)) != len(X) or cells != len(mesh.cells):
        return NoBox("it is no single box")
    place = (X - low) / dx
    index = np.rint(place).astype(np.int64)
    number = np.full(counts, -1)
    number[tuple(index.T)] = np.arange(len(X))
    if np.max(np.abs(place - index)) > _OFF * max(counts) or np.any(number < 0):
        return NoBox("its particles are not evenly spaced")
    return BoxLattice(number, (dx[0], dx[1], dx[2]))


def arranged(mesh: Any, box: BoxLattice) -> Any:
    """``mesh`` with its vertices numbered so that the longest axis runs fastest."""
    if box.is_arranged:
        return mesh
    order = box.number.transpose(box.directions).ravel()
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    faces = {name: place[facets] for name, facets in mesh.faces.items()}
    return replace(mesh, vertices=mesh.vertices[order], cells=place[mesh.cells], faces=faces)
