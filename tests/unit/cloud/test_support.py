"""A support that is too small is refused, and the value that the message gives works."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import build_cloud, build_secondary, consistency_report
from sphsolid.errors import InputError
from sphsolid.geometry.mesh import HexMesh
from sphsolid.scenes import Box, swinging_cube

MESSAGE = re.compile(
    r"h_over_dx = (?P<asked>[\d.]+) is too small: \d+ of \d+ (?P<what>.+) particles .* particle "
    r"(?P<particle>\d+) at X = \[(?P<X>.*)\] m with (?P<seen>\d+); raise h_over_dx to at least "
    r"(?P<needed>[\d.]+)$"
)


def build(mesh: HexMesh, h_over_dx: float, operator: Any, smoothing: Any, points: Any) -> None:
    """A cloud and its secondary particles, judged by its consistency."""
    cloud = build_cloud(mesh, smoothing=smoothing, h_over_dx=h_over_dx, operator=operator)
    build_secondary(cloud, points)
    report = consistency_report(cloud, 1.0)
    assert report.C0 < 1e-10
    assert report.C1 < 1e-10


@pytest.mark.parametrize("smoothing", [sph.WendlandC2(), sph.QuinticSpline()])
@pytest.mark.parametrize("operator", [sph.Literal(), sph.Consistent()], ids=lambda o: o.name)
@pytest.mark.parametrize("jitter", [0.0, 0.2, 0.8])
@pytest.mark.parametrize("h_over_dx", [0.1, 0.3])
def test_the_suggested_value_works(
    h_over_dx: float, jitter: float, operator: Any, smoothing: Any
) -> None:
    mesh = Box(jitter=jitter, seed=7).mesh(0.2)
    options = (operator, smoothing, sph.H1())
    with pytest.raises(InputError) as caught:
        build(mesh, h_over_dx, *options)
    found = MESSAGE.match(str(caught.value))
    assert found is not None, str(caught.value)
    assert float(found["asked"]) == h_over_dx
    assert found["what"] == "primary"
    # The particle is where the message says, and has as many neighbours as it says.
    named = int(found["particle"])
    np.testing.assert_array_equal([float(c) for c in found["X"].split(",")], mesh.vertices[named])
    distance = np.linalg.norm(mesh.vertices - mesh.vertices[named], axis=1)
    radius = smoothing.support * h_over_dx * mesh.spacing
    assert int(found["seen"]) == np.count_nonzero(distance < radius)
    needed = float(found["needed"])
    build(mesh, needed, *options)
    with pytest.raises(InputError, match="too small"):
        build(mesh, 0.95 * needed, *options)


def test_secondary_particles_are_checked_too() -> None:
    """A support that serves the particles but not the cell centres, half a diagonal away."""
    mesh = Box().mesh(0.2)
    operator, smoothing = sph.Literal(), sph.WendlandC2()
    cloud = build_cloud(mesh, smoothing=smoothing, h_over_dx=0.51, operator=operator)
    lengths = sph.cloud.lengths.Uniform(mesh.spacing, 0.4)
    small = dataclasses.replace(cloud, lengths=lengths)
    with pytest.raises(InputError, match=r"secondary \(H1\) particle \d+ .* at least 0.45$"):
        build_secondary(small, sph.H1())


def test_flat_neighbourhoods_are_noticed() -> None:
    """Enough neighbours, but all in one plane: lengths count the long edges, so h is small here."""
    mesh = Box(upper=(1.0, 1.0, 2.0)).mesh(0.25)
    flat = HexMesh(mesh.vertices * [1.0, 1.0, 6.0], mesh.cells, mesh.faces, 0.25, False)
    with pytest.raises(InputError, match="too few neighbours"):
        build_cloud(flat, smoothing=sph.WendlandC2(), h_over_dx=0.4, operator=sph.Literal())


def test_a_cloud_without_thickness_is_refused_with_what_to_do() -> None:
    mesh = Box(upper=(1.0, 1.0, 0.1)).mesh(0.1)
    one_layer = mesh.vertices[mesh.vertices[:, 2] == 0.0]
    pairs = sph.cloud.pairs.neighbours.pairs_within(one_layer, one_layer, 0.15)
    with pytest.raises(InputError, match="at least two layers"):
        sph.cloud.support.check_support(
            one_layer, one_layer, pairs,
            h_over_dx=0.75, support=2.0, spacings=np.full(len(one_layer), 0.1),
            what="primary",
        )  # fmt: skip


@pytest.mark.parametrize("h_over_dx", [0.0, -0.75, np.nan, np.inf])
def test_a_value_that_is_no_length_is_refused(h_over_dx: float) -> None:
    with pytest.raises(InputError, match=r"h_over_dx = .* must be (positive|finite)"):
        sph.Simulation(swinging_cube(), spacing=0.25, h_over_dx=h_over_dx)
