"""A problem statement is checked before any solver sees it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from sphsolid.continuum import NeoHookean
from sphsolid.errors import InputError
from sphsolid.scenes import Box, NoExactSolution, Scene, swinging_cube

SOFT = NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)


def scene(**changes) -> Scene:
    return Scene(**({"name": "test", "body": Box(), "material": SOFT, "end_time": 1.0} | changes))


def test_a_plain_scene_is_at_rest():
    X = np.random.default_rng(0).normal(size=(5, 3))
    u, v = scene().initial_state(X)
    np.testing.assert_array_equal(u, 0.0)
    np.testing.assert_array_equal(v, 0.0)


@pytest.mark.parametrize("which", ["initial_displacement", "initial_velocity"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_non_finite_initial_data_are_refused_with_their_place(which, value):
    def bad(X):
        field = np.zeros_like(X)
        field[3, 1] = value
        return field

    X = np.arange(15.0).reshape(5, 3)
    with pytest.raises(InputError, match=rf"{which}.*1 of 5 points.*9\.0, 10\.0, 11\.0"):
        scene(**{which: bad}).initial_state(X)


def test_initial_data_of_the_wrong_shape_are_refused():
    with pytest.raises(InputError, match="shape"):
        scene(initial_velocity=lambda X: X[:, :2]).initial_state(np.zeros((4, 3)))


def test_errors_need_an_exact_solution_and_constraints():
    with pytest.raises(InputError, match="no exact solution"):
        scene().known_solution()
    cube = swinging_cube()
    assert cube.known_solution() is cube.exact
    with pytest.raises(InputError, match="no constraints"):
        dataclasses.replace(cube, constraints=()).known_solution()
    with pytest.raises(InputError, match="no exact solution"):
        dataclasses.replace(cube, exact=NoExactSolution()).known_solution()


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"end_time": 0.0}, "end_time"),
        ({"end_time": np.nan}, "end_time"),
        ({"material": NeoHookean(mu=-1.0, kappa=1.0, density=1.0)}, "mu"),
        ({"material": NeoHookean(mu=1.0, kappa=np.inf, density=1.0)}, "kappa"),
        ({"material": NeoHookean(mu=1.0, kappa=1.0, density=0.0)}, "density"),
    ],
)
def test_bad_scenes_are_refused(changes, named):
    with pytest.raises(InputError, match=named):
        scene(**changes)
