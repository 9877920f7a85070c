"""Delaunay cells of points on common spheres: one triangulation, whatever round-off says."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from sphsolid.errors import InputError
from sphsolid.geometry import Box, PointCloud, Surface
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.delaunay import circumspheres, delaunay, tetrahedron_volumes

Array = NDArray[np.float64]
LATTICE = np.stack(np.meshgrid(*3 * [np.arange(5.0)], indexing="ij"), axis=-1).reshape(-1, 3)
HEXAGONAL = LATTICE @ np.array([[1.0, 0.0, 0.0], [0.5, np.sqrt(0.75), 0.0], [0.0, 0.0, 1.6]])


def real(points: Array) -> NDArray[np.int64]:
    """Cells that are not flat, without their orientation."""
    cells = delaunay(points)
    return np.sort(cells[tetrahedron_volumes(points, cells) > 1e-9 * np.ptp(points) ** 3], axis=1)


@pytest.mark.parametrize("points", [LATTICE, HEXAGONAL], ids=["cubes", "hexagonal"])
def test_ties_are_broken_alike_in_every_unit_place_and_mirror(points: Array) -> None:
    cells = real(points)
    volume = np.abs(tetrahedron_volumes(points, cells))
    assert np.sum(volume) == pytest.approx(64.0 * np.linalg.det(points[[25, 5, 1]]), rel=1e-12)
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    for there in (1e-3 * points, 25.4 * points, 1e3 * points / 3.0, points + 1234.5,
                  points * [-1.0, 1.0, 1.0], points[:, [1, 2, 0]], points @ turn):  # fmt: skip
        np.testing.assert_array_equal(real(there), cells)


def test_spheres_are_empty() -> None:
    points = np.random.default_rng(0).random((200, 3))
    cells = delaunay(points)
    cells = cells[tetrahedron_volumes(points, cells) > 1e-9]
    centre, radius = circumspheres(points, cells)
    distance = np.linalg.norm(points - centre[:, None], axis=2)
    assert np.all(distance > radius[:, None] * (1.0 - 1e-6))
    other = Delaunay(points).simplices
    kept = np.abs(tetrahedron_volumes(points, other)) > 1e-9
    assert {tuple(sorted(c)) for c in other[kept]} == {tuple(sorted(c)) for c in cells.tolist()}


def test_four_points_are_one_cell() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert len(delaunay(points)) == 1


@pytest.mark.parametrize("points", [LATTICE * [1.0, 1.0, 0.0], LATTICE[:3], np.zeros((6, 3))])
def test_points_without_volume_are_refused(points: Array) -> None:
    with pytest.raises(InputError, match="no Delaunay tetrahedra"):
        delaunay(points)


@pytest.mark.parametrize("unit", [1e-3, 25.4, 1e3])
@pytest.mark.parametrize("place", [0.0, 3.7])
def test_a_fill_is_the_same_in_every_unit(unit: float, place: float) -> None:
    box = Box((-1.0, -1.0, -1.0)).mesh(0.4)

    def filled(unit: float, place: float) -> PointCloud:
        vertices = unit * (box.vertices * [1.0, 1.2, 0.8] + place)
        surface = Surface.closed(vertices=vertices, faces=box.faces)
        return PointCloud.fill(surface=surface, spacing=0.4 * unit)

    one, other = filled(1.0, 0.0).mesh(AS_MESHED), filled(unit, place).mesh(AS_MESHED)
    np.testing.assert_array_equal(one.cells, other.cells)
    np.testing.assert_allclose(other.vertices / unit - place, one.vertices, atol=1e-13)
