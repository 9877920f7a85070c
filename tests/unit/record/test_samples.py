"""Two problems are told apart by what their functions say."""

from __future__ import annotations

import re

import numpy as np
import pytest

from sphsolid.continuum import NeoHookean
from sphsolid.errors import InputError
from sphsolid.geometry import Box
from sphsolid.record import march, restore, write_checkpoint
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
