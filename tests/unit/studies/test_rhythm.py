"""Steps are timed in whole cycles."""

from __future__ import annotations

import pytest

import sphsolid as sph
from sphsolid.scenes import swinging_cube
from sphsolid.scheme.restraint_term import CYCLE, PUSHES
from studies.measures.rhythm import cycle, viscous_share
from studies.measures.turns import Windows
from studies.methods import B_BAR, PACKAGE, SUPG

SCENE = swinging_cube(poisson_ratio=0.3)


def test_a_cycle_is_that_of_the_viscosity() -> None:
    default, steady, still = (
        method.simulation(SCENE, spacing=0.25)
        for method in (
            PACKAGE,
            PACKAGE.but(stabilisation=sph.Restraint(spaced=False)),
            PACKAGE.but(stabilisation=sph.Restraint(viscosity=0.0)),
        )
    )
    assert [cycle(sim) for sim in (default, steady, still)] == [CYCLE, 1, 1]
    shares = [viscous_share(sim) for sim in (default, steady, still)]
    assert shares == [len(PUSHES) / CYCLE, 1.0, 0.0]
    for method in (SUPG, B_BAR):
        assert cycle(method.simulation(SCENE, spacing=0.5)) == 1


@pytest.mark.parametrize("window_s", [0.0, 1e-3, 0.02])
def test_a_window_has_whole_cycles(window_s: float) -> None:
    sim = PACKAGE.simulation(SCENE, spacing=0.25)
    steps = Windows(sim, window_s).steps
    assert steps % CYCLE == 0
    assert steps >= CYCLE
