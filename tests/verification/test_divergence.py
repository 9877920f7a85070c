"""A lost solution stops the run, says where and when, and hands over what there is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.record import Energy
from sphsolid.scenes import swinging_cube, twisting_column
from tests.oracles.blocks import spinning_block

TOO_FAST = {
    "cube": (swinging_cube(amplitude=0.05), 0.25),
    "spin": (spinning_block(), 0.25),
    "column": (twisting_column(), 1.0 / 3.0),
}


@pytest.mark.parametrize("formulation", [sph.PF(), sph.PFHJ(), sph.Displacement()])
@pytest.mark.parametrize("case", list(TOO_FAST))
def test_a_step_ten_times_too_long_is_reported(case: str, formulation: Any) -> None:
    scene, spacing = TOO_FAST[case]
    # A viscosity has a limit of its own, which would make the step no longer than a stable one.
    bare = {"stabilisation": sph.Restraint(viscosity=0.0)}
    options = bare if formulation == sph.Displacement() else {}
    sim = sph.Simulation(scene, spacing=spacing, cfl=3.0, formulation=formulation, **options)
    first = sim.stable_time_step()
    with pytest.raises(sph.Diverged) as caught:
        sim.run(until=100.0 * first, every=2.0 * first, record=[Energy()])
    failure = caught.value
    assert failure.reason in ("negative Jacobian", "non-finite state")
    assert (failure.time, failure.step) == (sim.time, sim.step)
    assert 0.0 < failure.time < 100.0 * first
    assert failure.position == tuple(sim.cloud.X[failure.particle])
    for part in (f"t = {failure.time:.6g} s", f"step {failure.step}", "cfl", "tau_F", "spacing"):
        assert part in str(failure)
    # The particle that is named is invalid, and none before it is.
    s = sim.state
    F = sim._rhs.of_geometry(s).F
    J = s.J if formulation.evolves_J else np.ones(len(s.p))
    finite = np.isfinite(s.p).all(axis=1) & np.isfinite(F).all(axis=(1, 2)) & np.isfinite(J)
    with np.errstate(all="ignore"):
        valid = finite & (np.linalg.det(F) > 0.0) & (J > 0.0)
    assert int(np.flatnonzero(~valid)[0]) == failure.particle


def test_the_history_so_far_is_handed_over_and_holds_only_valid_records() -> None:
    """Also when the solution is lost in the very step that a record would follow."""
    sim = sph.Simulation(spinning_block(), spacing=0.25, cfl=10.0, integrator=sph.TVDRK2())
    with pytest.raises(sph.Diverged) as caught:
        sim.run(until=0.03, every=6.0e-4, record=[Energy()])
    history = caught.value.history  # type: ignore[attr-defined]
    time = history["time [s]"]
    assert len(time) >= 4
    np.testing.assert_allclose(time, 6.0e-4 * np.arange(len(time)), rtol=1e-12)
    assert time[-1] > 0.8 * caught.value.time
    assert np.all(np.isfinite(history.table.to_numpy()))


def test_a_run_whose_last_step_loses_the_solution_does_not_end_well() -> None:
    """One step, ten times too long, straight to the end: no later step is there to notice."""
    scene = swinging_cube(amplitude=0.05)
    sim = sph.Simulation(scene, spacing=0.25, cfl=100.0, formulation=sph.PF())
    with pytest.raises(sph.Diverged):
        sim.run(until=0.5 * sim.stable_time_step(), record=[Energy()])


def test_a_run_within_the_limit_ends() -> None:
    scene = swinging_cube(amplitude=0.05)
    sim = sph.Simulation(scene, spacing=0.25)
    history = sim.run(every=scene.end_time / 10.0, record=[Energy()])
    assert sim.time == scene.end_time
    assert len(history["time [s]"]) == 11
    assert np.all(np.isfinite(history.table.to_numpy()))
