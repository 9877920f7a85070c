"""A simulation's operators as the dense matrices that ``numpy_sph`` wants."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.scheme import IntrinsicTime
from tests.oracles import numpy_sph

Array = NDArray[np.float64]


def dense(pairs: PairList, values: Array, columns: int) -> Array:
    """``(R, columns, ...)`` from values of pairs ``(P, ...)``, entry by entry."""
    matrix = np.zeros((pairs.rows, columns, *values.shape[1:]))
    for row in range(pairs.rows):
        for k in range(pairs.indptr[row], pairs.indptr[row + 1]):
            matrix[row, pairs.indices[k]] = values[k]
    return matrix


def body_of(
    sim: sph.Simulation,
    *,
    loads: Callable[[float], tuple[Array, Array]],
    held: NDArray[np.bool_],
    velocity: Callable[[float], Array],
) -> numpy_sph.Body:
    """Operators of ``sim``; loads and constraints are stated again by the caller."""
    cloud, m = sim.cloud, sim.scene.material
    n = cloud.size
    V_q, G_q, W_q = np.zeros(0), np.zeros((0, n, 3)), np.zeros((0, n))
    if sim.secondary is not None:
        sample = dense(sim.secondary.pairs, sim.secondary.sample, n)
        V_q, G_q, W_q = sim.secondary.V, sample[:, :, :3], sample[:, :, 3]
    return numpy_sph.Body(
        law=numpy_sph.MooneyRivlin(m.varsigma, m.xi, m.kappa, m.mu),
        density=m.density,
        V=cloud.V,
        G_kinematic=dense(cloud.pairs, cloud.gradients.kinematic, n),
        G_force=dense(cloud.pairs, cloud.gradients.force, n),
        V_q=V_q,
        G_q=G_q,
        W_q=W_q,
        loads=loads,
        held=held,
        velocity=velocity,
    )


def options_of(sim: sph.Simulation) -> numpy_sph.Options:
    """The same choices in the oracle's words."""
    f, s = sim.formulation, sim.stabilisation
    evolved = "".join(
        name
        for name, on in (("F", f.evolves_F), ("H", f.evolves_H), ("J", f.evolves_J))
        if on
    )
    projects = isinstance(sim.angular_momentum, sph.LocalProjection)
    if not isinstance(s, sph.SUPG):
        return numpy_sph.Options(evolved, "none", projects=projects)
    form = {
        sph.SimplifiedHessian: "simplified",
        sph.FullHessian: "hessian",
        sph.StabilisedStrains: "strains",
    }[type(s.fine_scale)]
    # The oracle has times in units of the step alone.
    tau = {name: as_step(time) for name, time in s.intrinsic_times.items()}
    xi = [getattr(s.fine_scale, name, 0.0) for name in ("xi_H", "xi_J")]
    return numpy_sph.Options(
        evolved,
        form,
        tau=(tau["tau_F"], tau["tau_H"], tau["tau_J"]),
        xi=(s.xi_F, xi[0], xi[1]),
        tau_p=tau["tau_p"],
        projects=projects,
        gamma=getattr(s.fine_scale, "gamma", None),
        alpha=getattr(s.fine_scale, "alpha", None),
    )


def as_step(time: IntrinsicTime) -> float:
    """The number of a time of the step."""
    assert isinstance(time, sph.OfStep)
    return time.c


def fields_of(sim: sph.Simulation) -> numpy_sph.Fields:
    """Copies of the state; fields that are not evolved are filled with their dependent values."""
    s = sim.state
    H = s.H.copy() if sim.formulation.evolves_H else numpy_sph.cof(s.F)
    J = s.J.copy() if sim.formulation.evolves_J else np.linalg.det(s.F)
    return numpy_sph.Fields(s.p.copy(), s.x.copy(), s.F.copy(), H, J)
