"""The step map on plane waves in the interior of a lattice: a von Neumann analysis.

Inside a lattice every particle has the same neighbours, so a disturbance ``y exp(i k . X)`` stays
one: ``y^{n+1} = g(k) y^n`` with a 6x6 or (``tau_p > 0``) 7x7 matrix.  It is put together from the
stored operators of one inner particle and of the secondary particles around it,

    G^(k) = sum_b G_b(X_a) e^{i k . (X_b - X_a)},   and likewise g^_q, w^_q at the points q,

and from the derivative of the stress by a complex step.  Unknowns, units and the step formula are
those of ``studies.stability.spectrum``; nothing of the compiled right-hand side is used, so that
the two check each other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid import SSPRK3, SUPG, SimplifiedHessian, Simulation
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.cloud.pairs.pair_operator import expanded
from sphsolid.continuum import law
from sphsolid.continuum.tensor import Tensor, cofactor, determinant, split
from sphsolid.errors import require
from sphsolid.scheme.projection import project
from studies.stability.rates_by_step import times_at, unit_time
from studies.stability.spectrum import J_is_free
from studies.stability.spectrum_step import Block, Layout, step_map

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IMAGINARY = 1.0e-30


class Symbol:
    """Step map of plane waves about the uniform initial state of ``simulation``, a lattice.

    Raises ``InputError`` where the block has no inner particle with the inner stencil (it needs
    about ten particles a side), is disordered, or has another fine scale than
    ``SimplifiedHessian``.
    """

    def __init__(self, simulation: Simulation) -> None:
        sim = simulation
        supg = sim.stabilisation
        require(
            sim.cloud.mesh.is_lattice and not np.any(sim.state.p),
            "plane waves need a lattice at rest; use jitter = 0 and no initial velocity",
        )
        require(
            not isinstance(supg, SUPG) or isinstance(supg.fine_scale, SimplifiedHessian),
            "the symbol is written for SimplifiedHessian(); take the spectrum of a block",
        )
        self.simulation = sim
        self.length = sim.cloud.h_min
        self.unit_time = unit_time(sim)
        self.has_J = J_is_free(sim)
        self.inner = _inner_particle(sim)
        self._F = split(sim.state.F[self.inner])
        self._stress_by = _stress_derivatives(sim, self._F)

    def waves(self, points: int = 13) -> Array:
        """Wave vectors ``k l (n, 3)`` over half the Brillouin zone, zero left out.

        ``-k`` has the conjugate ``g`` of ``k``; ``points`` a full axis, odd, both ends included.
        """
        axis = np.linspace(-np.pi, np.pi, points)
        half = axis[points // 2 :]
        k = np.stack(np.meshgrid(axis, axis, half, indexing="ij"), axis=-1).reshape(-1, 3)
        return k[np.linalg.norm(k, axis=1) > 1.0e-9]

    def step_matrices(self, k: Array, cfl: float) -> ComplexArray:
        """``g(k) (n, m, m)`` for ``k l (n, 3)``."""
        state, geometry = self.generators(k, cfl)
        sim, size = self.simulation, state.shape[1]
        felt = bool(np.max(np.abs(geometry)) > 1.0e-9) and isinstance(sim.integrator, SSPRK3)
        own_x = felt and sim.formulation.evolves_F
        layout = Layout(3, size, not sim.formulation.evolves_F, own_x)

        def rate(S: Block, x: Block) -> Block:
            return state @ S[..., :size, :] + geometry @ x

        without_times, _ = self.generators(k, 0.0)

        def coarse(S: Block) -> Block:
            return without_times @ S[..., :size, :]

        unit = np.broadcast_to(np.eye(layout.rows), (len(k), layout.rows, layout.rows))
        return step_map(sim.integrator, layout, rate, coarse, unit, cfl)

    def eigenvalues(self, k: Array, cfl: float) -> ComplexArray:
        """All ``g (n, m)``."""
        return np.linalg.eigvals(self.step_matrices(k, cfl)).astype(complex)

    def generators(self, k: Array, cfl: float) -> tuple[ComplexArray, ComplexArray]:
        """``A (n, m, m)`` by the state and ``B (n, m, 3)`` by the geometry, as in ``spectrum``."""
        wave = k / self.length
        m = 7 if self.has_J else 6
        columns = []
        for unknown in range(m + 3):
            y = np.zeros((len(k), m), dtype=complex)
            z = np.zeros((len(k), 3), dtype=complex)
            if unknown < m:
                y[:, unknown] = 1.0
            else:
                z[:, unknown - m] = 1.0
            columns.append(self._rates(wave, y, z, cfl))
        matrix = np.stack(columns, axis=-1)
        return matrix[:, :, :m], matrix[:, :, m:]

    def _rates(self, k: Array, y: ComplexArray, z: ComplexArray, cfl: float) -> ComplexArray:
        sim, rho = self.simulation, self.simulation.scene.material.density
        cloud, a = sim.cloud, self.inner
        speed = self.length / self.unit_time
        u, v, x = y[:, :3] * self.length, y[:, 3:6] * speed, z * self.length
        kinematic = _row(k, cloud.X[a], cloud.X, cloud.pairs, a, cloud.gradients.kinematic)
        force = _row(k, cloud.X[a], cloud.X, cloud.pairs, a, cloud.gradients.force)
        divergence = _row(k, cloud.X[a], cloud.X, cloud.pairs, a, cloud.divergence)
        F, Fdot = _dyad(u, kinematic), _dyad(v, kinematic)
        H0 = np.array(cofactor(self._F))
        Jdot = Fdot @ H0
        J = y[:, 6] if self.has_J else F @ H0
        by_F, by_J, by_geometry, of_projection = self._stress_by
        F_x = _dyad(x, force)
        P = F @ by_F.T + J[:, None] * by_J + F_x @ by_geometry.T
        supg, q, times = sim.stabilisation, sim.secondary, times_at(sim, cfl * self.unit_time)
        found: list[tuple[ComplexArray, ...]] = []
        if q is not None and isinstance(supg, SUPG):
            assert isinstance(supg.fine_scale, SimplifiedHessian)
            gamma, alpha = supg.fine_scale.moduli(sim.scene.material)
            interpolated = Fdot @ of_projection.T if supg.is_self_adjoint else Fdot
            for point, spread in self._points_around(k):
                sample = _row(k, q.X[point], cloud.X, q.pairs, point, q.sample)
                g, w = sample[:, :3], sample[:, 3:]
                fine = times.F * gamma * (_dyad(v, g) - w * interpolated)
                fine += supg.xi_F * alpha * (_dyad(x, g) - w * F)
                fine = fine @ of_projection.T
                if supg.is_self_adjoint:
                    P = P - (fine * spread[:, 3:]) @ of_projection.T
                found.append((g, w, fine, spread[:, :3]))
        pdot = -_contract(P, divergence)
        galerkin = pdot.copy()
        for g, w, fine, spread in found:
            assert isinstance(supg, SUPG)
            pdot -= _contract(fine, spread)
            if self.has_J:
                flux = (_contract(P, g) - w * galerkin) @ H0.reshape(3, 3)
                Jdot -= times.p / rho * np.sum(flux * spread, axis=1)
        parts = [y[:, 3:6], pdot * self.unit_time / (rho * speed)]
        return np.concatenate(
            parts + ([Jdot[:, None] * self.unit_time] if self.has_J else []), axis=1
        )

    def _points_around(self, k: Array) -> list[tuple[int, ComplexArray]]:
        """A secondary particle of every kind, and ``sum_q spread_q e^{i k . (X_q - X_a)}`` of it.

        Four columns, as ``Secondary.spreading`` has them; three where it has no more.
        Points at the same place of their cells are one kind; cells are numbered in order.
        """
        sim, a, q = self.simulation, self.inner, self.simulation.secondary
        assert q is not None
        spreading = expanded(q.spreading)[1]
        kinds = len(q.X) // len(sim.cloud.mesh.cells)
        row = slice(q.spread_pairs.indptr[a], q.spread_pairs.indptr[a + 1])
        points = q.spread_pairs.indices[row].astype(int)
        found = []
        for kind in range(kinds):
            mine = points % kinds == kind
            phase = np.exp(1j * (q.X[points[mine]] - sim.cloud.X[a]) @ k.T).T
            distance = np.linalg.norm(q.X[points[mine]] - sim.cloud.X[a], axis=1)
            nearest = int(points[mine][np.argmin(distance)])
            shifted = phase @ spreading[row][mine]
            found.append((nearest, shifted))
        return found


def _row(
    k: Array, at: Array, X: Array, pairs: PairList, row: int, values: Array
) -> ComplexArray:
    """``sum_b values_b e^{i k . (X_b - at)}  (n, c)`` over the pairs of one row."""
    part = slice(pairs.indptr[row], pairs.indptr[row + 1])
    phase = np.exp(1j * (X[pairs.indices[part]] - at) @ k.T).T
    return np.asarray(phase @ values[part])


def _dyad(f: ComplexArray, g: ComplexArray) -> ComplexArray:
    return (f[:, :, None] * g[:, None, :]).reshape(len(f), 9)


def _contract(P: ComplexArray, g: ComplexArray) -> ComplexArray:
    return np.einsum("niI,nI->ni", P.reshape(len(P), 3, 3), g)


def _inner_particle(sim: Simulation) -> int:
    """The particle nearest the middle; its stencil must be that of its neighbours."""
    cloud = sim.cloud
    order = np.argsort(np.linalg.norm(cloud.X - cloud.X.mean(axis=0), axis=1), kind="stable")
    a = int(order[0])
    pairs = cloud.pairs
    row = slice(pairs.indptr[a], pairs.indptr[a + 1])
    for b in pairs.indices[row].astype(int):
        other = slice(pairs.indptr[b], pairs.indptr[b + 1])
        same = row.stop - row.start == other.stop - other.start and all(
            np.allclose(values[row], values[other], rtol=0.0, atol=1.0e-9 / cloud.spacing)
            for values in (cloud.gradients.kinematic, cloud.gradients.force, cloud.divergence)
        )
        require(
            same,
            f"scene {sim.scene.name!r}: the block has no interior with one stencil; plane waves "
            "need more particles a side (about ten, more for a larger h_over_dx)",
        )
    return a


def _stress_derivatives(
    sim: Simulation, F0: Tensor
) -> tuple[Array, Array, Array, Array]:
    """``P`` by ``F (9, 9)``, by ``J (9,)``, by ``F_x (9, 9)``; the projection ``(9, 9)`` itself.

    ``H`` follows ``F``; ``J`` is a variable of its own (see the module text of ``spectrum``).
    """
    material, projects = sim.scene.material, sim._rhs.projects
    J0 = determinant(F0)

    def stress(F: Tensor, J: complex, F_x: Tensor) -> ComplexArray:
        P = law.first_piola(material, F, cofactor(F), J)
        return np.array(project(P, F_x) if projects else P, dtype=complex)

    def moved(A: Tensor, entry: int) -> Tensor:
        step = [1j * IMAGINARY if i == entry else 0.0 for i in range(9)]
        return split((np.array(A) + np.array(step)).reshape(3, 3))

    by_F = [stress(moved(F0, i), J0, F0).imag / IMAGINARY for i in range(9)]
    by_J = stress(F0, J0 + 1j * IMAGINARY, F0).imag / IMAGINARY
    by_x = [stress(F0, J0, moved(F0, i)).imag / IMAGINARY for i in range(9)]
    unit = [split(np.eye(9)[i].reshape(3, 3)) for i in range(9)]
    onto = [np.array(project(e, F0) if projects else e, dtype=float) for e in unit]
    return np.array(by_F).T, by_J, np.array(by_x).T, np.array(onto).T

