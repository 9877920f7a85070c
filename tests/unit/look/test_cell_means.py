"""Fields of both solvers at the same places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.look.cell_means import cell_means_at_vertices, in_cells
from sphsolid.scenes import twisting_column

SCENE = twisting_column()
SOLVERS = {
    "particles": sph.Simulation(SCENE, spacing=0.25, stabilisation=sph.NoStabilisation()),
    "elements": fem.Simulation(SCENE, spacing=0.25),
}


def with_pressure(kind, field):
    shot = SOLVERS[kind].snapshot()
    return replace(shot, J=1.0 + field(shot.stress_X) / shot.material.kappa)


def linear(X):
    return 1e4 * (X @ [3.0, 2.0, -1.0])


def test_a_linear_pressure_is_the_same_of_both():
    cells = [in_cells(with_pressure(kind, linear), "pressure") for kind in SOLVERS]
    for found in cells:
        assert found.values == pytest.approx(linear(found.X), abs=1e-3)
        assert found.V.sum() == pytest.approx(6.0)
    assert np.abs(cells[0].X - cells[1].X).max() < 1e-12
    carried = [cell_means_at_vertices(with_pressure(kind, linear), "pressure") for kind in SOLVERS]
    assert carried[0] == pytest.approx(carried[1], abs=1e-3)
    # At the surface it is that of the adjacent cells' centres, of either solver: no further out.
    X = SOLVERS["elements"].snapshot().X
    corner = np.flatnonzero((X == [0.5, 6.0, -0.5]).all(axis=1))
    assert carried[0][corner] == pytest.approx(linear(np.array([[0.375, 5.875, -0.375]])))


def test_a_particle_more_than_a_cell_has_is_not_shown_as_more():
    """A steep pressure at the skin: at particles twice that of elements, over cells the same."""

    def skin(X):
        return 1e6 * np.maximum(np.abs(X[:, 0]) - 0.25, 0.0)

    particles, elements = (with_pressure(kind, skin) for kind in SOLVERS)
    assert particles.at_vertices("pressure").max() == pytest.approx(
        2.0 * elements.at_vertices("pressure").max()
    )
    assert cell_means_at_vertices(particles, "pressure") == pytest.approx(
        cell_means_at_vertices(elements, "pressure"), abs=1e-3
    )


def test_elements_are_shown_as_they_are():
    shot = with_pressure("elements", lambda X: 1e5 * np.sin(9.0 * X).sum(axis=1))
    assert in_cells(shot, "pressure").values.tolist() == shot.pressure.tolist()
    assert cell_means_at_vertices(shot, "J") == pytest.approx(shot.at_vertices("J"))


def test_a_field_at_other_points_is_refused():
    shot = SOLVERS["particles"].snapshot()
    odd = replace(shot, stress_X=shot.stress_X[1:], stress_V=shot.stress_V[1:], J=shot.J[1:],
        added_pressure=shot.added_pressure[1:],
    )
    with pytest.raises(InputError, match="neither"):
        in_cells(odd, "pressure")
