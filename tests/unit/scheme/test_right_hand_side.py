"""Rates and whole steps of every formulation and stabilisation against plain numpy."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.stabilisation import Stabilisation
from tests.oracles import numpy_sph
from tests.oracles.blocks import (
    FORMULATIONS,
    held_in_loaded_block,
    loaded_block,
    loads_in_loaded_block,
    velocity_in_loaded_block,
)
from tests.oracles.checkers import rates_at
from tests.oracles.dense import body_of, fields_of, options_of

Array = NDArray[np.float64]
STABILISATIONS = ("none", "H1 simplified", "H6 simplified", "hessian", "strains")


def stabilisation_of(name: str, f: Formulation) -> Stabilisation:
    """Every term that the formulation allows is switched on, all coefficients different."""
    if name == "none":
        return sph.NoStabilisation()
    tau_p = 0.3 if f.evolves_J else 0.0
    tau_H, tau_J = (0.4 if f.evolves_H else 0.0), (0.6 if f.evolves_J else 0.0)
    if name == "hessian":
        form = sph.FullHessian(tau_H=tau_H, tau_J=tau_J)
        return sph.SUPG(tau_F=0.8, xi_F=0.2, tau_p=tau_p, fine_scale=form)
    if name == "strains":
        strains = sph.StabilisedStrains(
            tau_H=tau_H, tau_J=tau_J, xi_H=tau_H / 3.0, xi_J=tau_J / 4.0
        )
        return sph.SUPG(tau_F=0.8, xi_F=0.2, tau_p=tau_p, fine_scale=strains)
    secondary = sph.H6() if "H6" in name else sph.H1()
    return sph.SUPG(tau_F=0.9, xi_F=0.2, tau_p=tau_p, secondary=secondary)


def disturbed(
    formulation: Formulation,
    stabilisation: Stabilisation,
    *,
    projection: sph.LocalProjection | sph.NoProjection | None = None,
    operator: sph.Consistent | sph.Literal | None = None,
) -> sph.Simulation:
    """The loaded block of 4 cells a side with evolved strains that fit neither x nor each other."""
    sim = sph.Simulation(
        loaded_block(),
        spacing=0.25,
        formulation=formulation,
        stabilisation=stabilisation,
        operator=sph.Consistent(use="force") if operator is None else operator,
        angular_momentum=projection,
        integrator=sph.TVDRK2(),
    )
    random = np.random.default_rng(11)
    evolved = [sim.state.F] if formulation.evolves_F else []
    for field in [*evolved, sim.state.H, sim.state.J]:
        field += 0.05 * random.uniform(-1.0, 1.0, field.shape)
    sim.state.p[:] += 500.0 * random.uniform(-1.0, 1.0, sim.state.p.shape)
    sim._stepper.essential.impose(sim.state.p, 0.0)
    return sim


def oracle_of(sim: sph.Simulation) -> numpy_sph.Body:
    X = sim.cloud.X
    return body_of(
        sim,
        loads=lambda t: loads_in_loaded_block(sim.cloud, t),
        held=held_in_loaded_block(X),
        velocity=lambda t: velocity_in_loaded_block(X, t),
    )


def mismatch(mine: Array, exact: Array) -> float:
    """Largest difference over the largest value; zero for a field that is not evolved."""
    return float(np.max(np.abs(mine - exact)) / np.max(np.abs(exact))) if mine.size else 0.0


def step_mismatch(sim: sph.Simulation, steps: int = 3) -> dict[str, float]:
    """Difference between the increments of simulation and oracle over a few steps, per field."""
    body, options = oracle_of(sim), options_of(sim)
    start = fields = fields_of(sim)
    t = 0.0
    for _ in range(steps):
        dt = sim.stable_time_step()
        fields = numpy_sph.step(body, options, fields, dt, t)
        sim.advance(dt)
        t += dt
    found = {}
    for name in ("p", "x", "F", "H", "J"):
        before, after = getattr(start, name), getattr(fields, name)
        mine = getattr(sim.state, name)
        found[name] = mismatch(mine - before, after - before) if mine.size else 0.0
    return found


@pytest.mark.parametrize("stabilisation", STABILISATIONS)
@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_three_steps_agree_with_numpy(formulation: Formulation, stabilisation: str) -> None:
    sim = disturbed(formulation, stabilisation_of(stabilisation, formulation))
    for name, difference in step_mismatch(sim).items():
        assert difference < 1e-12, f"{name} differs by {difference:.1e} of its change"


@pytest.mark.parametrize("operator", [sph.Literal(), sph.Consistent()], ids=lambda o: o.name)
@pytest.mark.parametrize("stabilisation", STABILISATIONS)
def test_three_steps_agree_without_projection(
    operator: sph.Literal | sph.Consistent, stabilisation: str
) -> None:
    sim = disturbed(
        sph.PFHJ(),
        stabilisation_of(stabilisation, sph.PFHJ()),
        projection=sph.NoProjection(),
        operator=operator,
    )
    assert max(step_mismatch(sim).values()) < 1e-12


@pytest.mark.parametrize(
    "form", [sph.SimplifiedHessian(gamma=3.0e7, alpha=9.0e6), sph.FullHessian(alpha=9.0e6)]
)
def test_the_moduli_of_the_user_are_those_used(form: sph.SimplifiedHessian) -> None:
    chosen = disturbed(sph.PF(), sph.SUPG(tau_F=0.9, xi_F=0.2, fine_scale=form))
    assert max(step_mismatch(chosen).values()) < 1e-12
    default = disturbed(sph.PF(), sph.SUPG(tau_F=0.9, xi_F=0.2, fine_scale=type(form)()))
    assert mismatch(stage(chosen)[0].D_p, stage(default)[0].D_p) > 1e-2


def stage(sim: sph.Simulation, t: float = 1e-3) -> tuple[numpy_sph.Rates, numpy_sph.Body]:
    """One evaluation by both; the simulation's is left in ``sim._rhs``."""
    dt = sim.stable_time_step()
    body = oracle_of(sim)
    exact = numpy_sph.rates(body, options_of(sim), fields_of(sim), sim.state.x, dt, t)
    rates_at(sim, step=dt, t=t)
    return exact, body


