"""Interpolation to the secondary particles by the linear-corrected kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud import Cloud, build_secondary
from sphsolid.cloud.gradient import linear_interpolation, row_sum
from sphsolid.cloud.pairs.neighbours import pairs_within

Array = NDArray[np.float64]
MakeCloud = Callable[..., Cloud]


@pytest.mark.parametrize("points", [sph.H1(), sph.H6()], ids=lambda p: p.name)
@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_constants_and_linears_are_reproduced(
    make_cloud: MakeCloud, jitter: float, points: Any
) -> None:
    cloud = make_cloud(jitter=jitter)
    q = build_secondary(cloud, points)
    weight = q.sample[:, 3]
    np.testing.assert_allclose(row_sum(q.pairs, weight), 1.0, rtol=1e-12)
    moments = row_sum(q.pairs, weight[:, None] * cloud.X[q.pairs.indices])
    np.testing.assert_allclose(moments, q.X, atol=1e-12)


def test_it_is_exact_anywhere_in_the_body_up_to_its_corners(make_cloud: MakeCloud) -> None:
    cloud = make_cloud(jitter=0.4)
    random = np.random.default_rng(4)
    upper = np.array([1.0, 0.8, 1.2])
    points = np.concatenate([random.uniform(0.0, upper, (200, 3)), [upper, 0.0 * upper]])
    pairs = pairs_within(points, cloud.X, 2.0 * cloud.h)
    weight = linear_interpolation(points, cloud.X, cloud.V, pairs, cloud.smoothing, cloud.h)
    f = cloud.X[pairs.indices] @ [2.0, -1.0, 3.0] + 4.0
    np.testing.assert_allclose(
        row_sum(pairs, weight * f), points @ [2.0, -1.0, 3.0] + 4.0, atol=1e-11
    )


def shepard(points: Array, cloud: Cloud) -> tuple[Any, Array]:
    """Kernel interpolation corrected for constants alone."""
    pairs = pairs_within(points, cloud.X, 2.0 * cloud.h)
    d = cloud.X[pairs.indices] - points[pairs.row_of_pair]
    VW = cloud.V[pairs.indices] * cloud.smoothing.value(np.linalg.norm(d, axis=1), cloud.h)
    return pairs, VW / row_sum(pairs, VW)[pairs.row_of_pair]


def test_shepard_interpolation_would_fail_the_check_on_linears(make_cloud: MakeCloud) -> None:
    cloud = make_cloud(jitter=0.4)
    points, _ = sph.H1().place(cloud.mesh)
    pairs, weight = shepard(points, cloud)
    np.testing.assert_allclose(row_sum(pairs, weight), 1.0, rtol=1e-12)
    moments = row_sum(pairs, weight[:, None] * cloud.X[pairs.indices])
    assert np.max(np.abs(moments - points)) > 0.05 * cloud.spacing


def test_smooth_fields_are_interpolated_with_second_order(make_cloud: MakeCloud) -> None:
    def error(spacing: float) -> float:
        cloud = make_cloud(jitter=0.2, spacing=spacing)
        q = build_secondary(cloud, sph.H1())
        f = np.sin(2.0 * cloud.X @ [1.0, 1.0, 1.0])
        found = row_sum(q.pairs, q.sample[:, 3] * f[q.pairs.indices])
        return float(np.sqrt(np.sum(q.V * (found - np.sin(2.0 * q.X @ [1.0, 1.0, 1.0])) ** 2)))

    assert 1.85 < np.log2(error(0.2) / error(0.1)) < 2.15
