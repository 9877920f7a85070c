"""The finite element simulation as a user meets it."""

import numba
import numpy as np
import pytest

import fem_reference as fem
from sphsolid.compiled import set_threads, threads
from sphsolid.continuum import NeoHookean
from sphsolid.errors import Diverged, InputError
from sphsolid.record import Energy, Probe, Snapshot
from sphsolid.scenes import Box, Constraint, Scene, swinging_cube

MATERIAL = NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.3, density=1000.0)


@pytest.mark.parametrize("cfl", [0.0, -0.5, 1.5, np.nan, np.inf])
def test_a_wrong_cfl_is_refused_with_its_range(cfl: float) -> None:
    with pytest.raises(InputError, match=r"cfl = .*\(0, 1\]"):
        fem.Simulation(swinging_cube(), spacing=0.5, cfl=cfl)


def test_a_wrong_element_and_an_inverting_initial_state_are_refused() -> None:
    with pytest.raises(InputError, match=r"BBarHex\(\)"):
        fem.Simulation(swinging_cube(), spacing=0.5, element="hex")  # type: ignore[arg-type]
    scene = Scene("folded", Box(), MATERIAL, 1.0, initial_displacement=lambda X: -2.0 * X)
    with pytest.raises(InputError, match="inside out"):
        fem.Simulation(scene, spacing=0.5)


def test_time_step_is_cfl_times_edge_over_wave_speed() -> None:
    sim = fem.Simulation(swinging_cube(amplitude=1e-9), spacing=0.25, cfl=0.6)
    wave_speed = np.sqrt(17.0e6 * 0.7 / (1.3 * 0.4) / 1100.0)
    assert wave_speed == pytest.approx(144.24, abs=0.005)
    assert sim.stable_time_step() == pytest.approx(0.6 * 0.25 / wave_speed, rel=1e-7)


def test_run_records_and_lands_on_the_end() -> None:
    scene = swinging_cube()
    sim = fem.Simulation(scene, spacing=0.5)
    history = sim.run(until=2e-3, every=5e-4, record=[Energy(), Probe("corner")])
    assert history["time [s]"].tolist() == [0.0, 5e-4, 1e-3, 1.5e-3, 2e-3]
    assert sim.time == 2e-3
    assert sim.name == "swinging_cube_fem_b_bar_hex"


def test_a_snapshot_is_a_copy_with_consistent_volumes() -> None:
    sim = fem.Simulation(swinging_cube(jitter=0.3), spacing=0.25)
    before = sim.snapshot()
    kept = before.x.copy()
    sim.advance(sim.stable_time_step())
    np.testing.assert_array_equal(before.x, kept)
    assert before.V.sum() == pytest.approx(1.0, rel=1e-14)
    assert before.stress_V.sum() == pytest.approx(1.0, rel=1e-14)
    assert before.field("P").values.shape == (64, 3, 3)
    assert before.field("p").values.shape == (125, 3)


def test_plan_and_summary_say_what_is_active() -> None:
    sim = fem.Simulation(swinging_cube(), spacing=0.25)
    plan = sim.plan()
    for words in ("64 Q1-P0", "125", "none (no load vector", "MB of arrays", "cfl 0.6"):
        assert words in plan
    assert "after 0 steps" in sim.summary()
    loaded = fem.Simulation(swinging_cube(manufactured=True, jitter=0.2), spacing=0.25)
    assert "body force, traction on X-" in loaded.plan()
    assert "hexahedra of any shape" in loaded.plan()
    loaded.advance(1e-5)
    assert "ns per element-step" in loaded.summary()


def test_divergence_tells_where_and_when() -> None:
    sim = fem.Simulation(swinging_cube(amplitude=1e-2), spacing=0.25)
    dt = 10.0 * sim.stable_time_step()

    def explode() -> None:
        for _ in range(100):
            sim.advance(dt)

    with pytest.raises(Diverged, match="inside out") as caught:
        explode()
    failure = caught.value
    assert failure.step == sim.step > 0
    assert failure.time == pytest.approx(sim.step * dt)
    assert 0 <= failure.particle < 64
    assert all(0.0 < X < 1.0 for X in failure.position)
    with pytest.raises(Diverged):
        sim.stable_time_step()


def test_prescribed_motion_is_followed_exactly() -> None:
    # Linear in time: the midpoint drift integrates it without error.
    scene = Scene(
        "pulled",
        Box(),
        MATERIAL,
        1e-2,
        constraints=(
            Constraint("X-", "all"),
            Constraint("X+", "all", lambda X, t: np.tile([4.0 * t, 0.0, 0.0], (len(X), 1))),
        ),
    )
    sim = fem.Simulation(scene, spacing=0.25)
    sim.run()
    end = sim.snapshot()
    right, left = end.X[:, 0] == 1.0, end.X[:, 0] == 0.0
    np.testing.assert_allclose(end.displacement[right, 0], 2.0 * 1e-4, rtol=1e-12)
    np.testing.assert_allclose(end.velocity[right, 0], 4e-2, rtol=1e-14)
    assert np.all(end.displacement[right, 1:] == 0.0)
    assert np.all(end.displacement[left] == 0.0)
    assert np.all(end.velocity[left] == 0.0)
    # The wave has travelled 0.36 m: the next layer follows, the third has not been told.
    assert np.all(end.displacement[end.X[:, 0] == 0.75, 0] > 1e-5)
    assert np.all(np.abs(end.displacement[end.X[:, 0] == 0.25, 0]) < 1e-5)


def test_rollers_and_skew_faces_of_the_cube_hold_exactly() -> None:
    sim = fem.Simulation(swinging_cube(amplitude=0.02), spacing=0.25)
    sim.run(until=3e-3)
    end = sim.snapshot()
    for axis in range(3):
        low, high = end.X[:, axis] == 0.0, end.X[:, axis] == 1.0
        across = [i for i in range(3) if i != axis]
        assert np.all(end.velocity[low, axis] == 0.0)
        assert np.all(end.velocity[np.ix_(high, across)] == 0.0)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one thread only")
def test_bits_do_not_depend_on_the_number_of_threads() -> None:
    def run() -> Snapshot:
        scene = swinging_cube(amplitude=0.02, manufactured=True, jitter=0.3)
        sim = fem.Simulation(scene, spacing=0.125)
        for _ in range(10):
            sim.advance(sim.stable_time_step())
        return sim.snapshot()

    before = threads()
    try:
        set_threads(1)
        one = run()
        set_threads(2)
        two = run()
    finally:
        set_threads(before)
    for name in ("x", "velocity", "F", "J", "P"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert one.strain_energy == two.strain_energy
    assert one.time == two.time