@pytest.mark.parametrize("name", ["H1 simplified", "H6 simplified", "hessian", "strains"])
def test_every_pass_of_a_stage_agrees_with_numpy(name: str) -> None:
    """Not only their sum: a term that is small beside the others is judged by its own size."""
    sim = disturbed(sph.PFHJ(), stabilisation_of(name, sph.PFHJ()))
    exact, body = stage(sim)
    rates = sim._rhs.rates
    free = ~body.held
    E = loads_in_loaded_block(sim.cloud, 1e-3)[0]
    bare = disturbed(sph.PFHJ(), sph.NoStabilisation())
    stage(bare)
    assert mismatch(sim._rhs.P, exact.P) < 1e-13
    assert mismatch(sim._rhs.terms[0].P_fine, exact.P_fine) < 1e-12
    assert mismatch(rates.F, exact.F) < 1e-13
    assert mismatch(rates.H, exact.H) < 1e-13
    force = bare._rhs.rates.p
    assert mismatch((E - force)[free], exact.T[free]) < 1e-12
    D_p = rates.p - force
    assert mismatch(D_p[free], exact.D_p[free]) < 1e-11
    assert mismatch(rates.J - bare._rhs.rates.J, exact.D_J) < 1e-11
    # None of the passes is idle in this state.
    size = np.max(np.abs(exact.T))
    assert np.max(np.abs(exact.D_p)) > 1e-3 * size
    assert np.max(np.abs(exact.D_J)) > 1e-3 * np.max(np.abs(exact.J))


def test_the_fine_scale_forms_are_different_methods() -> None:
    """Agreement with the oracle says something: the options lead to different forces."""
    forces = [
        stage(disturbed(sph.PFHJ(), stabilisation_of(name, sph.PFHJ())))[0].D_p
        for name in ("H1 simplified", "H6 simplified", "hessian", "strains")
    ]
    for k, one in enumerate(forces):
        for other in forces[:k]:
            assert mismatch(one, other) > 1e-2


def test_the_comparison_notices_each_term() -> None:
    """The oracle with one term changed must disagree with the simulation."""
    sim = disturbed(sph.PFHJ(), stabilisation_of("H1 simplified", sph.PFHJ()))
    exact, _ = stage(sim)
    body, dt = oracle_of(sim), sim.stable_time_step()
    options = options_of(sim)
    for change in ({"tau_p": -0.3}, {"xi": (0.1, 0.0, 0.0)}, {"projects": False}, {"form": "none"}):
        wrong = numpy_sph.rates(
            body,
            numpy_sph.Options(**{**vars(options), **change}),
            fields_of(sim),
            sim.state.x,
            dt,
            1e-3,
        )
        differs = max(mismatch(wrong.p, exact.p), mismatch(wrong.J, exact.J))
        assert differs > 1e-4, change
