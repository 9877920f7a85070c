"""The punch on clouds: bodies without a mesh are what they claim, and a short run of each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sphsolid.cloud.lengths import Uniform, lengths_of
from sphsolid.geometry.integrals import vertex_volumes
from studies.punch_cloud.bodies import HEXAHEDRA, WIDEST, body_of, length_of_points
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
    body, spacing = body_of(HEXAHEDRA, spacing=1 / 40, seed=1)
    points, as_meshed = body_of("points", spacing=1 / 40, seed=1)
    hexahedra = lengths_of(body.mesh(spacing), length_of_points(body, spacing))
    alone = lengths_of(points.mesh(as_meshed), 1.0)
    assert isinstance(hexahedra, Uniform)
    assert isinstance(alone, Uniform)
    assert hexahedra.spacing > 1.2 * alone.spacing
    assert hexahedra.h_over_dx * hexahedra.spacing == pytest.approx(alone.spacing, rel=1e-3)
