"""The energy budget and the momentum budget, on scenes where every term acts at once.

The works are integrated by the scheme's own stages, so what is left over is the integrator's
error: it must fall with the step whatever the formulation, the stabilisation, the operator, the
loads; and the momenta must be met by the impulses to round-off at any step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.record import Budget, EnergyBudget, MomentumDrift, Reactions
from sphsolid.scheme import energy_budget
from tests.oracles.blocks import FORMULATIONS, loaded_block, pulled, spinning_block

SPAN = 2.0e-3
FORCE_ONLY = sph.Consistent(use="force")
DAMPED = sph.SUPG(tau_F=0.5, xi_F=0.1)
#: CFL number of a 60th of the span: ``D(J)`` is an Euler term, so its time has to be short.
SHORT = 0.04
VARIANTS: dict[str, dict[str, Any]] = {
    **{f.name: {"formulation": f, "stabilisation": DAMPED} for f in FORMULATIONS},
    "tau_p": {"formulation": sph.PFHJ(), "stabilisation": sph.SUPG(tau_p=0.2), "cfl": SHORT},
    "H6": {
        "formulation": sph.PFJ(),
        "stabilisation": sph.SUPG(tau_p=0.1, secondary=sph.H6()),
        "cfl": SHORT,
    },
    "not adjoint": {"formulation": sph.PFJ(), "operator": FORCE_ONLY},
    "no projection": {"formulation": sph.PF(), "angular_momentum": sph.NoProjection()},
    "undamped": {"formulation": sph.PFJ(), "stabilisation": sph.NoStabilisation()},
}


def advanced(sim: Any, steps: int) -> Budget:
    sim.track_budget()
    for _ in range(steps):
        sim.advance(SPAN / steps)
    balance = sim.snapshot().budget
    assert isinstance(balance, Budget)
    return balance


def rest(sim: Any) -> float:
    return EnergyBudget().record(sim.snapshot(), sim.scene)["energy_rest [J]"]


def block(**options: Any) -> sph.Simulation:
    return sph.Simulation(loaded_block(), spacing=0.25, **options)


@pytest.mark.parametrize("name", VARIANTS)
def test_the_ledger_closes_with_the_step(name: str) -> None:
    left = []
    for steps in (60, 120):
        sim = block(**VARIANTS[name])
        balance = advanced(sim, steps)
        left.append(abs(rest(sim)))
    assert left[1] < 2e-4 * sum(abs(work) for work in balance.works.values())
    assert np.log2(left[0] / left[1]) > 1.9


def test_every_term_is_needed() -> None:
    """Leave one column out and the ledger no longer closes: none is decoration."""
    steps = 480
    sim = block(
        formulation=sph.PFJ(), stabilisation=sph.SUPG(tau_p=0.2), operator=FORCE_ONLY,
        cfl=SHORT * 60 / steps,
    )  # fmt: skip
    balance = advanced(sim, steps)
    left = abs(rest(sim))
    assert tuple(balance.works) == (*energy_budget.TERMS, "dissipation_p", "dissipation_J")
    for name, work in balance.works.items():
        assert abs(work) > 20.0 * left, name


def test_absent_terms_are_exactly_zero() -> None:
    sim = sph.Simulation(
        spinning_block(), spacing=0.25, formulation=sph.PFJ(),
        stabilisation=sph.NoStabilisation(), angular_momentum=sph.NoProjection(),
    )  # fmt: skip
    balance = advanced(sim, 20)
    assert all(work == 0.0 for work in balance.works.values())


@pytest.mark.parametrize("steps", [20, 60])
@pytest.mark.parametrize("operator", [sph.Consistent(), FORCE_ONLY, sph.Literal()], ids=str)
def test_momenta_are_met_by_the_impulses(operator: Any, steps: int) -> None:
    """Linear at any step.  Angular too, apart from a face driven with varying speed."""
    sim = block(formulation=sph.PFJ(), stabilisation=sph.SUPG(tau_p=0.1), operator=operator)
    balance = advanced(sim, steps)
    row = MomentumDrift().record(sim.snapshot(), sim.scene)
    assert row["linear_drift [kg m/s]"] < 1e-12 * row["linear_scale [kg m/s]"]
    assert row["linear_drift_step [kg m/s]"] < 1e-12 * row["linear_scale [kg m/s]"]
    # The jump that stage one makes to a driven velocity has no lever arm of second order.
    assert row["angular_drift [kg m^2/s]"] < 1e-5 * row["angular_scale [kg m^2/s]"]
    assert np.abs(balance.traction_impulse).max() > 0.0


def test_angular_momentum_is_exact_under_tractions() -> None:
    scene = spinning_block()
    scene = sph.scenes.Scene(
        **(vars(scene) | {"tractions": (sph.scenes.Traction("X+", pulled),)})
    )
    sim = sph.Simulation(scene, spacing=0.25, formulation=sph.PFHJ(), stabilisation=DAMPED)
    balance = advanced(sim, 30)
    row = MomentumDrift().record(sim.snapshot(), sim.scene)
    assert row["angular_drift [kg m^2/s]"] < 1e-13 * row["angular_scale [kg m^2/s]"]
    assert np.linalg.norm(balance.traction_impulse[1]) > 1e-3 * row["angular_scale [kg m^2/s]"]


def test_without_projection_the_drift_shows() -> None:
    sim = sph.Simulation(
        spinning_block(), spacing=0.25, angular_momentum=sph.NoProjection(),
        formulation=sph.PF(),
    )  # fmt: skip
    advanced(sim, 30)
    row = MomentumDrift().record(sim.snapshot(), sim.scene)
    assert row["angular_drift [kg m^2/s]"] > 1e-6 * row["angular_scale [kg m^2/s]"]


def test_keeping_an_account_changes_no_bit() -> None:
    plain, tracked = block(), block()
    tracked.track_budget()
    for sim in (plain, tracked):
        for _ in range(5):
            sim.advance(1e-5)
    for field in ("p", "x", "F"):
        np.testing.assert_array_equal(
            getattr(plain.state, field), getattr(tracked.state, field)
        )


def test_finite_elements_keep_the_same_account() -> None:
    left = []
    for steps in (60, 120):
        sim = fem.Simulation(loaded_block(), spacing=0.25)
        balance = advanced(sim, steps)
        left.append(abs(rest(sim)))
        row = MomentumDrift().record(sim.snapshot(), sim.scene)
        assert row["linear_drift [kg m/s]"] < 1e-12 * row["linear_scale [kg m/s]"]
        assert row["angular_drift [kg m^2/s]"] < 1e-12 * row["angular_scale [kg m^2/s]"]
    assert left[1] < 1e-3 * sum(abs(work) for work in balance.works.values())
    assert np.log2(left[0] / left[1]) > 1.8


def test_both_solvers_feel_the_same_reactions() -> None:
    """Impulse on the driven face: two methods, one problem, agreement within the mesh."""
    found = []
    for sim in (block(stabilisation=DAMPED), fem.Simulation(loaded_block(), spacing=0.25)):
        balance = advanced(sim, 120)
        assert set(balance.reaction_impulse) == {"X-", "Y-"}
        found.append(balance.reaction_impulse["X-"])
        row = Reactions().record(sim.snapshot(), sim.scene)
        assert row["reaction_impulse_X-_x [N s]"] == balance.reaction_impulse["X-"][0]
        assert np.isfinite(row["reaction_X-_x [N]"])
    assert np.linalg.norm(found[0] - found[1]) < 0.1 * np.linalg.norm(found[1])


def test_a_recorder_without_its_account_is_refused() -> None:
    sim = block()
    with pytest.raises(InputError, match=r"track_budget\(\)"):
        EnergyBudget().record(sim.snapshot(), sim.scene)


def test_run_opens_the_account_when_a_recorder_asks() -> None:
    history = block().run(until=2e-5, every=1e-5, record=[EnergyBudget()])
    assert len(history.table) == 3
    assert history["energy_rest [J]"][0] == 0.0
