"""The punch on clouds: bodies without a mesh are what they claim, and a short run of each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sphsolid.cloud.lengths import Uniform, lengths_of
from sphsolid.geometry.integrals import vertex_volumes
from studies.punch_cloud.bodies import HEXAHEDRA, WIDEST, body_of
from studies.punch_cloud.cases import DEFAULT, NONE, run_case

#: Sides of the block [m].
SIDES = np.array([1.0, 0.1, 0.5])


@pytest.mark.parametrize("cloud", ["lattice", HEXAHEDRA, WIDEST, "points", "filled"])
def test_every_body_is_the_block(cloud: str) -> None:
    body, spacing = body_of(cloud, spacing=0.05, seed=3)
    mesh = body.mesh(spacing)
    V = vertex_volumes(mesh)
    assert float(np.sum(V)) == pytest.approx(np.prod(SIDES), rel=1e-12)
    np.testing.assert_allclose(V @ mesh.vertices, np.prod(SIDES) * 0.5 * SIDES, rtol=1e-10)


@pytest.mark.parametrize("stabilisation", [DEFAULT, NONE])
def test_a_short_punch_without_a_mesh(tmp_path: Path, stabilisation: str) -> None:
    run, first, second = run_case(
        key="short", cloud="points", stabilisation=stabilisation, cells=10, seed=1, until=1e-3,
        shots=str(tmp_path),
    )  # fmt: skip
    assert run["survived"]
    assert run["steps"] > 2
    assert (run["secondary"] > 0) == (stabilisation == DEFAULT)
    assert run["noise"] == pytest.approx(np.mean([first["noise"], second["noise"]]))
    assert run["missed_momentum"] < 1e-12
    assert first["top_high"] >= second["top_low"]
    assert (tmp_path / "short.npz").exists()


def test_hexahedra_have_the_smoothing_length_of_the_points() -> None:
    """Cells of 25 x 33 x 25 mm; with the widest edge the comparison would be one of supports."""
    bodies = [body_of(cloud, spacing=1 / 40, seed=1) for cloud in (HEXAHEDRA, "points", WIDEST)]
    hexahedra, points, grid = (lengths_of(body.mesh(spacing), 1.0) for body, spacing in bodies)
    for lengths in (hexahedra, points, grid):
        assert isinstance(lengths, Uniform)
    assert hexahedra.spacing == pytest.approx(points.spacing, rel=1e-12)
    assert grid.spacing > 1.2 * points.spacing
