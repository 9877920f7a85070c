"""The operators of a cloud as sums over pairs: kept, or made again where somebody asks.

Most clouds are evaluated by these sums and keep them.  A box lattice is evaluated along its lines;
there they would be the largest arrays of a run, and few ask for them: another formulation than the
displacement form, a term of another kind, who looks at the coefficients.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.operator import Gradients
from sphsolid.cloud.pairs.neighbours import PairList, transposed
from sphsolid.cloud.pairs.pair_operator import PairOperator, expanded, pair_operators

Array = NDArray[np.float64]


class WrittenOut(NamedTuple):
    """Every pair with its coefficients."""

    pairs: PairList
    gradients: Gradients


class Packed(NamedTuple):
    """The same as kernels want it: see ``cloud.Cloud``."""

    kinematic: PairOperator
    force: PairOperator
    adjoint: PairOperator

    @classmethod
    def of(cls, tables: WrittenOut, V: Array, *, stencils: bool) -> Packed:
        """One pair list and three columns each; kinematic and force are one where they agree."""
        pairs, gradients = tables
        columns = [gradients.kinematic]
        if not gradients.is_adjoint:
            columns.append(gradients.force)
        columns.append(_adjoint(gradients.force, pairs, V))
        made = pair_operators(pairs, columns, len(V), stencils=stencils)
        return cls(made[0], made[-2], made[-1])


def _adjoint(G: Array, pairs: PairList, V: Array) -> Array:
    """``g_ab = V_b G_a(X_b) / V_a``; the pair list is symmetric, so it is its own transpose."""
    _, place = transposed(pairs, pairs.rows)
    scale = V[pairs.indices] / V[pairs.row_of_pair]
    return np.asarray(G[place] * scale[:, None])


class PairTables(Protocol):
    """Both forms of the operators of one cloud."""

    @property
    def is_adjoint(self) -> bool:
        """True where kinematics and force share one gradient."""
        ...

    @property
    def particle_major(self) -> bool:
        """How tensor fields should lie in memory (see ``fields``)."""
        ...

    @property
    def mean_neighbours(self) -> float:
        """Pairs a particle, those with coefficient zero included."""
        ...

    @property
    def packed(self) -> Packed:
        """What kernels sum with."""
        ...

    def written_out(self, areas: Array) -> WrittenOut:
        """Every pair, for who looks at them; ``areas (N, 3)`` [m^2] belong to the gradients."""
        ...

    def forget(self) -> None:
        """Let go of what can be made again."""
        ...


@dataclass(frozen=True)
class KeptTables:
    """What every step sums with."""

    packed: Packed

    @property
    def is_adjoint(self) -> bool:
        """True where there is one object."""
        return self.packed.kinematic is self.packed.force

    @property
    def particle_major(self) -> bool:
        """True where no stencil serves."""
        return len(self.packed.adjoint.stencil) == 0

    @property
    def mean_neighbours(self) -> float:
        """Pairs a particle."""
        return self.packed.kinematic.mean_neighbours

    def written_out(self, areas: Array) -> WrittenOut:
        """Unpacked."""
        pairs, kinematic = expanded(self.packed.kinematic)
        force = kinematic if self.is_adjoint else expanded(self.packed.force)[1]
        return WrittenOut(pairs, Gradients(kinematic, force, areas))

    def forget(self) -> None:
        """Nothing: a step needs them."""


class TablesOnDemand:
    """Made again by ``make`` when they are asked for, packed with ``V (N,)`` [m^3].

    ``made`` is what ``make`` returned already; :meth:`forget` lets go of it.
    """

    #: Along lines, tensors are read component by component.
    particle_major = False

    def __init__(
        self, make: Callable[[], WrittenOut], made: WrittenOut, V: Array, *, stencils: bool
    ) -> None:
        self._make: Callable[[], WrittenOut] = make
        self._made: WrittenOut | None = made
        self._V, self._stencils = V, stencils
        self._packed: Packed | None = None
        self.is_adjoint = made.gradients.is_adjoint
        self.mean_neighbours = len(made.pairs.indices) / made.pairs.rows

    @property
    def packed(self) -> Packed:
        """From the first time on they are kept: who sums once sums in every step."""
        if self._packed is None:
            self._packed = Packed.of(self._now(), self._V, stencils=self._stencils)
        return self._packed

    def written_out(self, areas: Array) -> WrittenOut:
        """As they were made; ``areas`` are those of the gradients already."""
        return self._now()

    def forget(self) -> None:
        """Let go of what can be made again."""
        self._made = None

    def _now(self) -> WrittenOut:
        return self._make() if self._made is None else self._made
