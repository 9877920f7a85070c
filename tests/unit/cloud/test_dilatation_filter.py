"""Filters keep constants, are symmetric in the volumes and turn no wave round."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import build_cloud
from sphsolid.cloud.dilatation_filter import dilatation_filter
from sphsolid.cloud.lattice.closures import difference
from sphsolid.cloud.lattice.line_filter import LineFilter
from sphsolid.cloud.linear_pair_filter import LinearPairFilter
from sphsolid.cloud.pair_filter import PairFilter
from sphsolid.compiled import set_threads, threads
from sphsolid.geometry import Blocks, Box, TetBox

UPPER = (1.0, 0.8, 1.2)
BODIES = {
    "lattice": (Box(upper=UPPER), 0.2, 0.77, LineFilter),
    "thin lattice": (Box(upper=(1.0, 0.2, 0.4)), 0.2, 0.77, LineFilter),
    "jitter 0.4": (Box(upper=UPPER, jitter=0.4, seed=2), 0.2, 0.9, PairFilter),
    "L-block": (
        Blocks((((0.0, 0.0, 0.0), (1.0, 0.5, 0.5)), ((0.0, 0.0, 0.0), (0.5, 1.0, 0.5)))),
        0.125, 0.77, PairFilter,
    ),
    "tetrahedra": (TetBox(upper=UPPER), 0.25, 1.1, PairFilter),
}  # fmt: skip
OPTIONS = [(1, 1.6), (2, 1.6), (1, 2.2), (2, 2.0)]


@cache
def cloud_of(name):
    body, spacing, h_over_dx, _ = BODIES[name]
    return build_cloud(
        body.mesh(spacing), smoothing=sph.WendlandC2(), h_over_dx=h_over_dx,
        operator=sph.Literal(),
    )  # fmt: skip


def matrix(filtering, size):
    """``S`` column by column."""
    S, out, work = np.empty((size, size)), np.empty(size), np.empty(size)
    for b, unit in enumerate(np.eye(size)):
        filtering.apply(unit, work, out)
        S[:, b] = out
    return S


@pytest.mark.parametrize(("order", "width"), OPTIONS)
@pytest.mark.parametrize("name", BODIES)
def test_constants_symmetry_and_spectrum(name, order, width):
    cloud = cloud_of(name)
    filtering = dilatation_filter(cloud, order=order, width=width)
    kind = BODIES[name][3]
    assert isinstance(filtering, LinearPairFilter if (kind, order) == (PairFilter, 2) else kind)
    S = matrix(filtering, cloud.size)
    np.testing.assert_allclose(S.sum(axis=1), 1.0, rtol=0.0, atol=1e-14)
    VS = cloud.V[:, None] * S
    assert np.abs(VS - VS.T).max() < 2e-15 * VS.max()
    assert np.abs(S - np.eye(cloud.size)).max() > 0.1
    root = np.sqrt(cloud.V)
    waves = np.linalg.eigvalsh(root[:, None] * S / root)
    assert waves[-1] < 1.0 + 1e-13
    # A cone is not quite positive as a kernel.
    assert waves[0] > (-0.15 if isinstance(filtering, PairFilter) else -0.01)
    # A constant to the last bit, so that a body at rest stays at rest.
    constant, out = np.full(cloud.size, 1.0 / 3.0), np.empty(cloud.size)
    filtering.apply(constant, np.empty(cloud.size), out)
    assert out.tobytes() == constant.tobytes()


@pytest.mark.parametrize("name", BODIES)
def test_order_two_keeps_linear_functions_at_the_boundary_too(name):
    cloud = cloud_of(name)
    filtering = dilatation_filter(cloud, order=2, width=1.6)
    for axis in range(3):
        f, out = cloud.X[:, axis].copy(), np.empty(cloud.size)
        filtering.apply(f, np.empty(cloud.size), out)
        np.testing.assert_allclose(out, f, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("accuracy", [2, 4, 6])
def test_lines_use_the_norm_of_each_axis_whatever_the_numbering(accuracy, order):
    """Against whole matrices, with the norms of the lattice's own differences."""
    mesh = Box(upper=(1.1, 0.6, 1.3)).mesh(0.1)
    shuffle = np.random.default_rng(1).permutation(len(mesh.vertices))
    place = np.argsort(shuffle)
    faces = {name: place[face] for name, face in mesh.faces.items()}
    mesh = replace(
        mesh, vertices=mesh.vertices[shuffle], cells=place[mesh.cells], faces=faces
    )
    cloud = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=0.77, operator=sph.Literal()
    )
    counts = (12, 7, 14)
    norms = [np.array(difference(accuracy, n).arrays()[0]) for n in counts]
    V = 1.0e-3 * norms[0][:, None, None] * norms[1][:, None] * norms[2]
    cloud = replace(cloud, V=V.ravel()[shuffle])
    filtering = dilatation_filter(cloud, order=order, width=1.6)
    assert isinstance(filtering, LineFilter)
    f = np.random.default_rng(0).normal(size=counts)
    expected = f
    for axis, (n, h) in enumerate(zip(counts, norms, strict=True)):
        S = np.eye(n)
        blocks = [(0, 4), (4, n - 4), (n - 4, n)] if order == 2 and n >= 8 else []
        q = 3 if blocks else order
        for first, last in blocks or [(0, n)]:
            part = slice(first, last)
            if last - first <= q:
                continue
            if blocks and (first == 0 or last == n):
                # The quadratic function that is nearest in the norm.
                P = np.vander(np.arange(4.0), 3)
                S[part, part] = P @ np.linalg.solve(P.T @ (h[part, None] * P), P.T * h[part])
                continue
            D = np.diff(np.eye(last - first), n=q, axis=0)
            S[part, part] -= 0.25**q * (D.T @ D) / h[part, None]
        expected = np.moveaxis(np.tensordot(S, expected, (1, axis)), 0, axis)
    out = np.empty(cloud.size)
    filtering.apply(f.ravel()[shuffle], np.empty(cloud.size), out)
    np.testing.assert_allclose(out, expected.ravel()[shuffle], rtol=0.0, atol=1e-13)


