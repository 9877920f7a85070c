"""The swinging beam: sizes, weight, what is held, and the clamp on a cylinder."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid import SaintVenantKirchhoff
from sphsolid.errors import InputError
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.scenes import Box, OnCylinder, csm3, csm3_spacing


@pytest.mark.parametrize(("points", "layers"), [(5, 1), (9, 3)])
def test_statement(points, layers):
    scene = csm3(points=points, layers=layers)
    h = 0.02 / (points - 1)
    assert csm3_spacing(points) == pytest.approx(h)
    assert scene.body == Box((0.0, -0.01, 0.0), (0.35, 0.01, layers * csm3_spacing(points)))
    assert scene.material == SaintVenantKirchhoff.from_young(
        young_modulus=1.4e6, poisson_ratio=0.4, density=1000.0
    )
    held = {part.face: part.direction for part in scene.constraints}
    assert held == {"X-": "all", "Z-": "normal", "Z+": "normal"}
    assert scene.end_time > 0.46
    assert scene.is_driven
    mesh = scene.body.mesh(csm3_spacing(points))
    assert len(mesh.vertices) == (round(0.35 / h) + 1) * points * (layers + 1)
    tip = np.linalg.norm(mesh.vertices - np.array(scene.probes["tip"]), axis=1)
    assert tip.min() < 1e-12


def test_it_weighs_what_it_should():
    scene = csm3(gravity=3.0)
    mesh = scene.body.mesh(csm3_spacing(9))
    force = scene.body_force_at(mesh.vertices, 0.1)
    total = vertex_volumes(mesh) @ force
    np.testing.assert_allclose(total, [0.0, -3.0 * 1000.0 * 0.35 * 0.02 * 0.0025, 0.0], rtol=1e-12)


def test_the_end_lies_on_the_cylinder():
    scene = csm3(points=9, clamp=OnCylinder())
    mesh = scene.body.mesh(csm3_spacing(9))
    assert not mesh.is_lattice
    end = mesh.vertices[mesh.face_particles("X-")]
    np.testing.assert_allclose(np.hypot(end[:, 0] + 0.05, end[:, 1]), 0.05, rtol=1e-13)
    far = mesh.vertices[mesh.face_particles("X+")]
    np.testing.assert_allclose(far[:, 0], 0.35, rtol=1e-13)
    # Straight edges between points on the arc leave a share of the segment that falls as h^2.
    fine = scene.body.mesh(csm3_spacing(65))
    assert vertex_volumes(fine).sum() == pytest.approx(scene.body.volume, rel=1e-5)
    assert scene.body.volume > csm3(points=9).body.volume


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"points": 1}, "points"),
        ({"points": 4.0}, "points"),
        ({"layers": 0}, "layers"),
        ({"layers": True}, "layers"),
        ({"gravity": math.inf}, "gravity"),
        ({"clamp": "plane"}, "clamp"),
    ],
)
def test_bad_input_is_refused(given, word):
    with pytest.raises(InputError, match=word):
        csm3(**given)


@pytest.mark.parametrize("radius", [0.01, math.nan])
def test_a_cylinder_thinner_than_the_beam_is_refused(radius):
    with pytest.raises(InputError, match="radius"):
        OnCylinder(radius)


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_both_solvers_compile_its_law(solver):
    simulation = solver(csm3(points=3), spacing=csm3_spacing(3))
    simulation.run(until=2e-4)
    tip = simulation.snapshot().x[:, 1].min() + 0.01
    assert -1e-6 < tip < 0.0, "it begins to fall, by g t^2 / 2"
