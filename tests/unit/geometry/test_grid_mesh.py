"""Boxes and unions of boxes on a grid: the body stays exact, tags never overlap."""

from __future__ import annotations

import hashlib
from itertools import combinations

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry.grid_mesh import GridAxis
from sphsolid.geometry.integrals import area_vectors, vertex_volumes
from sphsolid.scenes import Blocks, Box, l_shaped_block

#: A corner of a cube left out, two blocks that overlap, and a frame with a hole.
BODIES = {
    "corner": Blocks(
        (((0, 0, 0), (1, 1, 0.5)), ((0, 0, 0.5), (1, 0.4, 1)), ((0, 0, 0), (0.3, 1, 1)))
    ),
    "overlap": Blocks((((0, 0, 0), (2, 1, 1)), ((1, 0.5, 0), (3, 2, 1)))),
    "frame": Blocks(
        (
            ((0, 0, 0), (3, 1, 1)),
            ((0, 2, 0), (3, 3, 1)),
            ((0, 1, 0), (1, 2, 1)),
            ((2, 1, 0), (3, 2, 1)),
        )
    ),
}
VOLUMES = {
    "corner": 0.5 + 0.4 * 0.5 + 0.3 * 0.6 * 0.5,
    "overlap": 2.0 + 3.0 - 0.5,
    "frame": 8.0,
}


def digest(mesh) -> str:
    """Hash of all bits of a mesh."""
    found = hashlib.sha256()
    for array in (mesh.vertices, mesh.cells, *mesh.faces.values(), mesh.boundary):
        found.update(np.ascontiguousarray(array).tobytes())
    found.update(repr((list(mesh.faces), mesh.spacing, mesh.is_lattice)).encode())
    return found.hexdigest()[:16]


@pytest.mark.parametrize(
    ("box", "spacing", "expected"),
    [
        (Box(), 0.125, "032882ea6179b53e"),
        (Box(jitter=0.2), 0.125, "7e3476ec1e22b30d"),
        (Box((-0.5, 0.0, -0.5), (0.5, 6.0, 0.5)), 0.2, "30b61b4a9a14e837"),
        (Box((0.1, 0.2, 0.3), (1.7, 0.9, 0.71), jitter=0.9, seed=3), 0.13, "e8981a671d2a27f5"),
    ],
)
def test_boxes_are_the_bits_that_stored_results_were_made_with(box, spacing, expected):
    """Vertices, cells, faces, random offsets: the results in reports/ were made with them."""
    assert digest(box.mesh(spacing)) == expected


def test_one_block_is_a_box():
    box = Box((0.0, 1.0, 0.0), (1.0, 3.0, 0.7), jitter=0.3, seed=5)
    block = Blocks(((box.lower, box.upper),), jitter=0.3, seed=5)
    assert digest(block.mesh(0.21)) == digest(box.mesh(0.21))
    assert block.volume == pytest.approx(box.volume, rel=1e-15)


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_cells_fill_the_union(name, jitter):
    body = Blocks(BODIES[name].blocks, jitter=jitter, seed=2)
    mesh = body.mesh(0.17)
    V = vertex_volumes(mesh)
    assert body.volume == pytest.approx(VOLUMES[name], rel=1e-14)
    assert np.all(V > 0.0)
    assert V.sum() == pytest.approx(VOLUMES[name], rel=1e-13)
    np.testing.assert_array_equal(np.unique(mesh.cells), np.arange(len(mesh.vertices)))


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_boundary_is_closed_and_counted_once(name, jitter):
    body = Blocks(BODIES[name].blocks, jitter=jitter, seed=2)
    mesh = body.mesh(0.17)
    areas = area_vectors(mesh, mesh.boundary)
    np.testing.assert_allclose(areas.sum(axis=0), 0.0, atol=1e-13)
    # sum A_a N_a (x) X_a = V I holds only if every exposed face is there once, turned outward.
    moment = areas.T @ mesh.vertices
    np.testing.assert_allclose(moment, VOLUMES[name] * np.eye(3), atol=1e-12)
    edges = np.sort(np.stack([mesh.boundary, np.roll(mesh.boundary, -1, axis=1)], -1), axis=-1)
    _, count = np.unique(edges.reshape(-1, 2), axis=0, return_counts=True)
    assert set(count) == {2}


