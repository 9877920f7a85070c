"""A run can be copied, pickled and sent to other processes: the same bits come out everywhere."""

from __future__ import annotations

import copy
import multiprocessing
import os
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid import scenes
from sphsolid.geometry import Box
from sphsolid.record import Energy, EnergyBudget, Reactions
from sphsolid.scenes.cable import Pulse
from sphsolid.scenes.punch import HeldVelocity
from sphsolid.scenes.scene import Scene
from tests.oracles.blocks import loaded_block

MAKE: dict[str, Callable[[], Any]] = {
    "{p,F,J} by position Verlet": lambda: sph.Simulation(loaded_block(), spacing=0.25),
    "{p,F,H,J} by TVD-RK2": lambda: sph.Simulation(
        loaded_block(), spacing=0.25, formulation=sph.PFHJ(), integrator=sph.TVDRK2(), cfl=0.3
    ),
    "B-bar": lambda: fem.Simulation(loaded_block(), spacing=0.25),
}
WAYS: dict[str, Callable[[Any], Any]] = {
    "deepcopy": copy.deepcopy,
    "copy": copy.copy,
    "pickle": lambda sim: pickle.loads(pickle.dumps(sim)),
}
RECORD = (Energy(), EnergyBudget(), Reactions())


def bits(sim: Any) -> dict[str, bytes]:
    found = {name: np.ascontiguousarray(a).tobytes() for name, a in sim.state_arrays().items()}
    return found | {"clock": np.array([sim.time, sim.step]).tobytes()}


@pytest.mark.parametrize("make", MAKE.values(), ids=MAKE)
@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
def test_a_branch_goes_on_like_the_run_and_leaves_it_alone(make: Any, way: Any) -> None:
    sim = make()
    gap = 3.3 * sim.stable_time_step()
    sim.run(until=gap, record=RECORD)
    before, seen = bits(sim), sim.snapshot()
    branch = way(sim)
    assert bits(branch) == before
    np.testing.assert_equal(
        branch.snapshot().budget.reaction_force, seen.budget.reaction_force
    )
    first = branch.run(until=2 * gap, record=RECORD)
    assert bits(sim) == before
    second = sim.run(until=2 * gap, record=RECORD)
    assert bits(branch) == bits(sim)
    assert first.table.equals(second.table)


class Feedback:
    """A load that counts how often it was asked."""

    def __init__(self) -> None:
        self.asked = 0

    def __call__(self, X: Any, t: float) -> Any:
        self.asked += 1
        return np.full_like(X, 1.0 * self.asked)


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_a_load_with_a_memory_has_one_in_each_branch(solver: Any) -> None:
    rubber = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1e3)
    force = Feedback()
    scene = Scene(
        name="s", body=Box(), material=rubber, end_time=1e-3, body_force=force
    )
    sim = solver(scene, spacing=0.5)
    asked = force.asked
    copy.deepcopy(sim).run()
    assert force.asked == asked


PACKAGE = {
    "bending column": scenes.bending_column,
    "cable": scenes.cable,
    "cable with a pulse": lambda: scenes.cable(load=Pulse()),
    "l-shaped block": scenes.l_shaped_block,
    "plate with a hole": lambda: scenes.plate_with_hole(body=Box()),
    "punch": scenes.punch,
    "held punch": lambda: scenes.punch(press=HeldVelocity()),
    "spinning cube": scenes.spinning_cube,
    "swinging cube": scenes.swinging_cube,
    "manufactured cube": lambda: scenes.swinging_cube(manufactured=True, amplitude=0.1),
    "twisting column": scenes.twisting_column,
}


@pytest.mark.parametrize("make", PACKAGE.values(), ids=PACKAGE)
def test_every_scene_of_the_package_goes_to_another_process(make: Any) -> None:
    scene = make()
    found = pickle.loads(pickle.dumps(scene))
    X, N = np.linspace(0.0, 1.0, 30).reshape(10, 3), np.ones((10, 3))
    np.testing.assert_array_equal(found.initial_state(X), scene.initial_state(X))
    for one, other in zip(found.tractions, scene.tractions, strict=True):
        np.testing.assert_array_equal(one.at(X, N, 1e-3), other.at(X, N, 1e-3))
    assert (found.name, found.material, found.probes) == (scene.name, scene.material, scene.probes)


def test_a_scene_that_cannot_go_says_which_function_it_is() -> None:
    rubber = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1e3)

    def swirl(X: Any) -> Any:
        return X

    scene = Scene(
        name="s", body=Box(), material=rubber, end_time=1.0, initial_velocity=swirl
    )
    sim = sph.Simulation(scene, spacing=0.5)
    with pytest.raises((pickle.PicklingError, AttributeError), match="swirl"):
        pickle.dumps(sim)
    copy.deepcopy(sim)


def end_of(spacing: float) -> bytes:
    sim = sph.Simulation(scenes.twisting_column(), spacing=spacing)
    sim.run(until=1e-3)
    return sim.state.x.tobytes()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_process_that_is_forked_after_a_run_can_run_too() -> None:
    here = end_of(0.5)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        found = pool.map_async(end_of, [0.5, 0.5]).get(timeout=300)
    assert found == [here, here]
    assert end_of(0.5) == here


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_running_simulation_goes_on_in_forked_processes_and_their_children() -> None:
    sim = fem.Simulation(scenes.twisting_column(), spacing=0.5)
    sim.run(until=5e-4)
    whole = copy.deepcopy(sim)
    whole.run(until=1e-3)
    child = os.fork()
    if child == 0:
        grandchild = os.fork()
        if grandchild == 0:
            sim.run(until=1e-3)
            os._exit(0 if bits(sim) == bits(whole) else 3)
        inner = os.waitstatus_to_exitcode(os.waitpid(grandchild, 0)[1])
        sim.run(until=1e-3)
        os._exit(inner if bits(sim) == bits(whole) else 4)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def lost(number: int) -> None:
    raise sph.Diverged(
        reason="lost", time=0.5, step=number, particle=1, position=(0.0, 0.0, 1.0), advice="less"
    )


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_lost_solution_comes_back_from_a_worker() -> None:
    """An exception that cannot be unpickled leaves a pool waiting for ever."""
    with (
        multiprocessing.get_context("fork").Pool(1) as pool,
        pytest.raises(sph.Diverged, match=r"lost at t = 0\.5 s, step 7") as failure,
    ):
        pool.map_async(lost, [7]).get(timeout=60)
    assert failure.value.position == (0.0, 0.0, 1.0)


def stepped(sim: Any) -> bytes:
    sim.advance(1e-4)
    return bits(sim)["x"]


@pytest.mark.slow
def test_a_simulation_goes_to_a_spawned_process() -> None:
    sim = sph.Simulation(scenes.twisting_column(), spacing=0.5)
    sim.run(until=5e-4)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there = pool.apply(stepped, (sim,))
    assert there == stepped(sim)
