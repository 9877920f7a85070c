"""Two problems are told apart by what their functions say."""

from __future__ import annotations

import re

import numpy as np
import pytest

from sphsolid.continuum import NeoHookean
from sphsolid.errors import InputError
from sphsolid.geometry import Box
from sphsolid.record import RunFolder, march, restore, write_checkpoint
from sphsolid.record.samples import Sampler, differences, instants
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene, Traction

RUBBER = NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)
MESH = Box().mesh(0.25)


def scene(**parts):
    return Scene(name="s", body=Box(), material=RUBBER, end_time=2.0, **parts)


def told_apart(one, other):
    """What is found to differ between two scenes at the instants of the first."""
    times = instants(one)
    return differences(Sampler(one, MESH).at(times), Sampler(other, MESH).at(times), times)


def pull(size, face="Z+"):
    return Traction(face, lambda X, N, t: size * N)


def late(size):
    return lambda X, t: np.full_like(X, size if 0.8 < t < 1.1 else 0.0)


def swapped(X):
    """The speeds of two points, exchanged."""
    v = X.copy()
    v[[3, 40]] = v[[40, 3]]
    return v


DIFFERENT = {
    "size of a traction": (
        {"tractions": (pull(1e4),)}, {"tractions": (pull(1e5),)},
        r"^traction on Z\+ differs: at t = 0 s its mean is \(0, 0, 10000\) there and",
    ),
    "second traction on a face": (
        {"tractions": (pull(1.0), pull(2.0))}, {"tractions": (pull(1.0), pull(2.1))},
        r"^traction on Z\+ \(2\) differs",
    ),
    "body force that begins later": (
        {"body_force": late(1.0)}, {"body_force": late(2.0)}, "^body force differs: at t = ",
    ),
    "motion": (
        {"constraints": (Constraint("Z-", "all", lambda X, t: 0.0 * X),)},
        {"constraints": (Constraint("Z-", "all", lambda X, t: 0.0 * X + 5.0),)},
        "^prescribed velocity on Z- differs",
    ),
    "initial velocity of two points": (
        {"initial_velocity": lambda X: X.copy()}, {"initial_velocity": swapped},
        "^initial velocity differs: its root mean square and spread",
    ),
    "initial displacement": (
        {}, {"initial_displacement": lambda X: 1e-6 * X}, "^initial displacement differs",
    ),
    "stated strain": (
        {"initial_deformation_gradient": lambda X: np.tile(np.eye(3), (len(X), 1, 1))},
        {"initial_deformation_gradient": lambda X: np.tile(1.01 * np.eye(3), (len(X), 1, 1))},
        "^initial deformation gradient differs",
    ),
    "load that is not there": ({}, {"body_force": late(1.0)}, "^body force: only here"),
}  # fmt: skip


@pytest.mark.parametrize(("one", "other", "named"), DIFFERENT.values(), ids=DIFFERENT)
def test_what_differs_is_named(one, other, named):
    found = told_apart(scene(**one), scene(**other))
    assert len(found) == 1
    assert re.search(named, found[0]), found[0]
    assert told_apart(scene(**one), scene(**one)) == []


def test_what_another_processor_rounds_otherwise_is_the_same():
    assert told_apart(scene(body_force=lambda X, t: 3.0 * X), scene(
        body_force=lambda X, t: 3.0 * X * (1.0 + 2e-15)
    )) == []  # fmt: skip


def test_a_function_without_an_answer_at_an_instant_may_be_sampled():
    def until_one(X, t):
        if t > 1.0:
            raise ValueError("the table ends")
        return np.zeros_like(X)

    assert told_apart(scene(body_force=until_one), scene(body_force=until_one)) == []


def test_a_function_with_a_memory_does_not_notice():
    class Counting:
        calls = 0

        def __call__(self, X, t):
            self.calls += 1
            return np.full_like(X, self.calls)

    force = Counting()
    Sampler(scene(body_force=force), MESH).at([0.0, 1.0])
    assert force.calls == 0


def test_a_checkpoint_carries_the_samples(fake_solver, tmp_path):
    path = tmp_path / "c.npz"
    write_checkpoint(fake_solver(), path)
    other = fake_solver()
    other.load = 2.0
    named = r"load differs: at t = 0 s its mean is \(1, 0, 0\) there and \(2, 0, 0\) here"
    with pytest.raises(InputError, match=named):
        restore(other, path)
    assert other.changed == 0


def test_what_a_run_has_cost_goes_on(fake_solver, tmp_path):
    solver = fake_solver()
    march(solver, until=0.1)
    solver.seconds = 41.0
    write_checkpoint(solver, tmp_path / "c.npz")
    other = fake_solver()
    restore(other, tmp_path / "c.npz")
    assert other.seconds == 41.0


def on(t, begin, end=np.inf):
    return lambda X, now: np.full_like(X, 1.0 if begin * t <= now < end * t else 0.0)


@pytest.mark.parametrize("begin", [0.02, 0.5, 0.7, 0.96])
def test_a_pulse_of_a_fiftieth_is_seen_wherever_it_is(begin):
    other = scene(body_force=on(2.0, begin, begin + 0.02))
    assert told_apart(scene(body_force=lambda X, t: 0.0 * X), other)


@pytest.mark.parametrize("begin", [0.95, 0.98, 0.9999, 1.0])
def test_what_begins_late_is_seen(begin):
    [said] = told_apart(scene(body_force=lambda X, t: 0.0 * X), scene(body_force=on(2.0, begin)))
    assert "body force differs: at t = 2 s" in said or begin < 0.99


def sampled(solver, *, body_force):
    """The solver that solves nothing, with a real sampler of its scene."""
    solver.scene = scene(body_force=body_force)
    solver.samples = Sampler(solver.scene, MESH).at
    return solver


@pytest.mark.parametrize("until", [5.0, 0.3])
def test_the_time_of_the_run_is_sampled_too(fake_solver, tmp_path, until):
    still = sampled(fake_solver(), body_force=lambda X, t: 0.0 * X)
    run = RunFolder(tmp_path / "run")
    march(still, until=until, every=0.1, output=run)
    inside = on(1.0, 0.91 * until, 0.95 * until)
    with pytest.raises(InputError, match="body force differs"):
        restore(sampled(fake_solver(), body_force=inside), tmp_path / "run" / "checkpoint.npz")
    restore(
        sampled(fake_solver(), body_force=lambda X, t: 0.0 * X), tmp_path / "run" / "checkpoint.npz"
    )


def test_the_next_steps_are_sampled(fake_solver, tmp_path):
    def solver(force):
        return sampled(fake_solver(dt=lambda t: 1e-4), body_force=force)

    still = solver(lambda X, t: 0.0 * X)
    march(still, until=0.01)
    write_checkpoint(still, tmp_path / "c.npz")
    spike = solver(on(1.0, 0.01 + 0.9e-4, 0.01 + 1.1e-4))
    with pytest.raises(InputError, match=r"body force differs: at t = 0\.0101 s"):
        restore(spike, tmp_path / "c.npz")


def test_every_instant_is_asked_once(fake_solver):
    asked = []

    def force(X, t):
        asked.append(t)
        return 0.0 * X

    sampler = Sampler(scene(body_force=force), MESH)
    first = sampler.at([0.0, 1.0])["body force"]
    again = sampler.at([0.0, 1.5, 1.0])["body force"]
    assert asked == [0.0, 1.0, 1.5]
    np.testing.assert_array_equal(again[[0, 2]], first)