def test_volumes_that_are_no_product_are_filtered_over_pairs():
    cloud = cloud_of("lattice")
    V = cloud.V * np.random.default_rng(0).uniform(0.9, 1.1, cloud.size)
    filtering = dilatation_filter(replace(cloud, V=V), order=1, width=1.6)
    assert isinstance(filtering, PairFilter)


@pytest.mark.parametrize("kind", [PairFilter, LinearPairFilter])
def test_nobody_is_filtered_with_those_behind_a_corner(kind):
    """Two arms of a U, closer than the reach: there is no material between them."""
    arms = (((0.0, 0.0, 0.0), (1.0, 0.2, 0.2)), ((0.0, 0.3, 0.0), (1.0, 0.5, 0.2)))
    body = Blocks((*arms, ((0.0, 0.0, 0.0), (0.2, 0.5, 0.2))))
    cloud = build_cloud(
        body.mesh(0.1), smoothing=sph.WendlandC2(), h_over_dx=0.9, operator=sph.Literal()
    )
    S = matrix(kind(cloud, width=1.6), cloud.size)
    X = cloud.X
    lower = (X[:, 0] > 0.45) & (X[:, 1] < 0.25)
    upper = (X[:, 0] > 0.45) & (X[:, 1] > 0.25)
    assert lower.sum() == upper.sum() > 0
    np.testing.assert_array_equal(S[np.ix_(lower, upper)], 0.0)


@pytest.mark.parametrize("name", ["lattice", "jitter 0.4"])
def test_the_same_bits_however_many_share_the_work(name):
    cloud, found, before = cloud_of(name), [], threads()
    filtering = dilatation_filter(cloud, order=1, width=1.6)
    f = np.random.default_rng(0).normal(size=cloud.size)
    try:
        for count in (1, 2):
            set_threads(min(count, before))
            out = np.empty(cloud.size)
            filtering.apply(f, np.empty(cloud.size), out)
            found.append(out.tobytes())
    finally:
        set_threads(before)
    assert found[0] == found[1]
