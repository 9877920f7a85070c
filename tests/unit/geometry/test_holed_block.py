"""A block with a hole: cells of positive volume, closed outward faces, a refused hole."""

from __future__ import annotations

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.geometry import HoledBlock
from sphsolid.geometry.integrals import area_vectors, cell_volumes_and_centroids

BLOCK = HoledBlock(lower=(0.0, 0.0, 0.0), upper=(0.1, 0.06, 0.02), radius=0.012)


def area(mesh, *faces):
    return sum(area_vectors(mesh, mesh.face(face)) for face in faces).sum(axis=0)


def test_the_mesh_fills_the_block_but_the_hole():
    off = []
    for spacing in (0.01, 0.005, 0.0025):
        mesh = BLOCK.mesh(spacing)
        volumes, _ = cell_volumes_and_centroids(mesh)
        assert volumes.min() > 0.0
        off.append(volumes.sum() / BLOCK.volume - 1.0)
    # The hole is a polygon: what it leaves out falls with the square of the spacing.
    assert 0.0 < off[2] < 1e-4
    assert np.log2(off[0] / off[1]) > 1.7


def test_the_faces_are_outward_and_closed():
    mesh = BLOCK.mesh(0.008)
    assert set(mesh.faces) == {"X-", "X+", "Y-", "Y+", "Z-", "Z+", "hole"}
    np.testing.assert_allclose(area(mesh, "X+"), [0.06 * 0.02, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(area(mesh, "Y-"), [0.0, -0.1 * 0.02, 0.0], atol=1e-15)
    np.testing.assert_allclose(area(mesh, "hole"), 0.0, atol=1e-15)
    np.testing.assert_allclose(area(mesh, *mesh.faces), 0.0, atol=1e-15)
    on_hole = mesh.vertices[mesh.face_particles("hole"), :2] - [0.05, 0.03]
    np.testing.assert_allclose(np.linalg.norm(on_hole, axis=1), 0.012)
    # Facets of the hole look at its axis.
    corners = mesh.vertices[mesh.face("hole")]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert ((corners.mean(axis=1) - [0.05, 0.03, 0.01]) * normal)[:, :2].sum(axis=1).max() < 0.0


@pytest.mark.parametrize(
    "change", [{"radius": 0.0}, {"radius": 0.025}, {"radius": np.nan}, {"upper": (0.1, 0.06, 0.0)}]
)
def test_a_hole_that_does_not_fit_is_refused(change):
    given = {"lower": BLOCK.lower, "upper": BLOCK.upper, "radius": BLOCK.radius}
    with pytest.raises(sph.InputError):
        HoledBlock(**(given | change))


@pytest.mark.parametrize("spacing", [0.0, -0.01, np.inf])
def test_a_spacing_that_is_no_length_is_refused(spacing):
    with pytest.raises(sph.InputError, match="spacing"):
        BLOCK.mesh(spacing)
