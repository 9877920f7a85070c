"""A result does not depend on how it is watched: records, progress, where a run was resumed.

Steps are shortened to meet records, so two runs that are watched differently take different steps
and agree to the order of the integrator, which the CFL numbers here keep below what is asked.
Where the steps are the same, so are the bits.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.record import (
    AngularMomentum,
    Energy,
    EnergyBudget,
    MomentumDrift,
    Progress,
    Reactions,
    RunFolder,
)
from sphsolid.scenes import Box, Scene, twisting_column
from tests.oracles.blocks import spinning_block
from tests.oracles.checkers import total_energy

#: Share of the energy by which two ways of watching may differ.
SAME = 2e-4
SPAN = 4.0e-3
RECORD = (Energy(), AngularMomentum(), EnergyBudget(), MomentumDrift(), Reactions())
STRAINS = sph.StabilisedStrains(tau_H=0.5, tau_J=sph.OfMesh(0.2), xi_J=0.1)


def block(**options: Any) -> Any:
    return sph.Simulation(spinning_block(), spacing=0.25, **options)


#: Every time, of either kind, with every integrator that there is, and both solvers.
MAKE: dict[str, Callable[[], Any]] = {
    "default {p,F}": lambda: block(formulation=sph.PF(), cfl=0.1),
    "default {p,F,J}": lambda: block(formulation=sph.PFJ(), cfl=0.1),
    "paper": lambda: block(
        formulation=sph.PFJ(),
        stabilisation=sph.SUPG(tau_F=1.0, xi_F=0.2, tau_p=0.1),
        integrator=sph.TVDRK2(),
        cfl=0.07,
    ),
    "full Hessian": lambda: block(
        formulation=sph.PFHJ(),
        integrator=sph.SSPRK3(),
        cfl=0.1,
        stabilisation=sph.SUPG(
            tau_F=0.5, tau_p=sph.OfMesh(0.1), fine_scale=sph.FullHessian(tau_H=0.4, tau_J=0.6)
        ),
    ),
    "stabilised strains": lambda: block(
        formulation=sph.PFHJ(),
        integrator=sph.SSPRK3(),
        stabilisation=sph.SUPG(tau_F=0.5, fine_scale=STRAINS),
        cfl=0.1,
    ),
    "B-bar elements": lambda: fem.Simulation(spinning_block(), spacing=0.25, cfl=0.1),
}


def kept(sim: Any, every: float | None, until: float = SPAN) -> float:
    """Share of the energy that is left."""
    start = total_energy(sim.snapshot())
    sim.run(until=until, every=every)
    return total_energy(sim.snapshot()) / start


@pytest.mark.parametrize("case", MAKE)
def test_how_often_a_run_is_recorded_does_not_matter(case: str) -> None:
    dt = MAKE[case]().stable_time_step()
    found = [kept(MAKE[case](), every) for every in (None, 1.0e-3, 0.4 * dt)]
    assert max(found) - min(found) < SAME, found


@pytest.mark.slow
@pytest.mark.parametrize("cells", [3, 4])
@pytest.mark.parametrize("how", ["default", "paper"])
def test_nor_does_it_on_the_twisting_column(how: str, cells: int) -> None:
    """50 ms, half a turn of the top and back, in which every time acts for hundreds of steps."""
    paper = {
        "stabilisation": sph.SUPG(tau_F=1.0, xi_F=0.2, tau_p=0.1), "integrator": sph.TVDRK2(),
        "cfl": 0.15,
    }  # fmt: skip
    options: dict[str, Any] = {"default": {}, "paper": paper}[how]

    def make() -> Any:
        return sph.Simulation(
            twisting_column(), spacing=1.0 / cells, formulation=sph.PFJ(), **options
        )

    dt = make().stable_time_step()
    found = [kept(make(), every, 0.05) for every in (None, 1.0e-3, 0.5 * dt, 0.1 * dt)]
    assert max(found) - min(found) < SAME, found


@pytest.mark.parametrize("case", ["default {p,F,J}", "paper", "B-bar elements"])
def test_a_run_resumed_with_other_records_goes_on_as_it_would_have(
    case: str, tmp_path: Path
) -> None:
    whole = kept(MAKE[case](), None)
    first, second = MAKE[case](), MAKE[case]()
    start = total_energy(first.snapshot())
    first.run(until=0.5 * SPAN, every=0.25 * SPAN, output=RunFolder(tmp_path))
    every = 0.3 * second.stable_time_step()
    second.run(until=SPAN, every=every, output=RunFolder(tmp_path, resume=True))
    assert second.step > 3 * first.step
    assert abs(total_energy(second.snapshot()) / start - whole) < SAME


def curious(sim: Any) -> Callable[[Progress], None]:
    """Somebody who looks at everything, twice."""

    def look(progress: Progress) -> None:
        for _ in range(2):
            sim.stable_time_step()
            sim.snapshot()
            sim.plan()
            sim.summary()
            sim.state_arrays()

    return look


@pytest.mark.parametrize("case", MAKE)
def test_who_looks_on_changes_no_bit(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sphsolid.record.progress.TICK", 0.0)
    alone, watched = MAKE[case](), MAKE[case]()
    gap = 3.3 * alone.stable_time_step()
    alone.run(until=4.0 * gap, every=gap)
    watched.run(until=4.0 * gap, every=gap, record=RECORD, progress=curious(watched))
    assert watched.step == alone.step
    kept_arrays = alone.state_arrays()
    for name, array in watched.state_arrays().items():
        if not name.startswith("budget."):
            np.testing.assert_array_equal(array, kept_arrays[name])


def test_the_comparison_would_see_times_of_the_step_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: the step that is shortened to meet records is the one that times are shares of."""
    right = sph.Simulation.advance

    def advance(self: sph.Simulation, dt: float) -> None:
        self._allowed = dt
        right(self, dt)

    monkeypatch.setattr(sph.Simulation, "advance", advance)
    dt = MAKE["paper"]().stable_time_step()
    found = [kept(MAKE["paper"](), every) for every in (None, 0.2 * dt)]
    assert abs(found[1] - found[0]) > 10.0 * SAME


@pytest.mark.parametrize("nu", [0.3, 0.495])
def test_times_of_the_mesh_do_not_know_the_cfl_number(nu: float) -> None:
    found = []
    for cfl in (0.1, 0.05):
        sim = sph.Simulation(
            twisting_column(poisson_ratio=nu), spacing=0.5, formulation=sph.PF(), cfl=cfl
        )
        found.append(kept(sim, None, 5.0e-3))
    assert abs(found[1] - found[0]) < SAME


def test_looking_does_not_change_the_step_of_a_law_that_stiffens() -> None:
    """Off lattices ``F`` is kept: that of the last evaluation, until somebody looks."""
    material = sph.SaintVenantKirchhoff.from_young(
        young_modulus=1.0e6, poisson_ratio=0.3, density=1000.0
    )
    scene = Scene(
        "whirl", Box(jitter=0.3), material, 1.0,
        initial_velocity=lambda X: 3.0 * np.sin(3.0 * X[:, [1, 0, 2]]) * np.array([1.0, -1.0, 0.0]),
    )  # fmt: skip

    def steps(look: Callable[[Any], object]) -> list[float]:
        sim = sph.Simulation(scene, spacing=0.5, stabilisation=sph.Restraint(viscosity=0.002))
        found = []
        for _ in range(12):
            look(sim)
            found.append(sim.stable_time_step())
            sim.advance(found[-1])
        return found

    assert steps(lambda sim: sim.placement()) == steps(lambda sim: None)
