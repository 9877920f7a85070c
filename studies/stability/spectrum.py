"""The linear map of one time step about a uniform state at rest, and its eigenvalues.

One step of the integrator takes a small disturbance ``Y`` of a uniform state at rest to ``g Y``.
The rates are those of the solver's right-hand side, differentiated by central differences of
fourth order; ``spectrum_step`` makes the map of them.

Few unknowns are needed.  ``F`` changes by the gradient of the velocities that also move a
displacement ``w``, so ``F - grad w`` (and ``H - cof grad w``; without ``tau_p`` also ``J`` less its
determinant) never changes: it adds eigenvalues one and nothing else.  Left are, in units of
``l = h_min`` and ``T = dt / CFL``, the rows of ``spectrum_step``.  In particular all mixed
formulations have one and the same spectrum without ``tau_p``.

Loads are held: a stretched state is in equilibrium under whatever dead load that takes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid import SSPRK3, SUPG, Simulation
from sphsolid.continuum.tensor import cofactor, contract, cross, join, split
from sphsolid.errors import require
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.state import State
from studies.stability.spectrum_step import Layout, Rates, interpolated, nodes, step_matrix

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
#: Central differences of fourth order: ``f' = sum weight f(x + offset step) / step``.
STEP = 1.0e-3
STENCIL = ((-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0))


def take_times_at(simulation: Simulation, step: float) -> None:
    """Give every term its times where the CFL rule allows ``step`` [s]; at zero nothing has one."""
    crossing = simulation._time_step.crossing if step > 0.0 else 0.0
    simulation._rhs.begin_step(Units(crossing, step))


class Linearisation:
    """Step map of a simulation about its initial state, which must be at rest.

    ``layout`` says which unknowns there are: the free components of ``w`` and ``v``, ``J`` where it
    is not tied to ``w`` (damped by ``tau_p``, or evolved while ``F`` is not), ``x`` where it is
    felt and is not ``w``.
    Raises ``InputError`` where the initial state moves or a constraint is not along an axis.
    """

    def __init__(self, simulation: Simulation) -> None:
        sim = simulation
        require(
            not np.any(sim.state.p),
            f"the spectrum of {sim.name} is that of a state at rest; start it without velocity",
        )
        self.simulation = sim
        self.rhs = sim._rhs
        self.nodes = nodes(sim.stabilisation)
        #: Units: the least distance [m], and the step [s] at CFL 1.
        self.length = sim.cloud.h_min
        self.unit_time = sim.stable_time_step() / sim._time_step.cfl
        formulation, supg = sim.formulation, sim.stabilisation
        damped = isinstance(supg, SUPG) and supg.damps_J
        self.has_J = formulation.evolves_J and (damped or not formulation.evolves_F)
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
        z = np.random.default_rng(0).uniform(-1.0, 1.0, self.moves)
        by = [self.rate(np.zeros(self.size), z, cfl) for cfl in (0.0, 1.0)]
        self.feels_geometry = bool(np.max(np.abs(by)) > 1.0e-9)
        own_x = (
            formulation.evolves_F and isinstance(sim.integrator, SSPRK3) and self.feels_geometry
        )
        self.layout = Layout(self.moves, self.size, not formulation.evolves_F, own_x)

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

    def columns(self, cfl: float, unknowns: NDArray[np.int64]) -> Array:
        """Rates ``(size, k)`` by the unknowns with these numbers; those from ``size`` on are the
        geometry's.
        """
        y = np.zeros(self.size + self.moves)
        found = np.empty((self.size, len(unknowns)))
        for column, unknown in enumerate(unknowns):
            y[unknown] = 1.0
            found[:, column] = self.rate(y[: self.size], y[self.size :], cfl)
            y[unknown] = 0.0
        return found

    @cached_property
    def _rates(self) -> tuple[Array, Array, Array]:
        """``A (k, n, n)`` and ``B (k, n, m)`` at the nodes, and the coarse rates by ``v``."""
        n, m = self.size, self.moves
        A = np.array([self.columns(cfl, np.arange(n)) for cfl in self.nodes])
        B = np.zeros((len(A), n, m))
        if self.feels_geometry:
            B[:] = [self.columns(cfl, np.arange(n, n + m)) for cfl in self.nodes]
        coarse = np.zeros((n, n))
        coarse[:, m : 2 * m] = self.columns(0.0, np.arange(m, 2 * m))
        return A, B, coarse

    def rates(self, cfl: float) -> Rates:
        """Where the CFL rule allows steps of ``cfl``."""
        A, B, coarse = self._rates
        return Rates(interpolated(A, self.nodes, cfl), interpolated(B, self.nodes, cfl), coarse)

    def generator(self, cfl: float) -> Array:
        """The semi-discrete system ``(size, size)`` with ``x = w``, in units of ``T``."""
        rates = self.rates(cfl)
        rates.A[:, : self.moves] += rates.B
        return rates.A

    def step_matrix(self, cfl: float) -> Array:
        """The map of one step ``(rows, rows)``."""
        return step_matrix(self.simulation.integrator, self.layout, self.rates(cfl), cfl)

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
        n, m, r = self.layout.rows, self.moves, self.rigid.shape[1]
        if r == 0:
            return np.eye(n)
        rows = np.zeros((n, 2 * r))
        rows[:m, :r] = rows[m : 2 * m, r:] = self.rigid
        if self.layout.own_x:
            rows[self.size :, :r] = self.rigid
        rows /= np.linalg.norm(rows, axis=0)
        return np.linalg.qr(rows, mode="complete")[0][:, 2 * r :]

    def eigenvalues(self, cfl: float) -> ComplexArray:
        """All ``g`` but those of rigid motions."""
        step = self.elastic.T @ self.step_matrix(cfl) @ self.elastic
        return np.linalg.eigvals(step).astype(complex)

    def modes(self, cfl: float) -> tuple[ComplexArray, ComplexArray]:
        """``g (k,)`` and modes ``(rows, k)`` as columns, largest ``|g|`` first."""
        g, vectors = np.linalg.eig(self.elastic.T @ self.step_matrix(cfl) @ self.elastic)
        order = np.argsort(-np.abs(g), kind="stable")
        return g[order], self.elastic @ vectors[:, order]


class PlaneWaves:
    """The same of plane waves ``y exp(i k . X)`` inside a lattice: a von Neumann analysis.

    Inside a lattice every particle has the same neighbours, so a wave stays one:
    ``y^{n+1} = g(k) y^n`` with a 6x6 or (with ``J``) 7x7 matrix.  What a disturbance of one
    particle does to the others, ``R(X_b - X_a)``, gives the rates of all waves:

        A(k) = sum_b R(X_b - X_a) e^{-i k . (X_b - X_a)}

    ``k (n, 3)`` are wave vectors times ``l``.  Raises ``InputError`` where the block is disordered,
    or so small that what its middle particle does to the others is not what the next one does.
    """

    def __init__(self, linear: Linearisation, k: Array) -> None:
        cloud = linear.simulation.cloud
        require(
            cloud.mesh.is_lattice and linear.moves == 3 * cloud.size,
            "plane waves need a free lattice; use jitter = 0 and no constraints",
        )
        self.linear, self.k, self.size = linear, k, 7 if linear.has_J else 6
        self.layout = replace(linear.layout, moves=3, size=self.size)
        #: The particle in the middle.
        self.inner = int(np.argmin(np.linalg.norm(cloud.X - cloud.X.mean(axis=0), axis=1)))
        # Without any intrinsic time, and at the nodes.
        response = np.array([self._response(self.inner, cfl) for cfl in (0.0, *linear.nodes)])
        first = cloud.mesh.cells[0]
        diagonal = int(first.max() - first.min())
        other = self._response(self.inner + diagonal, linear.nodes[-1])
        apart = np.max(np.abs(other - np.roll(response[-1], diagonal, axis=0)))
        require(
            bool(apart < 1.0e-7 * np.max(np.abs(other))),
            f"scene {linear.simulation.scene.name!r}: the block has no interior with one stencil; "
            "plane waves need more particles a side (about fifteen, more for a larger h_over_dx)",
        )
        felt = np.flatnonzero(np.any(response, axis=(0, 2, 3)))
        offset = (cloud.X[felt] - cloud.X[self.inner]) / linear.length
        phase = np.exp(-1j * k @ offset.T)
        by_wave = np.tensordot(response[:, felt], phase, axes=(1, 1)).transpose(0, 3, 1, 2)
        self._coarse, self._at_nodes = by_wave[0], by_wave[1:]

    def _response(self, a: int, cfl: float) -> Array:
        """Rates of every particle ``(N, size, size + 3)`` by the unknowns of ``a``."""
        linear, n = self.linear, self.linear.simulation.cloud.size
        xyz = 3 * a + np.arange(3)
        J = [6 * n + a] if linear.has_J else []
        by = np.concatenate([xyz, 3 * n + xyz, J, linear.size + xyz]).astype(int)
        rates = linear.columns(cfl, by)
        parts = [rates[: 3 * n].reshape(n, 3, -1), rates[3 * n : 6 * n].reshape(n, 3, -1)]
        return np.concatenate(parts + ([rates[6 * n :, None]] if linear.has_J else []), axis=1)

    def rates(self, cfl: float) -> Rates:
        """Of all waves ``(n, size, size)``."""
        both = interpolated(self._at_nodes, self.linear.nodes, cfl)
        m = self.size
        return Rates(both[..., :m], both[..., m:], self._coarse[..., :m])

    def eigenvalues(self, cfl: float) -> ComplexArray:
        """All ``g (n, size)``."""
        integrator = self.linear.simulation.integrator
        matrices = step_matrix(integrator, self.layout, self.rates(cfl), cfl)
        return np.linalg.eigvals(matrices).astype(complex)


def brillouin_zone(points: int = 13) -> Array:
    """Wave vectors ``k l (n, 3)`` over half the zone, zero left out: ``-k`` has the conjugates.

    ``points`` a full axis, odd, both ends included.
    """
    axis = np.linspace(-np.pi, np.pi, points)
    k = np.stack(np.meshgrid(axis, axis, axis[points // 2 :], indexing="ij"), axis=-1)
    k = k.reshape(-1, 3)
    return k[np.linalg.norm(k, axis=1) > 1.0e-9]
