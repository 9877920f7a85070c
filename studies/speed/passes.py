"""The passes of one evaluation, each alone: time, operations and bytes that must move.

*Bytes* are compulsory traffic: every array that a pass reads or writes, once, and once more for
what a write reads first.  *Operations* are counted from the operators as they are stored (zeros
that a stencil leaves out cost nothing) and from the law itself (``counting``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import sphsolid as sph
from sphsolid.cloud.pairs.pair_operator import PairOperator
from sphsolid.fields import components
from sphsolid.scheme import fine_scale, galerkin, pressure, time_step
from sphsolid.scheme.supg import SUPGTerm
from sphsolid.scheme.tile import make_scratch
from studies.measures.rhythm import viscous_share
from studies.speed import counting

_DOUBLE = 8


@dataclass(frozen=True)
class Pass:
    """``run()`` does it once; ``flops`` and ``bytes`` of that."""

    name: str
    run: Callable[[], object]
    flops: float
    bytes: float


def pairs_of(A: PairOperator) -> float:
    """Pairs that are worked on, lanes of runs that are written over included."""
    term = np.diff(A.term.astype(np.int64))
    seen = np.diff(A.seen.astype(np.int64))
    kind = A.stencil.astype(np.int64)
    shared = kind < int(A.stencils)
    lanes = A.lanes.astype(np.int64)
    runs = np.sum(lanes[shared] * term[kind[shared]]) + np.sum(lanes[~shared] * seen[kind[~shared]])
    return float(runs) + len(A.indices)


def bytes_of(A: PairOperator) -> int:
    """Bytes of the operator itself."""
    return sum(np.asarray(part).nbytes for part in A)


def _moved(reads: list[Any], writes: list[Any]) -> float:
    return float(sum(a.nbytes for a in reads) + 2 * sum(a.nbytes for a in writes))


def passes(sim: sph.Simulation) -> list[Pass]:
    """All passes of one evaluation of ``sim`` and its time-step control, in order."""
    rhs, cloud, q, state = sim._rhs, sim.cloud, sim.secondary, sim.state
    f, material, n = sim.formulation, sim.scene.material, sim.cloud.size
    p, F, H, J = state.rows()
    x, P, scratch = components(state.x), components(rhs.P), make_scratch()
    pdot, Fdot, Hdot, Jdot = rhs.rates.rows()
    Fdot_C = components(rhs._projected_rate)
    projects, projection = rhs.projects, counting.projection_operations()
    has_H, has_J = f.evolves_H, f.evolves_J
    gradients = 2 if projects else 1
    lanes = counting.stress_operations(material, has_H=has_H, has_J=has_J)
    lanes += projection * (int(projects) + (Fdot_C.size > 0))
    lanes += counting.contraction_operations() if has_J else 0
    listed = [
        Pass(
            "gradient, projection, stress",
            lambda: galerkin.coarse(
                material, cloud.kinematic, cloud.force,
                galerkin.Passes(cloud.is_adjoint, True, False, projects),
                galerkin.Given(x, p, F, H, J), galerkin.Found(P, Fdot, Hdot, Jdot, Fdot_C),
                scratch,
            ),
            18.0 * gradients * pairs_of(cloud.kinematic) + lanes * n,
            bytes_of(cloud.kinematic) + _moved([p, x, F, H, J], [P, Fdot, Hdot, Jdot, Fdot_C]),
        )
    ]  # fmt: skip
    if isinstance(sim.stabilisation, sph.SUPG) and q is not None:
        supg, (term,) = sim.stabilisation, rhs.terms
        assert isinstance(term, SUPGTerm)
        P_fine, F_x_q = components(term.P_fine), components(term.F_x)
        rate = Fdot_C if Fdot_C.size else Fdot
        m = len(q.X)
        simplified = isinstance(supg.fine_scale, sph.SimplifiedHessian)
        if simplified:
            listed.append(
                Pass(
                    "secondary points",
                    lambda: fine_scale.simplified(
                        q.sampling,
                        fine_scale.Simplified(material.density, 1.0, 0.0, supg.damps_J), projects,
                        fine_scale.Matched(p, x, F, rate), P_fine, F_x_q, scratch,
                    ),
                    (18.0 * gradients + 18.0) * pairs_of(q.sampling)
                    + m * (18 + projection * int(projects)),
                    bytes_of(q.sampling) + _moved([p, x, rate], [P_fine, F_x_q]),
                )
            )  # fmt: skip
        if supg.is_self_adjoint:
            listed.append(
                Pass(
                    "adjoint of the interpolation",
                    lambda: fine_scale.subtract_back(
                        q.spreading, cloud.force, projects, x, P_fine, P, scratch
                    ),
                    18.0 * (pairs_of(q.spreading) + int(projects) * pairs_of(cloud.force))
                    + n * (9 + projection * int(projects)),
                    bytes_of(q.spreading) + bytes_of(cloud.force) + _moved([x, P_fine], [P]),
                )
            )
        if supg.damps_J:
            flux, inertia = components(term.flux), components(term.inertia)
            listed += [
                Pass(
                    "R_p",
                    lambda: pressure.momentum_residual(
                        q.sampling, 1.0, P, inertia, F_x_q, flux, scratch
                    ),
                    24.0 * pairs_of(q.sampling) + 35.0 * m,
                    bytes_of(q.sampling) + _moved([P, inertia, F_x_q], [flux]),
                ),
                Pass(
                    "D(J)",
                    lambda: pressure.volume_dissipation(q.spreading, flux, Jdot, scratch),
                    6.0 * pairs_of(q.spreading) + n,
                    bytes_of(q.spreading) + _moved([flux], [Jdot]),
                ),
            ]
        listed.append(
            Pass(
                "D(p)",
                lambda: fine_scale.momentum_dissipation(q.spreading, P_fine, pdot, scratch),
                18.0 * pairs_of(q.spreading) + 3.0 * n,
                bytes_of(q.spreading) + _moved([P_fine], [pdot]),
            )
        )
    listed += [
        Pass(
            "divergence",
            lambda: galerkin.internal_force(cloud.adjoint, P, pdot, scratch),
            18.0 * pairs_of(cloud.adjoint) + 3.0 * n,
            bytes_of(cloud.adjoint) + _moved([P], [pdot]),
        ),
        Pass(
            "time step",
            lambda: time_step._stretch_limits(p, F, J, sim._time_step._limit, scratch),
            counting.stretch_operations() * n,
            _moved([p, F, J], [sim._time_step._limit]),
        ),
    ]
    return listed


@dataclass(frozen=True)
class Needs:
    """``flops`` and ``bytes`` of a whole step."""

    flops: float
    bytes: float


def lean_needs(sim: sph.Simulation) -> Needs:
    """What a step of the displacement form with a restraint must do at least, however it is fused.

    Two sweeps: positions give a stress, and both give the next positions and momenta.  Each array
    is read and written once a sweep; off a lattice the operator is read in both.  Operations are
    the gradient, the stress, the divergence, and the restraint: on lattice lines a fourth
    difference of five terms along three axes, and its adjoint; elsewhere of every pair of it the
    mean gradient times the pair's arm, and back.  Where the viscosity acts, the velocities need a
    gradient and a restraint of their own: in the mean over its rhythm.
    """
    n, both = sim.cloud.size, 1.0 + viscous_share(sim)
    field, tensor = 3.0 * _DOUBLE, 9.0 * _DOUBLE
    moved = (both * field + tensor) + (both * field + tensor + 4.0 * field)
    work = float(counting.stress_operations(sim.scene.material, has_H=False, has_J=False))
    if isinstance(sim.operator, sph.LatticeDifference):
        # A line has ``order`` terms, each a product and a sum for three components.
        work += (1.0 + both) * 6.0 * 3.0 * sim.operator.order + both * 2.0 * 2.0 * 5.0 * 9.0
        return Needs(n * work, n * moved)
    A = sim.cloud.kinematic
    # Edges of cells: about three a particle, seen from either end.
    edges = 6.0 * n
    return Needs(
        n * work + (1.0 + both) * 18.0 * pairs_of(A) + both * 2.0 * 18.0 * edges,
        n * moved + 2.0 * bytes_of(A),
    )


def update_bytes(sim: sph.Simulation) -> float:
    """Bytes that advancing the fields moves in one step, whatever the integrator: once each way."""
    fields = [sim.state.x, *(sim.state[name] for name in sim._rhs.evolved)]
    stages = max(2, sim.integrator.stages)
    return float(sum(_DOUBLE * field.size * 4 * stages for field in fields))


__all__ = ["Needs", "Pass", "bytes_of", "lean_needs", "pairs_of", "passes", "update_bytes"]
