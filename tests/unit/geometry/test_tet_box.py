"""A box of unstructured tetrahedra: exact body, no slivers, no order, the same for one seed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sphsolid.errors import InputError
from sphsolid.geometry import Box, TetBox
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.delaunay import open_facets, tetrahedron_volumes
from sphsolid.geometry.integrals import area_vectors, vertex_volumes

LOW, HIGH = (-1.0, 0.0, 2.0), (0.5, 1.0, 2.6)
SIZES = np.subtract(HIGH, LOW)
VOLUME = float(np.prod(SIZES))


@pytest.mark.parametrize(("spacing", "seed"), [(0.5, 0), (0.2, 1), (0.1, 2)])
def test_cells_fill_the_box_exactly(spacing: float, seed: int) -> None:
    body = TetBox(LOW, HIGH, seed)
    mesh = body.mesh(spacing)
    V = vertex_volumes(mesh)
    assert body.volume == pytest.approx(VOLUME, rel=1e-15)
    assert V.sum() == pytest.approx(VOLUME, rel=1e-13)
    np.testing.assert_allclose(V @ mesh.vertices, VOLUME * np.mean([LOW, HIGH], axis=0), rtol=1e-12)
    areas = area_vectors(mesh, mesh.boundary)
    np.testing.assert_allclose(areas.sum(axis=0), 0.0, atol=1e-13)
    np.testing.assert_allclose(areas.T @ mesh.vertices, VOLUME * np.eye(3), atol=1e-12)


def test_faces_are_flat_complete_and_outward() -> None:
    mesh = TetBox(LOW, HIGH).mesh(0.1)
    assert sorted(mesh.faces) == ["X+", "X-", "Y+", "Y-", "Z+", "Z-"]
    for axis, name in enumerate("XYZ"):
        for sign, plane in ((-1.0, LOW), (1.0, HIGH)):
            facets = mesh.face(name + ("+" if sign > 0 else "-"))
            np.testing.assert_array_equal(mesh.vertices[facets][:, :, axis], plane[axis])
            area = area_vectors(mesh, facets).sum(axis=0)
            exact = np.zeros(3)
            exact[axis] = sign * VOLUME / SIZES[axis]
            np.testing.assert_allclose(area, exact, atol=1e-13)
    assert len(mesh.boundary) == len(open_facets(mesh.cells)[0])


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_no_cell_is_a_sliver_and_points_keep_apart(seed: int) -> None:
    mesh = TetBox(seed=seed).mesh(0.1)
    assert mesh.spacing == pytest.approx(0.1, rel=1e-12)
    assert len(mesh.vertices) == len(Box().mesh(0.1).vertices)
    volume = tetrahedron_volumes(mesh.vertices, mesh.cells) / (mesh.spacing**3 / 6.0)
    assert volume.min() > 0.05
    assert vertex_volumes(mesh).min() > 0.01 * mesh.spacing**3
    nearest = cKDTree(mesh.vertices).query(mesh.vertices, k=2)[0][:, 1]
    assert nearest.min() > 0.55 * mesh.spacing


def test_there_is_no_grid_behind_it() -> None:
    """Coordinates of inner points fall anywhere between the planes of a lattice."""
    mesh = TetBox().mesh(0.1)
    inner = np.all((mesh.vertices > 0.2) & (mesh.vertices < 0.8), axis=1)
    phase = np.exp(2j * np.pi * mesh.vertices[inner] / mesh.spacing).mean(axis=0)
    assert np.abs(phase).max() < 0.25
    lattice = Box(jitter=0.4).mesh(0.1).vertices
    lattice = lattice[np.all((lattice > 0.2) & (lattice < 0.8), axis=1)]
    assert np.abs(np.exp(2j * np.pi * lattice / 0.1).mean(axis=0)).min() > 0.7
    assert not mesh.is_lattice


def test_a_seed_repeats_and_another_differs() -> None:
    first, again, other = (TetBox(seed=s).mesh(0.25) for s in (3, 3, 4))
    np.testing.assert_array_equal(first.vertices, again.vertices)
    np.testing.assert_array_equal(first.cells, again.cells)
    assert not np.array_equal(first.vertices, other.vertices)


def test_one_cell_layer_and_less() -> None:
    mesh = TetBox(upper=(1.0, 1.0, 0.1)).mesh(0.25)
    assert vertex_volumes(mesh).sum() == pytest.approx(0.1, rel=1e-13)
    assert len(TetBox().mesh(7.0).vertices) == 8


@pytest.mark.parametrize(
    ("body", "spacing", "named"),
    [
        (TetBox(), 0.0, "spacing"),
        (TetBox(), float("nan"), "spacing"),
        (TetBox(), AS_MESHED, "TetBox"),
        (TetBox(upper=(1.0, 0.0, 1.0)), 0.5, "upper"),
    ],
)
def test_bad_boxes_are_refused(body: TetBox, spacing: float, named: str) -> None:
    with pytest.raises(InputError, match=named):
        body.mesh(spacing)
