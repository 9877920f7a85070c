"""How the strains start: by choice, by default, and where the choice makes no sense."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.scenes import FromGeometry, swinging_cube
from tests.oracles import numpy_sph
from tests.oracles.dense import dense

SCENE = swinging_cube(amplitude=0.05, jitter=0.2)
SILENT = dataclasses.replace(SCENE, initial_deformation_gradient=FromGeometry())
FORCE = sph.Consistent(use="force")


def started(**options: Any) -> sph.Simulation:
    scene = options.pop("scene", SCENE)
    return sph.Simulation(scene, spacing=0.25, **({"formulation": sph.PF()} | options))


def discrete(sim: sph.Simulation) -> np.ndarray:
    """``sum_b x_b (x) G_b(X_a)`` by dense sums."""
    G = dense(sim.cloud.pairs, sim.cloud.gradients.kinematic, sim.cloud.size)
    return numpy_sph.gradient(sim.state.x, G)


@pytest.mark.parametrize("operator", [sph.Consistent(), FORCE, sph.Literal()])
def test_compatible_is_the_gradient_of_the_particles(operator: Any) -> None:
    sim = started(operator=operator, initial_strain=sph.Compatible())
    np.testing.assert_allclose(sim.state.F, discrete(sim), atol=1e-13)


@pytest.mark.parametrize("operator", [sph.Consistent(), FORCE, sph.Literal()])
def test_given_is_what_the_scene_states(operator: Any) -> None:
    sim = started(operator=operator, initial_strain=sph.Given())
    exact = SCENE.exact.deformation_gradient(sim.cloud.X, 0.0)
    np.testing.assert_array_equal(sim.state.F, exact)
    assert np.max(np.abs(exact - discrete(sim))) > 1e-3  # the two starts differ


def test_the_other_strains_start_as_those_of_the_fibre_map() -> None:
    for strain in (sph.Given(), sph.Compatible()):
        s = started(formulation=sph.PFHJ(), initial_strain=strain).state
        np.testing.assert_allclose(s.H, numpy_sph.cof(s.F), atol=1e-14)
        np.testing.assert_allclose(s.J, np.linalg.det(s.F), rtol=1e-14)


@pytest.mark.parametrize(
    ("options", "chosen"),
    [
        ({}, sph.Equilibrated()),  # a disordered cloud: summation by parts
        ({"operator": sph.Consistent()}, sph.Compatible()),
        ({"operator": sph.Literal()}, sph.Compatible()),  # adjoint too, though not consistent
        ({"operator": FORCE}, sph.Given()),
        ({"operator": FORCE, "formulation": sph.PFHJ()}, sph.Given()),
        ({"operator": FORCE, "formulation": sph.PJ()}, sph.Compatible()),
        ({"operator": FORCE, "formulation": sph.Displacement()}, sph.Compatible()),
        ({"operator": FORCE, "scene": SILENT}, sph.Compatible()),
        ({"operator": FORCE, "initial_strain": sph.Compatible()}, sph.Compatible()),
    ],
)
def test_the_default_follows_the_operator(options: Any, chosen: Any) -> None:
    sim = started(**options)
    assert sim.initial_strain == chosen
    assert f"initial strain {type(chosen).__name__}" in sim.plan()


@pytest.mark.parametrize(
    "options",
    [
        {"scene": SILENT},
        {"formulation": sph.PJ()},
        {"formulation": sph.Displacement()},
    ],
)
def test_given_is_refused_where_nothing_is_given_or_nothing_can_hold_it(options: Any) -> None:
    with pytest.raises(InputError, match=r"Given\(\).*Compatible\(\)"):
        started(initial_strain=sph.Given(), **options)


def test_a_compatible_start_stores_no_energy_without_a_displacement() -> None:
    at_rest = dataclasses.replace(SCENE, initial_displacement=lambda X: np.zeros_like(X))
    compatible = started(scene=at_rest, initial_strain=sph.Compatible())
    assert abs(compatible.snapshot().strain_energy) < 1e-6
    stated = started(scene=at_rest, initial_strain=sph.Given()).snapshot().strain_energy
    assert stated > 1e3  # a stated strain without its displacement is stored energy


def everywhere(tensor: Any) -> Any:
    return lambda X: np.broadcast_to(np.asarray(tensor, dtype=float), (len(X), 3, 3))


@pytest.mark.parametrize(
    "change",
    [
        {"initial_deformation_gradient": everywhere(np.full((3, 3), np.nan))},
        {"initial_deformation_gradient": everywhere(np.diag([1.0, -1.0, 1.0]))},
        {"initial_deformation_gradient": lambda X: np.eye(3)},  # one for all, not one each
        {"initial_displacement": lambda X: -2.0 * X},
    ],
    ids=["nan", "inverted", "shape", "inverting displacement"],
)
def test_a_start_that_is_no_body_is_bad_input_not_a_lost_solution(change: Any) -> None:
    """Refused when built: advice on the step would send the user the wrong way."""
    scene = dataclasses.replace(SCENE, **change)
    with pytest.raises(InputError, match="initial"):
        started(scene=scene, operator=FORCE if "initial_displacement" not in change else None)
    with pytest.raises(InputError, match="initial"):
        started(scene=scene, initial_strain=sph.Equilibrated())
