"""Probes are on the body, or nearly."""

from __future__ import annotations

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, Box
from sphsolid.record.probes import check_probes
from sphsolid.scenes.scene import Scene

RUBBER = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)
CORNER = Blocks((((0, 0, 0), (1, 2, 1)), ((1, 0, 0), (2, 1, 1))))


def scene(place, body=None):
    return Scene(
        name="s", body=Box() if body is None else body, material=RUBBER, end_time=1.0,
        probes={"tip": place},
    )  # fmt: skip


def check(place, spacing=0.25, body=None):
    problem = scene(place, body)
    check_probes(problem, problem.body.mesh(spacing))


@pytest.mark.parametrize(
    ("place", "named"),
    [
        ((500.0, 500.0, 500.0), r"'tip' at X = \[500.0.* is 864.3 m .*fit as millimetres"),
        ((100.0, 50.0, 100.0), "fit as centimetres"),
        ((0.5, 0.5, 1.26), "0.26 m from the body, more than a spacing .0.25 m.*undeformed body"),
        ((-0.2, -0.2, -0.2), "is 0.3464 m from the body"),
    ],
)
def test_a_probe_far_from_the_body_is_refused(place, named):
    with pytest.raises(InputError, match=named):
        check(place)


def test_a_body_in_other_units_than_its_probe():
    with pytest.raises(InputError, match="if the body were in millimetres"):
        check((0.3, 0.3, 0.9), 50.0, Box((0, 0, 100.0), (1000.0, 1000.0, 2000.0)))


def test_the_hollow_of_a_body_is_not_the_body():
    check((1.2, 1.2, 0.5), 0.25, CORNER)
    with pytest.raises(InputError, match=r"0\.5 m from the body"):
        check((1.5, 1.5, 0.5), 0.25, CORNER)


@pytest.mark.parametrize("place", [(0.5, 0.5, 0.5), (0.13, 0.9, 0.4), (0.5, 0.5, 1.25)])
@pytest.mark.parametrize("spacing", [0.1, 0.25, 1.0])
def test_within_the_body_or_a_spacing_of_it_any_place_is_fine(place, spacing):
    check(np.minimum(place, 1.0 + spacing), spacing)


def test_long_cells_do_not_shorten_the_spacing():
    check((0.5, 0.5, 1.3), 0.25, Box(aspect=(1.0, 1.0, 2.0)))


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_both_solvers_refuse_before_anything_is_built(solver):
    with pytest.raises(InputError, match="probe 'tip'"):
        solver(scene((0.0, 0.0, -3.0)), spacing=0.5)
