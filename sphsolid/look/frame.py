"""A frame: the surface of a body at an instant, small enough to keep, or why there is none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.look.scalars import CELL, SCALARS, values_at_vertices
from sphsolid.record.positions import judge_positions
from sphsolid.record.snapshot import Snapshot
from sphsolid.record.stored import StoredSnapshot

#: Fields that a run keeps: as the method has them, and as means over cells, alike for all solvers.
KEPT = (*SCALARS, *(CELL + name for name in SCALARS))


@dataclass(frozen=True, eq=False)
class Shot:
    """The surface of a body at ``time`` [s], ``label`` saying by which method.

    ``quads (f, 4)`` int32, counter-clockwise seen from outside, a triangle with its last corner
    twice; of the vertices of the surface ``x (n, 3)`` float32 [m], the volumes ``V (n,)`` float32
    [m^3] and ``values`` by name, ``(n,)`` float32: ``pressure`` [Pa], ``von_mises`` [Pa], ``J`` [-]
    as the method has them, and with :data:`CELL` before the name as means over cells.  ``folded``:
    whether its positions are judged folded (``record.positions``).
    """

    label: str
    time: float
    quads: NDArray[np.int32]
    x: NDArray[np.float32]
    V: NDArray[np.float32]
    values: dict[str, NDArray[np.float32]]
    folded: bool

    def value(self, name: str) -> NDArray[np.float32]:
        """A field at the vertices; raises ``InputError`` for one that was not kept."""
        if name not in self.values:
            raise InputError(f"frame has no field {name!r}; it has {', '.join(self.values)}")
        return self.values[name]

    def named(self, label: str) -> Shot:
        """The same under another heading."""
        return replace(self, label=label)

    def only(self, faces: NDArray[np.bool_], names: Sequence[str]) -> Shot:
        """The same with some of the ``faces (f,)`` and fields, and the vertices of these."""
        used, corners = np.unique(self.quads[faces], return_inverse=True)
        return replace(
            self,
            quads=corners.reshape(-1, 4).astype(np.int32),
            x=self.x[used],
            V=self.V[used],
            values={name: self.value(name)[used] for name in names},
        )


@dataclass(frozen=True)
class HasDiverged:
    """In the place of a frame: by ``time`` [s] the run had diverged, at ``diverged_at`` [s]."""

    label: str
    time: float
    diverged_at: float


@dataclass(frozen=True)
class Absent:
    """In the place of a frame: a panel that stays empty but for ``reason``."""

    label: str
    time: float
    reason: str = "not run"


#: What a file holds, and what a panel can show.
Kept = Shot | HasDiverged
Frame = Kept | Absent


def take_shot(
    snapshot: Snapshot | StoredSnapshot, label: str, *, fields: Sequence[str] = KEPT
) -> Shot:
    """The frame of a snapshot of any solver, on hexahedra, tetrahedra or points."""
    facets = snapshot.mesh.boundary
    # A facet with two tags is still one.
    first = np.unique(np.sort(facets, axis=1), axis=0, return_index=True)[1]
    facets = facets[np.sort(first)]
    quads = facets if facets.shape[1] == 4 else facets[:, [0, 1, 2, 2]]
    values = {name: values_at_vertices(snapshot, name) for name in fields}
    whole = Shot(
        label=label,
        time=float(snapshot.time),
        quads=quads.astype(np.int32),
        x=snapshot.x.astype(np.float32),
        V=snapshot.V.astype(np.float32),
        values={name: array.astype(np.float32) for name, array in values.items()},
        folded=judge_positions(snapshot).folded,
    )
    return whole.only(np.ones(len(quads), dtype=bool), fields)
