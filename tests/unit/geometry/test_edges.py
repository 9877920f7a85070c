"""The edges of the cells, once each, and the volume around them."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.geometry.edges import edges_of
from sphsolid.geometry.tet_box import TetBox
from sphsolid.scenes import Box


def test_edges_of_a_lattice():
    mesh = Box().mesh(0.25)
    edges = edges_of(mesh)
    assert len(edges.a) == 3 * 4 * 25
    assert np.all(edges.a < edges.b)
    length = np.linalg.norm(mesh.vertices[edges.b] - mesh.vertices[edges.a], axis=1)
    np.testing.assert_allclose(length, 0.25)
    assert edges.volume.sum() == pytest.approx(3.0)
    middle = np.all(np.abs(mesh.vertices[edges.a] - 0.5) < 0.2, axis=1)
    np.testing.assert_allclose(edges.volume[middle], 0.25**3)


def test_the_shares_of_tetrahedra_add_up_to_three_bodies():
    mesh = TetBox().mesh(0.3)
    assert edges_of(mesh).volume.sum() == pytest.approx(3.0)
