"""A stated initial F is checked, also where a method does not use it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.geometry import Box
from sphsolid.scenes import swinging_cube
from sphsolid.scenes.scene import Scene
from sphsolid.scenes.stated_deformation import NOT_USED, refuse_contradiction

RUBBER = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)
X = Box().mesh(0.25).vertices


def stating(F, **parts):
    return Scene("s", Box(), RUBBER, 0.01, initial_deformation_gradient=F, **parts)


def everywhere(F):
    return lambda X: np.tile(np.asarray(F, dtype=float), (len(X), 1, 1))


WRONG = [
    (everywhere(np.full((3, 3), np.nan)), "initial_deformation_gradient is not finite"),
    (lambda X: 7, "initial_deformation_gradient returned int"),
    (lambda: 0, "initial_deformation_gradient raised TypeError"),
    (everywhere(np.diag([1.0, 1.0, -1.0])), "inside out at .* det F > 0"),
    (everywhere(2.0 * np.eye(3)), "contradicts initial_displacement at"),
]


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
@pytest.mark.parametrize(("F", "named"), WRONG)
def test_a_wrong_one_is_refused_by_both_solvers(solver, F, named):
    with pytest.raises(InputError, match=named):
        solver(stating(F), spacing=0.5)


def test_who_asks_for_the_geometry_gets_it():
    sim = sph.Simulation(stating(WRONG[-1][0]), spacing=0.5, formulation=sph.PF(),
                         initial_strain=sph.Compatible())  # fmt: skip
    assert NOT_USED in sim.plan()
    np.testing.assert_allclose(sim.state.F[0], np.eye(3), atol=1e-12)


def test_who_asks_for_the_stated_one_gets_it():
    sim = sph.Simulation(stating(WRONG[-1][0]), spacing=0.5, formulation=sph.PF(),
                         initial_strain=sph.Given())  # fmt: skip
    assert NOT_USED not in sim.plan()
    np.testing.assert_array_equal(sim.state.F[0], 2.0 * np.eye(3))


def test_the_plan_says_that_it_is_not_used():
    assert NOT_USED in fem.Simulation(swinging_cube(), spacing=0.5).plan()
    silent = Scene("s", Box(), RUBBER, 0.01)
    assert NOT_USED not in fem.Simulation(silent, spacing=0.5).plan()


@pytest.mark.parametrize("amplitude", [1e-6, 0.01, 0.05, 0.15])
def test_the_exact_one_passes(amplitude):
    refuse_contradiction(swinging_cube(amplitude=amplitude), X)


def test_a_gradient_of_a_kink_passes_and_half_of_it_does_not():
    def bent(X):
        return np.maximum(X[:, :1] - 0.5, 0.0) * [0.2, 0.0, 0.0]

    def of_bent(share):
        def F(X):
            made = np.tile(np.eye(3), (len(X), 1, 1))
            made[:, 0, 0] += share * 0.2 * (X[:, 0] > 0.5)
            return made

        return F

    refuse_contradiction(stating(of_bent(1.0), initial_displacement=bent), X)
    with pytest.raises(InputError, match=r"by 0\.1 at"):
        refuse_contradiction(stating(of_bent(0.5), initial_displacement=bent), X)


def test_the_transpose_is_not_the_gradient():
    F = np.array([[1.0, 0.3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    sheared = stating(everywhere(F), initial_displacement=lambda X: X @ (F - np.eye(3)).T)
    refuse_contradiction(sheared, X)
    with pytest.raises(InputError, match="contradicts"):
        refuse_contradiction(
            dataclasses.replace(sheared, initial_deformation_gradient=everywhere(F.T)), X
        )


def test_a_displacement_without_values_outside_the_body_is_not_compared():
    def inside_only(X):
        return np.where((X < 0.0) | (X > 1.0), np.nan, 0.0)

    refuse_contradiction(stating(everywhere(2.0 * np.eye(3)), initial_displacement=inside_only), X)
