"""A run goes on with the recorders it began with: what they are is compared, not what they saw."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.record import Energy, LinearMomentum, Probe, RunFolder, march, read_run
from sphsolid.record.recorder_words import recorder_words
from sphsolid.record.samples import Sampler
from sphsolid.scenes import swinging_cube


@dataclasses.dataclass
class Depth:
    z: Any

    def record(self, snapshot, scene):
        return {"mean_u [m]": float(np.mean(snapshot.displacement))}


class Ordinary:
    """No dataclass, with a memory."""

    def __init__(self, z):
        self.z = z
        self.seen = 0
        self.last = None

    def record(self, snapshot, scene):
        self.seen += 1
        self.last = snapshot.x
        return {"mean_u [m]": float(self.seen)}


class Quiet:
    """Shows something and has no column."""

    def __init__(self, size):
        self.size = size

    def record(self, snapshot, scene):
        return {}


def run(solver, folder, recorders, *, until=0.3, **options):
    return march(
        solver, until=until, every=0.1, record=recorders, output=RunFolder(folder, **options)
    )


LONG = np.zeros(2000)
OTHER = np.where(np.arange(2000) == 1000, 1.0, 0.0)
CHANGED = [
    ([Depth(0.0)], [Depth(2.0)], r"Depth\(z=0.0\).* not by Depth\(z=2.0\)"),
    ([Ordinary(0.0)], [Ordinary(2.0)], r"Ordinary\(z=0.0\).* not by Ordinary\(z=2.0\)"),
    ([Depth(LONG)], [Depth(OTHER)], "not by Depth"),
    ([Energy(), Depth([1, 2])], [Energy(), Depth([1, 3])], "not by Depth"),
    ([Depth(lambda x: x)], [Depth(lambda x: 2.0 * x)], "not by Depth"),
    ([Depth(0.0)], [Ordinary(0.0)], "not by Ordinary"),
]


@pytest.mark.parametrize("until", [0.3, 0.6])
@pytest.mark.parametrize(("there", "here", "named"), CHANGED)
def test_another_parameter_is_refused_by_name(fake_solver, tmp_path, there, here, named, until):
    run(fake_solver(), tmp_path, there)
    before = {f: f.read_bytes() for f in tmp_path.rglob("*") if f.is_file()}
    with pytest.raises(InputError, match=named):
        run(fake_solver(), tmp_path, here, until=until, resume=True)
    assert {f: f.read_bytes() for f in tmp_path.rglob("*") if f.is_file()} == before
    run(fake_solver(), tmp_path, here, until=until, replace=True)


@pytest.mark.parametrize(
    "make",
    [
        lambda: [Depth(1)], lambda: [Ordinary(np.float64(1))], lambda: [Depth(LONG.copy())],
        lambda: [Depth(Quiet(1))], lambda: [Depth(lambda x: x)],
        lambda: [Energy(), Probe("corner")],
    ],
)  # fmt: skip
def test_equal_ones_go_on(fake_solver, tmp_path, make):
    run(fake_solver(), tmp_path, make())
    for until in (0.6, 0.9):
        history = run(fake_solver(), tmp_path, make(), until=until, resume=True)
    assert len(history.table) == 10
    assert len(read_run(tmp_path)["recorded_by"]) == len(make())


def test_a_recorder_goes_on_with_its_memory(fake_solver, tmp_path):
    own = Ordinary(1.0)
    run(fake_solver(), tmp_path, [own])
    run(fake_solver(), tmp_path, [own], until=0.6, resume=True)


def test_one_without_columns_may_come_and_go(fake_solver, tmp_path):
    run(fake_solver(), tmp_path, [Depth(1.0)])
    run(fake_solver(), tmp_path, [Depth(1.0), Quiet(1)], until=0.6, resume=True)
    run(fake_solver(), tmp_path, [Depth(1.0)], until=0.9, resume=True)


def test_columns_added_or_left_out_have_their_own_sentence(fake_solver, tmp_path):
    run(fake_solver(), tmp_path, [Energy()])
    with pytest.raises(InputError, match="other columns than the history before"):
        run(fake_solver(), tmp_path, [Energy(), LinearMomentum()], until=0.6, resume=True)


def test_a_run_of_an_earlier_version_says_nothing_and_goes_on(fake_solver, tmp_path):
    run(fake_solver(), tmp_path, [Depth(0.0)])
    path = tmp_path / "run.json"
    path.write_text(path.read_text().replace("recorded_by", "something_else"))
    run(fake_solver(), tmp_path, [Depth(0.0)], until=0.6, resume=True)


def test_an_edited_recorder_has_other_words():
    made = []
    for factor in (1.0, 2.0):
        text = f"class Own:\n def record(self, snapshot, scene):\n  return {{'a': {factor}}}\n"
        held: dict[str, Any] = {"__name__": "own"}
        exec(text, held)
        made.append(recorder_words(held["Own"]()))
    assert made[0] != made[1]


def test_words_name_no_place_in_memory():
    for value in (Quiet(1), object(), functools.partial(max, 1), lambda x: x):
        assert " at 0x" not in recorder_words(Depth(value))


# ------------------------------------------------------------------ the exact solution
EXACT = swinging_cube().exact


@dataclasses.dataclass(frozen=True)
class Ex:
    """A motion of speed ``a``; errors are divided by ``scale``."""

    a: float
    scale: float = 1.0
    period: float = 1.0

    @property
    def momentum_scale(self):
        return self.scale

    @property
    def stress_scale(self):
        return 1.0e9

    def displacement(self, X, t):
        return self.a * t * X

    def velocity(self, X, t):
        return self.a * X

    def first_piola(self, X, t):
        return np.tile(self.a * t * np.eye(3), (len(X), 1, 1))


class Stress(Ex):
    def first_piola(self, X, t):
        return 2.0 * super().first_piola(X, t)


def solver_of(fake_solver, exact):
    scene = dataclasses.replace(swinging_cube(), exact=exact)
    solver = fake_solver(scene=scene)
    sampler = Sampler(scene, solver.placement().mesh)
    solver.samples = sampler.at
    return solver


@pytest.mark.parametrize(
    ("there", "here", "named"),
    [
        (Ex(1.0), Ex(5.0), "exact displacement differs: at t = .*exact velocity differs"),
        (Ex(1.0), Stress(1.0), "exact first piola differs"),
        (Ex(1.0), Ex(1.0, scale=1.01), "exact momentum scale differs"),
        (Ex(1.0), EXACT, "exact displacement differs"),
    ],
)
def test_another_exact_solution_is_refused_by_name(fake_solver, tmp_path, there, here, named):
    run(solver_of(fake_solver, there), tmp_path, [Energy()])
    run(solver_of(fake_solver, there), tmp_path, [Energy()], until=0.4, resume=True)
    with pytest.raises(InputError, match=named):
        run(solver_of(fake_solver, here), tmp_path, [Energy()], until=0.6, resume=True)


def test_an_exact_solution_without_stress_or_scales_is_none_of_the_runs_business(
    fake_solver, tmp_path
):
    class Bare:
        def displacement(self, X, t):
            raise ValueError("nobody knows")

    run(solver_of(fake_solver, Bare()), tmp_path, [Energy()])
    run(solver_of(fake_solver, Bare()), tmp_path, [Energy()], until=0.4, resume=True)