@pytest.mark.parametrize("name", BODIES)
def test_faces_are_planes_named_by_direction_and_place(name):
    mesh = Blocks(BODIES[name].blocks, jitter=0.5, seed=2).mesh(0.17)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    for tag, quads in mesh.faces.items():
        axis, sign = "XYZ".index(tag[0]), 1.0 if tag[1] == "+" else -1.0
        plane = float(tag[3:]) if "@" in tag else (high if sign > 0 else low)[axis]
        np.testing.assert_array_equal(mesh.vertices[np.unique(quads)][:, axis], plane)
        area = area_vectors(mesh, quads).sum(axis=0)
        assert area[axis] * sign == pytest.approx(np.linalg.norm(area))
    assert {"X-", "X+", "Y-", "Y+", "Z-", "Z+"} <= set(mesh.faces)
    for a, b in combinations(mesh.faces.values(), 2):
        assert not {tuple(sorted(q)) for q in a} & {tuple(sorted(q)) for q in b}


def test_disorder_keeps_vertices_in_their_face_edge_or_corner():
    """Three coordinates may move inside, two on a face, one on an edge, none at a corner."""
    plain, moved = (l_shaped_block(jitter=j, seed=1).body.mesh(0.85).vertices for j in (0.0, 0.4))
    change = np.abs(moved - plain) > 0.0
    x, y, z = plain.T
    end_z = (z == 0.0) | (z == 3.0)
    on_x = (x == 0.0) | (x == 6.0) | ((x == 3.0) & (y >= 3.0))
    on_y = (y == 0.0) | (y == 10.0) | ((y == 3.0) & (x >= 3.0))
    np.testing.assert_array_equal(change, ~np.stack([on_x, on_y, end_z], axis=1))
    # The re-entrant edge: particles slide along Z only, its ends are fixed.
    edge = (x == 3.0) & (y == 3.0)
    assert edge.sum() == 5
    np.testing.assert_array_equal(change[edge], np.outer(~end_z[edge], [False, False, True]))
    # Offsets are bounded by the shorter of the two cells that meet at a plane.
    assert np.abs(moved - plain)[:, 0].max() <= 0.2 * 0.75
    assert np.abs(moved - plain)[y <= 3.0, 1].max() <= 0.2 * 0.75
    assert 0.2 * 0.75 < np.abs(moved - plain)[y > 3.0, 1].max() <= 0.2 * 0.875


def test_planes_pass_through_every_break():
    axis = GridAxis.through([0.0, 3.0, 10.0], 0.85)
    assert {0.0, 3.0, 10.0} <= set(axis.planes)
    np.testing.assert_allclose(axis.steps, [0.75] * 4 + [0.875] * 8)
    np.testing.assert_allclose(np.diff(axis.planes), axis.steps)
    np.testing.assert_allclose(axis.room, [0.75] * 5 + [0.875] * 8)
    assert not axis.is_uniform
    assert GridAxis.through([0.0, 3.0, 10.0], 0.5).is_uniform


def test_a_union_is_a_lattice_only_where_all_its_cells_are_alike():
    """The operators treat a lattice as one stencil, which a change of step breaks."""
    body = l_shaped_block(jitter=0.0).body
    assert body.mesh(0.5).is_lattice
    assert not body.mesh(0.85).is_lattice
    assert not l_shaped_block(jitter=0.1).body.mesh(0.5).is_lattice


@pytest.mark.parametrize("aspect", [(1.0, 1.3, 1.0), (2.0, 1.0, 0.5)])
def test_aspect_stretches_cells(aspect):
    mesh = Box((0, 0, 0), (1, 1, 1), aspect=aspect).mesh(0.125)
    counts = [round(8 / a) for a in aspect]
    for d in range(3):
        assert len(np.unique(mesh.vertices[:, d])) == counts[d] + 1
    assert mesh.spacing == pytest.approx(1.0 / max(counts))
    assert mesh.is_lattice


@pytest.mark.parametrize(
    ("body", "spacing", "named"),
    [
        (Blocks(()), 0.5, "at least one block"),
        (Blocks((((0, 0, 0), (1, 1, 0)),)), 0.5, "upper"),
        (Blocks((((0, 0, 0), (1, 1, np.nan)),)), 0.5, "upper"),
        (Blocks((((0, 0, 0), (1, 1, 1)),)), 0.0, "spacing"),
        (Blocks((((0, 0, 0), (1, 1, 1)),), jitter=0.95), 0.5, "jitter"),
        (Box(aspect=(1.0, 0.0, 1.0)), 0.5, "aspect"),
        (Box(aspect=(1.0, np.inf, 1.0)), 0.5, "aspect"),
    ],
)
def test_bad_bodies_are_refused(body, spacing, named):
    with pytest.raises(InputError, match=named):
        body.mesh(spacing)
