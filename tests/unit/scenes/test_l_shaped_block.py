"""The L-shaped block: geometry, loads that balance, and the impulse they give."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.geometry.integrals import area_vectors, vertex_volumes
from sphsolid.record import AngularMomentum, LinearMomentum
from sphsolid.scenes import l_shaped_block
from sphsolid.scenes.l_shaped_block import PUBLISHED_SPACING, load_history

#: Outward areas of the eight faces of the block [m^2].
FACES = {
    "X-": (-30.0, 0, 0), "X+": (9.0, 0, 0), "X+@3": (21.0, 0, 0),
    "Y-": (0, -18.0, 0), "Y+": (0, 9.0, 0), "Y+@3": (0, 9.0, 0),
    "Z-": (0, 0, -39.0), "Z+": (0, 0, 39.0),
}  # fmt: skip


@pytest.mark.parametrize("jitter", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("spacing", [PUBLISHED_SPACING, 0.5])
def test_volume_mass_and_faces(jitter, spacing):
    scene = l_shaped_block(jitter=jitter, seed=3)
    mesh = scene.body.mesh(spacing)
    assert scene.body.volume == 117.0
    assert scene.material.density * vertex_volumes(mesh).sum() == pytest.approx(1.17e5, rel=1e-13)
    assert set(mesh.faces) == set(FACES)
    for name, expected in FACES.items():
        area = area_vectors(mesh, mesh.face(name)).sum(axis=0)
        np.testing.assert_allclose(area, expected, atol=1e-12, err_msg=name)


def test_published_resolution():
    """388 particles are published; a mesh of hexahedra can come as close as 425."""
    numbers = {
        spacing: len(l_shaped_block().body.mesh(spacing).vertices)
        for spacing in (0.95, 0.86, PUBLISHED_SPACING, 0.8, 0.7, 0.5)
    }
    assert numbers == {0.95: 224, 0.86: 240, 0.85: 425, 0.8: 450, 0.7: 475, 0.5: 1323}
    assert min(numbers, key=lambda s: abs(numbers[s] - 388)) == PUBLISHED_SPACING


def test_load_history():
    times = [-1.0, 0.0, 1.0, 2.5, 4.0, 5.0, 7.0]
    assert [load_history(t) for t in times] == [0.0, 0.0, 1.0, 2.5, 1.0, 0.0, 0.0]


@pytest.mark.parametrize("factor", [1.0, 0.1, -2.0])
def test_tractions_are_opposite_and_their_impulse_is_the_estimate(factor):
    scene = l_shaped_block(load_factor=factor)
    mesh = scene.body.mesh(PUBLISHED_SPACING)
    X = mesh.vertices
    force, moment = np.zeros(3), np.zeros(3)
    for traction in scene.tractions:
        area = np.linalg.norm(area_vectors(mesh, mesh.face(traction.face)), axis=1)
        load = area[:, None] * traction.value(X, np.zeros_like(X), 1.5)
        force += load.sum(axis=0)
        moment += np.cross(X, load).sum(axis=0)
    np.testing.assert_allclose(force, 0.0, atol=1e-9)
    # eta is 1.5 s now and 6.25 s^2 in all; the arm between the faces' centres is (4.5, -8.5, 0) m.
    impulse = moment / 1.5 * 6.25
    np.testing.assert_allclose(impulse / factor, [-2.15e5, -1.14e5, 1.48e5], rtol=3e-3)
    exact = np.cross([4.5, -8.5, 0.0], 9.0 * 6.25 * np.array([150.0, 300.0, 450.0]))
    np.testing.assert_allclose(impulse / factor, exact, rtol=1e-12)


def test_both_solvers_start_it_with_that_moment_and_no_net_force():
    """After 0.1 s the body has hardly moved: L is the undeformed moment times 0.005 s^2."""
    scene = l_shaped_block()
    exact = 0.005 * np.cross([4.5, -8.5, 0.0], 9.0 * np.array([150.0, 300.0, 450.0]))
    for sim in (
        sph.Simulation(scene, spacing=PUBLISHED_SPACING),
        fem.Simulation(scene, spacing=PUBLISHED_SPACING),
    ):
        history = sim.run(until=0.1, record=[AngularMomentum(), LinearMomentum()])
        last = history.table.iloc[-1]
        L = [last[f"angular_momentum_{k} [kg m^2/s]"] for k in "xyz"]
        p = [last[f"linear_momentum_{k} [kg m/s]"] for k in "xyz"]
        np.testing.assert_allclose(L, exact, rtol=2e-3)
        np.testing.assert_allclose(p, 0.0, atol=1e-12 * last["linear_momentum_scale [kg m/s]"])


def test_it_is_a_free_body_with_probes_at_its_corners():
    scene = l_shaped_block()
    assert scene.constraints == ()
    assert scene.end_time == 20.0
    mesh = scene.body.mesh(PUBLISHED_SPACING)
    for point in scene.probes.values():
        distance = np.linalg.norm(mesh.vertices - np.array(point), axis=1)
        assert distance.min() == 0.0


@pytest.mark.parametrize("factor", [math.nan, math.inf])
def test_a_load_that_is_not_finite_is_refused(factor):
    with pytest.raises(InputError, match="load_factor"):
        l_shaped_block(load_factor=factor)
