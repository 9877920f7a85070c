"""The background mesh of a box: volume, outward faces, disorder that keeps the body."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.grid_mesh import box_mesh
from sphsolid.scenes import Box

LOW, HIGH = (-1.0, 0.0, 2.0), (1.0, 0.5, 2.3)
NORMALS = {
    "X-": (-1, 0, 0), "X+": (1, 0, 0),
    "Y-": (0, -1, 0), "Y+": (0, 1, 0),
    "Z-": (0, 0, -1), "Z+": (0, 0, 1),
}  # fmt: skip
#: Six tetrahedra around the diagonal 0-6 of a cell.
TETRAHEDRA = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]


def tetrahedron_volumes(mesh):
    corner = mesh.vertices[mesh.cells[:, np.array(TETRAHEDRA)]]
    return np.linalg.det(corner[:, :, 1:] - corner[:, :, :1]) / 6.0


@pytest.mark.parametrize("jitter", [0.0, 0.2, 0.4])
def test_cells_fill_the_box(jitter):
    mesh = box_mesh(LOW, HIGH, 0.1, jitter, seed=4)
    volumes = tetrahedron_volumes(mesh)
    assert np.all(volumes > 0.0)
    assert volumes.sum() == pytest.approx(2.0 * 0.5 * 0.3, rel=1e-13)
    assert Box(LOW, HIGH).volume == pytest.approx(0.3, rel=1e-15)
    assert mesh.vertices.shape == (21 * 6 * 4, 3)
    assert mesh.cells.shape == (20 * 5 * 3, 8)
    assert mesh.is_lattice == (jitter == 0.0)


def test_corner_order_of_cells():
    mesh = box_mesh((0, 0, 0), (1, 1, 1), 1.0)
    np.testing.assert_array_equal(mesh.vertices[mesh.cells[0]], CORNERS)


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_faces_are_flat_complete_and_point_outward(jitter):
    mesh = box_mesh(LOW, HIGH, 0.1, jitter, seed=4)
    lengths = np.array([2.0, 0.5, 0.3])
    for name, normal in NORMALS.items():
        corner = mesh.vertices[mesh.face(name)]
        area = 0.5 * np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
        normal = np.array(normal, dtype=float)
        assert np.all(area @ normal > 0.0), name
        exact = np.prod(lengths[normal == 0.0]) * normal
        np.testing.assert_allclose(area.sum(axis=0), exact, atol=1e-14)
        axis = int(np.argmax(np.abs(normal)))
        plane = (HIGH if normal[axis] > 0 else LOW)[axis]
        np.testing.assert_array_equal(mesh.vertices[mesh.face_particles(name)][:, axis], plane)
    assert len(mesh.boundary) == 2 * (20 * 5 + 20 * 3 + 5 * 3)


def test_disorder_is_bounded_repeatable_and_keeps_edges():
    plain, moved = (box_mesh(LOW, HIGH, 0.1, j, seed=1).vertices for j in (0.0, 0.4))
    step = np.array([0.1, 0.1, 0.1])
    assert np.all(np.abs(moved - plain) <= 0.2 * step + 1e-15)
    fixed = np.isclose(plain, LOW) | np.isclose(plain, HIGH)
    np.testing.assert_array_equal(moved[fixed], plain[fixed])
    assert np.all(moved[~fixed] != plain[~fixed])
    np.testing.assert_array_equal(moved, box_mesh(LOW, HIGH, 0.1, 0.4, seed=1).vertices)
    assert np.any(moved != box_mesh(LOW, HIGH, 0.1, 0.4, seed=2).vertices)


def test_spacing_is_rounded_to_whole_cells():
    mesh = box_mesh((0, 0, 0), (1, 1, 2), 0.3)
    assert len(mesh.cells) == 3 * 3 * 7
    assert mesh.spacing == pytest.approx(2.0 / 7.0)
    assert len(box_mesh((0, 0, 0), (1, 1, 1), 5.0).cells) == 1


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (((0, 0, 0), (1, 1, 1), 0.0), "spacing"),
        (((0, 0, 0), (1, 1, 1), -0.1), "spacing"),
        (((0, 0, 0), (1, 1, 1), np.nan), "spacing"),
        (((0, 0, 0), (1, 1, 1), 0.5, 1.0), "jitter"),
        (((0, 0, 0), (1, 1, 1), 0.5, -0.1), "jitter"),
        (((0, 0, 0), (1, 0, 1), 0.5), "upper"),
    ],
)
def test_bad_boxes_are_refused(arguments, named):
    with pytest.raises(InputError, match=named):
        box_mesh(*arguments)


def test_unknown_tag_names_those_there_are():
    with pytest.raises(InputError, match=r"'top'.*'X\+', 'X-'"):
        Box().mesh(0.5).face("top")
