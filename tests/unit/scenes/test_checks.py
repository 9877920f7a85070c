"""What is no part of a problem is refused in one sentence."""

from __future__ import annotations

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.geometry import Box
from sphsolid.scenes import twisting_column
from sphsolid.scenes.constraint import Constraint, Fixed
from sphsolid.scenes.scene import NoBodyForce, Scene, Traction

RUBBER = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)
CLAMP = Constraint("Z-", "all")


def made(**parts):
    return Scene(**{"name": "s", "body": Box(), "material": RUBBER, "end_time": 1.0, **parts})


def pull(X, N, t):
    return N


@pytest.mark.parametrize(
    ("parts", "named"),
    [
        ({"constraints": CLAMP}, r"constraints is a lone Constraint; .*\(Constraint\(\.\.\.\),\)"),
        ({"tractions": Traction("Z+", pull)}, "tractions is a lone Traction; put it into a tuple"),
        ({"constraints": "Z-"}, "'Z-' is not a tuple of Constraint"),
        ({"constraints": None}, "None is not a tuple"),
        ({"constraints": (CLAMP, "Z+")}, "holds 'Z.', which is no Constraint"),
        ({"tractions": (CLAMP,)}, "which is no Traction"),
        ({"body": "cube.msh"}, r"'cube.msh' is no body; use .*MeshFile\(path\)"),
        ({"body": Box}, "is no body"),
        ({"material": 1e6}, "float is no registered constitutive law"),
        ({"material": sph.NeoHookean}, "is a class, not a set of parameters"),
        ({"material": None}, "NoneType is no registered constitutive law"),
        ({"end_time": "0.1"}, r"end_time = '0.1' is not a number; give it in s"),
        ({"end_time": True}, "not a number"),
        ({"exact": None}, r"exact = None is no exact solution; .*NoExactSolution\(\)"),
        ({"exact": 1.0}, "exact = 1.0 is no exact solution"),
        ({"provenance": None}, "provenance = None is not a string"),
        ({"provenance": 2}, "provenance = 2 is not a string"),
        ({"end_time": 10**400}, "finite"),
        ({"end_time": np.nan}, "finite"),
        ({"end_time": -1.0}, "positive"),
        ({"initial_velocity": (0.0, 0.0, 1.0)}, r"\(0.0, 0.0, 1.0\) is not a function; .*lambda X"),
        ({"initial_displacement": np.zeros(3)}, "is not a function"),
        ({"initial_deformation_gradient": np.eye(3)}, "is not a function"),
        ({"body_force": -9.81}, r"-9.81 is not a function; .*lambda X, t"),
        ({"body_force": NoBodyForce}, "NoBodyForce is a class; make an object of it"),
        ({"probes": [(0.0, 0.0, 0.0)]}, "is not a dict of points"),
        ({"probes": {"tip": (0.0, 0.0)}}, r"probe 'tip' at \(0.0, 0.0\); wanted are"),
        ({"probes": {"tip": (0.0, 0.0, "one")}}, "probe 'tip'"),
        ({"probes": {"tip": (0.0, 0.0, np.nan)}}, "three finite"),
        ({"name": 3}, "is a string"),
    ],
)
def test_a_scene_refuses_what_is_no_part_of_it(parts, named):
    with pytest.raises(InputError, match=named):
        made(**parts)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"formulation": sph.PF}, r"formulation = PF is a class; write PF\(\)"),
        ({"stabilisation": sph.NoStabilisation}, r"write NoStabilisation\(\)"),
        ({"operator": sph.Literal}, "operator = Literal is a class"),
        ({"smoothing": sph.WendlandC2}, "smoothing = WendlandC2 is a class"),
        ({"integrator": "rk2"}, "integrator = 'rk2' cannot be used: it has no name, stages"),
        ({"stabilisation": "none"}, "stabilisation = 'none' cannot be used: it has no name"),
        ({"h_over_dx": "0.77"}, "h_over_dx = '0.77' is not a number"),
    ],
)
def test_an_option_that_is_no_object_is_named(options, named):
    with pytest.raises(InputError, match=named):
        sph.Simulation(twisting_column(), spacing=0.5, **options)


def test_lists_are_tuples_and_places_are_copied():
    places = {"tip": np.array([0, 0, 1])}
    scene = made(constraints=[CLAMP], tractions=[Traction("Z+", pull)], probes=places)
    assert scene.constraints == (CLAMP,)
    assert isinstance(scene.tractions, tuple)
    places["tip"][:] = 7
    assert scene.probes == {"tip": (0.0, 0.0, 1.0)}


def test_conditions_refuse_what_is_no_function():
    with pytest.raises(InputError, match=r"'Z\+': velocity = \(0, 0, 1\) is not a function"):
        Constraint("Z+", "all", (0, 0, 1))
    with pytest.raises(InputError, match="Fixed is a class"):
        Constraint("Z+", "all", Fixed)
    with pytest.raises(InputError, match=r"value = -10000\.0 is not a function"):
        Traction("Z+", -1e4)
    with pytest.raises(InputError, match="is not the name of a boundary tag"):
        Traction(pull, "Z+")


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
@pytest.mark.parametrize(
    ("scene", "options", "named"),
    [
        (twisting_column, {"spacing": 0.5}, r"is not a Scene; call it: twisting_column\(\.\.\.\)"),
        ("twisting_column", {"spacing": 0.5}, "'twisting_column' is not a Scene"),
        (twisting_column(), {"spacing": "0.5"}, "spacing = '0.5' is not a number"),
        (twisting_column(), {"spacing": 0.5, "cfl": "fast"}, "cfl = 'fast'"),
    ],
)
def test_a_simulation_refuses_what_is_no_scene_or_number(solver, scene, options, named):
    with pytest.raises(InputError, match=named):
        solver(scene, **options)


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_a_truth_value_is_no_cfl_number(solver):
    with pytest.raises(InputError, match="cfl = True"):
        solver(made(), spacing=0.5, cfl=True)


@pytest.mark.parametrize("wrong", [None, twisting_column, Box(), "column"])
def test_only_a_scene_gets_a_recommendation(wrong):
    with pytest.raises(InputError, match="is not a Scene"):
        sph.recommend(wrong)
