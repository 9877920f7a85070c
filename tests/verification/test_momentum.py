"""Linear and angular momentum are kept to round-off, term by term and over a run."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from tests.oracles.blocks import FORMULATIONS, spinning_block
from tests.oracles.checkers import force_totals, momentum_drift

ROUND_OFF = 1e-12
OPERATORS = [sph.Literal(), sph.Consistent(), sph.Consistent(use="force")]
SECONDARY = [sph.H1(), sph.H6()]
MIXED = [sph.PF(), sph.PFJ(), sph.PFHJ()]


def tau_p_of(formulation: Any) -> float:
    return 0.2 if formulation.evolves_J else 0.0


@pytest.mark.parametrize("operator", OPERATORS, ids=lambda o: o.name)
@pytest.mark.parametrize("secondary", SECONDARY, ids=lambda s: s.name)
@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_forces_and_dissipation_sum_to_zero(
    formulation: Any, secondary: Any, operator: Any
) -> None:
    """``sum V T = 0``, ``sum V D(p) = 0``, ``sum V D(J) = 0`` in a state without any symmetry."""
    supg = sph.SUPG(tau_F=1.0, xi_F=0.2, tau_p=tau_p_of(formulation), secondary=secondary)
    totals = force_totals(formulation, supg, operator=operator)
    assert set(totals) == ({"T", "D_p", "D_J"} if formulation.evolves_J else {"T", "D_p"})
    for name, share in totals.items():
        assert share < ROUND_OFF, f"sum V {name} is {share:.1e} of sum V |{name}|"


@pytest.mark.parametrize("form", [sph.FullHessian(tau_J=0.5), sph.StabilisedStrains(tau_J=0.5)])
def test_so_do_they_with_the_other_fine_scale_forms(form: Any) -> None:
    supg = sph.SUPG(tau_p=0.2, fine_scale=form)
    assert max(force_totals(sph.PFHJ(), supg).values()) < ROUND_OFF


def spun(formulation: Any, secondary: Any = None, **options: Any) -> sph.Simulation:
    """A free block that spins, drifts and vibrates at strains of a third."""
    secondary = sph.H1() if secondary is None else secondary
    supg = sph.SUPG(tau_F=1.0, xi_F=0.2, tau_p=tau_p_of(formulation), secondary=secondary)
    return sph.Simulation(
        spinning_block(),
        spacing=0.25,
        **{"formulation": formulation, "stabilisation": supg, **options},
    )


@pytest.mark.parametrize("secondary", SECONDARY, ids=lambda s: s.name)
@pytest.mark.parametrize("formulation", MIXED, ids=lambda f: f.name)
def test_both_momenta_are_kept_with_the_projection(formulation: Any, secondary: Any) -> None:
    sim = spun(formulation, secondary)
    start = sim.snapshot()
    linear, angular = momentum_drift(sim)
    assert linear < ROUND_OFF
    assert angular < ROUND_OFF
    # The run was no rigid rotation: it turned, and it stored and gave back energy.
    end = sim.snapshot()
    assert np.max(np.abs(np.swapaxes(start.F, 1, 2) @ start.F - np.eye(3))) > 0.3
    assert abs(end.strain_energy / start.strain_energy - 1.0) > 0.1


@pytest.mark.parametrize("operator", OPERATORS, ids=lambda o: o.name)
def test_they_are_kept_whatever_the_operator(operator: Any) -> None:
    """Angular momentum asks for ``F_x`` of the force's own gradient."""
    assert max(momentum_drift(spun(sph.PFHJ(), operator=operator))) < ROUND_OFF


@pytest.mark.parametrize("formulation", MIXED, ids=lambda f: f.name)
def test_without_the_projection_angular_momentum_drifts(formulation: Any) -> None:
    sim = spun(formulation, angular_momentum=sph.NoProjection())
    linear, angular = momentum_drift(sim)
    assert linear < ROUND_OFF
    assert angular > 1e-4


def test_displacement_sph_needs_no_projection_but_for_its_second_stage() -> None:
    """``F = F_x`` makes ``P F_x^T`` symmetric; stage two sees ``x*``, not ``x^{n+1}``: O(dt^2)."""
    drift = [
        momentum_drift(
            spun(
                sph.Displacement(),
                stabilisation=sph.NoStabilisation(),
                angular_momentum=sph.NoProjection(),
                integrator=sph.TVDRK2(),
                cfl=cfl,
            ),
            steps,
        )[1]
        for cfl, steps in ((0.2, 20), (0.1, 40))
    ]
    assert 3.0 < drift[0] / drift[1] < 9.0
    assert drift[0] < 1e-3
