"""Recovered fields: exact polynomials, order of a rough field, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.compiled import set_threads, threads
from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, Box, TetBox
from sphsolid.geometry.integrals import cell_volumes_and_centroids, vertex_volumes
from sphsolid.record import PointField, Recovery


def points(body, spacing):
    mesh = body.mesh(spacing)
    return mesh.vertices, vertex_volumes(mesh)


def quadratic(X):
    x, y, z = X.T
    parts = [1 + x, y * z, x * x - y, z, x * y, 2.0 + 0 * x, z * z, x - z, x * z + y * y]
    return np.stack(parts, axis=1).reshape(-1, 3, 3)


@pytest.mark.parametrize("body", [Box(jitter=0.4), TetBox(), Box()])
def test_polynomials_are_recovered_exactly(body):
    X, V = points(body, 0.2)
    found = Recovery()(PointField(X, V, quadratic(X)), spacing=0.2)
    np.testing.assert_allclose(found.values, quadratic(X), atol=1e-11)
    line = 1.0 + X @ [1.0, -2.0, 3.0]
    found = Recovery(radius=2.5, degree=1)(PointField(X, V, line), spacing=0.2)
    np.testing.assert_allclose(found.values, line, atol=1e-12)


def test_a_rough_error_is_taken_off_a_smooth_field():
    X, V = points(Box(jitter=0.4), 0.1)
    smooth = np.sin(2.0 * X[:, 0]) * np.cos(X[:, 1])
    rough = 0.1 * np.random.default_rng(0).normal(size=len(X))
    found = Recovery()(PointField(X, V, smooth + rough), spacing=0.1)
    left = found.values - smooth
    assert np.sqrt(np.sum(V * left**2)) < 0.5 * np.sqrt(np.sum(V * rough**2))


def test_a_smooth_field_keeps_its_order():
    errors = []
    for n in (8, 16):
        X, V = points(Box(jitter=0.4), 1.0 / n)
        smooth = np.sin(2.0 * X[:, 0]) * np.cos(2.0 * X[:, 1])
        found = Recovery()(PointField(X, V, smooth), spacing=1.0 / n)
        errors.append(np.sqrt(np.sum(V * (found.values - smooth) ** 2)))
    assert np.log2(errors[0] / errors[1]) > 2.8


def test_the_same_bits_at_any_number_of_threads():
    X, V = points(Box(jitter=0.4), 0.2)
    field = PointField(X, V, quadratic(X))
    before = threads()
    try:
        set_threads(1)
        one = Recovery()(field, spacing=0.2).values
        set_threads(2)
        two = Recovery()(field, spacing=0.2).values
    finally:
        set_threads(before)
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("options", [{"degree": 3}, {"radius": 1.0}, {"radius": np.nan}])
def test_bad_options_are_refused(options):
    with pytest.raises(InputError, match=r"2 and 3\.5 are the defaults"):
        Recovery(**options)


def test_patches_that_determine_nothing_are_refused():
    X, V = points(Box(upper=(1.0, 1.0, 0.1)), 0.1)
    with pytest.raises(InputError, match="raise radius, or use degree = 1"):
        Recovery()(PointField(X, V, X[:, 0]), spacing=0.1)  # two layers have no curvature
    with pytest.raises(InputError, match="too few points"):
        Recovery(radius=1.1, degree=2)(PointField(X, V, X[:, 0]), spacing=0.1)
    with pytest.raises(InputError, match="must be positive"):
        Recovery()(PointField(X, V, X[:, 0]), spacing=0.0)
    with pytest.raises(InputError, match="not finite"):
        Recovery()(PointField(X, V, np.full(len(X), np.nan)), spacing=0.1)


@pytest.mark.parametrize("at", ["particles", "cells"])
def test_a_patch_takes_nothing_from_across_a_slot(at):
    """One field on each prong of a fork: recovered as they are, where the mesh is given."""
    prongs = (((1, 0, 0), (4, 2, 1.5)), ((1, 0, 2), (4, 2, 3.5)))
    mesh = Blocks((((0, 0, 0), (1, 2, 3.5)), *prongs)).mesh(0.5)
    X, V = mesh.vertices, vertex_volumes(mesh)
    if at == "cells":
        V, X = cell_volumes_and_centroids(mesh)
    up = X[:, 2] > 1.75
    values = np.where(up, 1.0, -1.0)
    far = X[:, 0] > 3.0
    recovery = Recovery(radius=2.6, degree=1)
    blind = recovery(PointField(X, V, values), spacing=0.5).values
    found = recovery(PointField(X, V, values), spacing=0.5, mesh=mesh).values
    assert np.abs(blind - values)[far].max() > 0.02
    np.testing.assert_allclose(found[far], values[far], atol=1e-12)
