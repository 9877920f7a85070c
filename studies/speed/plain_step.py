"""The paper's step with numpy and scipy's sparse matrices: what a kernel has to be worth.

{p, F}, ``D(p)`` as printed with ``P_fine = tau gamma R_F`` (27), projection, TVD-RK2: the same
numbers as ``sphsolid`` to round-off where it takes the step that the CFL rule allows and ``tau_F``
is one of the step, from matrices that are multiplied one after another.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

import sphsolid as sph
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.scheme.intrinsic_time import as_time
from sphsolid.scheme.projection import project

Array = NDArray[np.float64]


def _matrices(pairs: PairList, values: Array, columns: int) -> list[csr_array]:
    """One matrix a column of ``values (P, C)``."""
    shape = (pairs.rows, columns)
    return [csr_array((c, pairs.indices, pairs.indptr), shape=shape) for c in values.T]


class PlainStepper:
    """Takes over the state of ``sim`` and advances copies of it."""

    def __init__(self, sim: sph.Simulation) -> None:
        cloud, q, supg = sim.cloud, sim.secondary, sim.stabilisation
        assert q is not None
        assert isinstance(supg, sph.SUPG)
        assert isinstance(supg.fine_scale, sph.SimplifiedHessian)
        self._material = sim.scene.material
        tau = as_time(supg.tau_F)
        assert isinstance(tau, sph.OfStep)
        self._tau_gamma = tau.c * supg.fine_scale.moduli(self._material)[0]
        self._essential = sim._rhs.essential
        n = cloud.size
        self._G = _matrices(cloud.pairs, cloud.gradients.kinematic, n)
        self._div = _matrices(cloud.pairs, cloud.divergence, n)
        *self._G_q, self._W = _matrices(q.pairs, q.sample, n)
        self._spread = _matrices(q.spread_pairs, q.spread, len(q.X))
        self.time = 0.0
        self.p, self.x, self.F = (np.array(a) for a in (sim.state.p, sim.state.x, sim.state.F))

    @staticmethod
    def _gradient(G: list[csr_array], f: Array) -> Array:
        return np.stack([G_j @ f for G_j in G], axis=2)

    @staticmethod
    def _divergence(g: list[csr_array], P: Array) -> Array:
        return sum(g_j @ P[:, :, j] for j, g_j in enumerate(g))

    @staticmethod
    def _projected(P: Array, F_x: Array) -> Array:
        return np.asarray(join(project(split(P), split(F_x))))

    def _rates(self, p: Array, F: Array, x: Array, dt: float) -> tuple[Array, Array]:
        v, entries = p / self._material.density, split(F)
        L = self._gradient(self._G, v)
        stress = law.first_piola(self._material, entries, cofactor(entries), determinant(entries))
        P = self._projected(join(stress), self._gradient(self._G, x))
        residual = self._gradient(self._G_q, v) - (self._W @ L.reshape(-1, 9)).reshape(-1, 3, 3)
        fine = self._projected(
            dt * self._tau_gamma * residual, self._gradient(self._G_q, x)
        )
        rate = -self._divergence(self._div, P) - self._divergence(self._spread, fine)
        self._essential.release(rate)
        return rate, L

    def advance(self, dt: float) -> None:
        """One step of TVD-RK2."""
        f, L = self._rates(self.p, self.F, self.x, dt)
        p, F = self.p + dt * f, self.F + dt * L
        self._essential.impose(p, self.time + dt)
        x = self.x + dt / (2.0 * self._material.density) * (self.p + p)
        f, L = self._rates(p, F, x, dt)
        self.p, self.F, self.x = 0.5 * (self.p + p + dt * f), 0.5 * (self.F + F + dt * L), x
        self.time += dt
        self._essential.impose(self.p, self.time)
