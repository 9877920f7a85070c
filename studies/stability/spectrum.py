"""The linear map of one time step about a uniform state at rest, and its eigenvalues.

One step of the integrator takes a small disturbance ``Y`` of a uniform state at rest to ``g Y``.
The rates are those of ``RightHandSide.evaluate``, differentiated by central differences of fourth
order.  They are a polynomial in ``dt`` (``rates_by_step``), so few Jacobians serve every step:
``A`` by a disturbance of the state, ``B`` by one of the geometry that ``F_x`` is taken from.
``spectrum_step`` makes the map of them.

Few unknowns are needed.  ``F`` changes by the gradient of the velocities that also move a
displacement ``w``, so ``F - grad w`` (and ``H - cof grad w``; without ``tau_p`` also ``J`` less its
determinant) never changes: it adds eigenvalues one and nothing else.  Left are, in units of
``l = h_min`` and ``T = dt / CFL``, the rows of ``spectrum_step``.  In particular all mixed
formulations have one and the same spectrum without ``tau_p``.

Loads are held: a stretched state is in equilibrium under whatever dead load that takes.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid import SSPRK3, SUPG, Simulation
from sphsolid.continuum.tensor import cofactor, contract, cross, join, split
from sphsolid.errors import require
from sphsolid.scheme.state import State
from studies.stability.rates_by_step import interpolated, nodes, take_times_at, unit_time
from studies.stability.spectrum_step import CoarseRate, Layout, Rate, step_map

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
#: Central differences of fourth order: ``f' = sum weight f(x + offset step) / step``.
STEP = 1.0e-3
STENCIL = ((-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0))


def J_is_free(simulation: Simulation) -> bool:
    """True when ``J`` is an unknown of its own: damped by ``tau_p``, or evolved while ``F`` is not.

    Otherwise it changes as the strains do.
    """
    formulation, supg = simulation.formulation, simulation.stabilisation
    damped = isinstance(supg, SUPG) and supg.damps_J
    return formulation.evolves_J and (damped or not formulation.evolves_F)


class Linearisation:
    """Step map of a simulation about its initial state, which must be at rest.

    ``layout`` says which unknowns there are: the free components of ``w`` and ``v``, ``J`` where it
    is not tied to ``w``, ``x`` where it is felt and is not ``w``.
    Raises ``InputError`` where the initial state moves or a constraint is not along an axis.
    """

    def __init__(self, simulation: Simulation) -> None:
        sim = simulation
        require(
            not np.any(sim.state.p),
            f"the spectrum of {sim.name} is that of a state at rest; start it without velocity",
        )
        self.simulation = sim
        self._nodes = nodes(sim.stabilisation)
        self.rhs = sim._rhs
        self.length = sim.cloud.h_min
        self.unit_time = unit_time(sim)
        self.has_J = J_is_free(sim)
        self._base = State(**{name: array.copy() for name, array in sim.state.items()})
        allowed = np.ones((sim.cloud.size, 3))
        self.rhs.essential.release(allowed)
        require(
            bool(np.all((allowed == 0.0) | (allowed == 1.0))),
            "the spectrum needs constraints along the axes; use a body with axis-aligned faces",
        )
        #: Places of the free components in a flat ``(N, 3)`` field.
        self.free = np.flatnonzero(allowed)
        self.moves = len(self.free)
        self.size = 2 * self.moves + (sim.cloud.size if self.has_J else 0)
        own_x = (
            sim.formulation.evolves_F
            and isinstance(sim.integrator, SSPRK3)
            and self._geometry_is_felt()
        )
        self.layout = Layout(self.moves, self.size, not sim.formulation.evolves_F, own_x)

    def _geometry_is_felt(self) -> bool:
        z = np.random.default_rng(0).uniform(-1.0, 1.0, self.moves)
        by = [self.rate(np.zeros(self.size), z, cfl) for cfl in (0.0, 1.0)]
        return bool(np.max(np.abs(by)) > 1.0e-9)

    def fields(self, y: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """``w / l``, ``v T / l`` of shape ``(N, 3)`` and ``dJ (N,)`` (zero where it is tied)."""
        n, m = self.simulation.cloud.size, self.moves
        u, v = np.zeros((2, 3 * n), dtype=y.dtype)
        u[self.free], v[self.free] = y[:m], y[m : 2 * m]
        J = y[2 * m : self.size] if self.has_J else np.zeros(n, dtype=y.dtype)
        return u.reshape(n, 3), v.reshape(n, 3), J

    def rate(self, y: Array, geometry: Array, cfl: float) -> Array:
        """Change of the rates by ``y (size,)`` in the state, ``geometry (moves,)`` in ``F_x``."""
        u, v, J = self.fields(y)
        z = np.zeros(3 * len(u))
        z[self.free] = geometry
        # The truncation error is that of the largest entry: every direction gets the same step.
        largest = max(float(np.max(np.abs(y))), float(np.max(np.abs(geometry))))
        total = np.zeros(self.size)
        if largest > 0.0:
            step = STEP / largest
            for offset, weight in STENCIL:
                by = self._disturbed(offset * step, u, v, J, z.reshape(u.shape), cfl)
                total += weight / step * by
        return total

    def _disturbed(
        self, step: float, u: Array, v: Array, J: Array, z: Array, cfl: float
    ) -> Array:
        rhs, base, f = self.rhs, self._base, self.simulation.formulation
        speed = self.length / self.unit_time
        density = rhs.material.density
        state = State(
            p=(step * density * speed) * v,
            x=base.x + (step * self.length) * u,
            F=np.empty_like(base.F),
            H=base.H.copy(),
            J=base.J.copy(),
        )
        rhs.kinematic_gradient((step * self.length) * u, 1.0, state.F)
        change = split(state.F.copy())
        F = split(base.F)
        if f.evolves_H:
            state.H += join(cross(F, change))
        if self.has_J:
            state.J += step * J
        elif f.evolves_J:
            state.J += contract(split(base.H) if f.evolves_H else cofactor(F), change)
        state.F += base.F
        x = base.x + (step * self.length) * z
        take_times_at(self.simulation, cfl * self.unit_time)
        rates = rhs.evaluate(state, x, 0.0)
        pdot = rates.p.reshape(-1)[self.free] * (self.unit_time / (density * speed))
        parts = [step * v.reshape(-1)[self.free], pdot]
        return np.concatenate(parts + ([rates.J * self.unit_time] if self.has_J else []))

    @cached_property
    def _jacobians(self) -> tuple[Array, Array]:
        """``A (k, n, n)`` and ``B (k, n, m)`` at the nodes."""
        nothing, unit = np.zeros(self.size), np.eye(self.moves)
        A = np.array([self._by_state(cfl, range(self.size)) for cfl in self._nodes])
        B = np.zeros((len(A), self.size, self.moves))
        if self._geometry_is_felt():
            for by, cfl in zip(B, self._nodes, strict=True):
                by[:] = np.array([self.rate(nothing, e, cfl) for e in unit]).T
        return A, B

    @cached_property
    def _coarse(self) -> Array:
        """``A (n, n)`` without any intrinsic time; the columns of ``v`` alone."""
        return self._by_state(0.0, range(self.moves, 2 * self.moves))

    def _by_state(self, cfl: float, columns: range) -> Array:
        still, unit = np.zeros(self.moves), np.eye(self.size)
        A = np.zeros((self.size, self.size))
        for column in columns:
            A[:, column] = self.rate(unit[column], still, cfl)
        return A

    def _jacobians_at(self, cfl: float) -> tuple[Array, Array]:
        A, B = self._jacobians
        return interpolated(A, self._nodes, cfl), interpolated(B, self._nodes, cfl)

    def generator(self, cfl: float) -> Array:
        """The semi-discrete system ``(size, size)`` with ``x = w``, in units of ``T``."""
        generator, by_geometry = self._jacobians_at(cfl)
        generator[:, : self.moves] += by_geometry
        return generator

    def step_matrix(self, cfl: float) -> Array:
        """The map of one step ``(rows, rows)``."""
        A, B = self._jacobians_at(cfl)

        def rate(S: Array, x: Array) -> Array:
            return A @ S[: self.size] + B @ x

        def coarse(S: Array) -> Array:
            return self._coarse @ S[: self.size]

        return self._step(rate, coarse, np.eye(self.layout.rows), cfl)

    def step(self, y: Array, cfl: float) -> Array:
        """The map of one step applied to ``y (rows,)`` without any matrix."""

        def rate(S: Array, x: Array) -> Array:
            return self.rate(S[: self.size, 0], x[:, 0], cfl)[:, None]

        def coarse(S: Array) -> Array:
            return self.rate(S[: self.size, 0], np.zeros(self.moves), 0.0)[:, None]

        return self._step(rate, coarse, y[:, None], cfl)[:, 0]

    def _step(self, rate: Rate, coarse: CoarseRate, Y: Array, cfl: float) -> Array:
        return step_map(self.simulation.integrator, self.layout, rate, coarse, Y, cfl)

    @cached_property
    def rigid(self) -> Array:
        """Orthonormal rigid motions ``(m, r)`` that meet no constraint and no force.

        Each is a Jordan block, a displacement that grows like ``t``, and is taken out exactly
        because round-off splits a double eigenvalue by its square root.
        """
        X = self.simulation.state.x - self.simulation.state.x.mean(axis=0)
        turns = [np.cross(axis, X) for axis in np.eye(3)]
        moves = [np.broadcast_to(axis, X.shape) for axis in np.eye(3)]
        motions = np.stack([motion.reshape(-1) for motion in moves + turns], axis=1)
        motions /= np.linalg.norm(motions, axis=0)
        fixed = np.setdiff1d(np.arange(len(motions)), self.free)
        zero = np.zeros(self.size - self.moves)
        forces = [
            self.rate(np.concatenate([motion[self.free], zero]), motion[self.free], 0.0)
            for motion in motions.T
        ]
        resisted = np.concatenate([motions[fixed], np.array(forces).T])
        _, value, vector = np.linalg.svd(resisted, full_matrices=True)
        value = np.concatenate([value, np.zeros(6 - len(value))])
        kept = motions[self.free] @ vector[value < 1.0e-6].T
        return np.linalg.qr(kept)[0]

    @cached_property
    def elastic(self) -> Array:
        """Orthonormal basis ``(rows, rows - 2 r)`` of all that is not rigid.

        Rigid are displacements (``w`` and ``x`` together) and velocities.
        """
        if not self.rigid.shape[1]:
            return np.eye(self.layout.rows)
        return np.linalg.qr(self._rigid_rows, mode="complete")[0][:, self._rigid_rows.shape[1] :]

    @cached_property
    def _rigid_rows(self) -> Array:
        n, m, r = self.layout.rows, self.moves, self.rigid.shape[1]
        rows = np.zeros((n, 2 * r))
        rows[:m, :r] = self.rigid
        rows[m : 2 * m, r:] = self.rigid
        if self.layout.own_x:
            rows[self.size :, :r] = self.rigid
        return rows / np.linalg.norm(rows, axis=0)

    def eigenvalues(self, cfl: float) -> ComplexArray:
        """All ``g`` but those of rigid motions."""
        step = self.elastic.T @ self.step_matrix(cfl) @ self.elastic
        return np.linalg.eigvals(step).astype(complex)

    def modes(self, cfl: float) -> tuple[ComplexArray, ComplexArray]:
        """``g (k,)`` and modes ``(rows, k)`` as columns, largest ``|g|`` first."""
        g, vectors = np.linalg.eig(self.elastic.T @ self.step_matrix(cfl) @ self.elastic)
        order = np.argsort(-np.abs(g), kind="stable")
        return g[order], self.elastic @ vectors[:, order]
