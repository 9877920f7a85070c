"""Boxes are found whatever their numbering, and nothing else is taken for one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sphsolid.cloud.lattice.box import BoxLattice, NoBox, box_of
from sphsolid.geometry import Blocks, Box, TetBox

LOWER, UPPER = (-1.0, 2.0, 0.5), (0.0, 2.8, 1.7)


def renumbered(mesh, seed=4):
    """The same mesh with its vertices in another order."""
    order = np.random.default_rng(seed).permutation(len(mesh.vertices))
    place = np.argsort(order)
    faces = {name: place[face] for name, face in mesh.faces.items()}
    return replace(mesh, vertices=mesh.vertices[order], cells=place[mesh.cells], faces=faces)


@pytest.mark.parametrize("change", [lambda mesh: mesh, renumbered], ids=["as meshed", "shuffled"])
def test_every_point_has_its_particle(change):
    mesh = change(Box(lower=LOWER, upper=UPPER).mesh(0.2))
    box = box_of(mesh)
    assert isinstance(box, BoxLattice)
    assert box.counts == (6, 5, 7)
    np.testing.assert_allclose(box.dx, 0.2, rtol=1e-14)
    X = mesh.vertices[box.number]
    i, j, k = np.indices(box.counts)
    index = np.stack([i, j, k], axis=-1)
    np.testing.assert_allclose(X, np.array(LOWER) + index * box.dx, rtol=1e-14, atol=1e-14)


def test_spacings_differ_by_axis_and_far_from_the_origin():
    far = 1.0e5
    mesh = Box(lower=(far, 0.0, 0.0), upper=(far + 1.0, 0.74, 0.34)).mesh(0.2)
    box = box_of(mesh)
    assert isinstance(box, BoxLattice)
    assert box.counts == (6, 5, 3)
    np.testing.assert_allclose(box.dx, [0.2, 0.185, 0.17], rtol=1e-9)


L_SHAPE = Blocks((((0.0, 0.0, 0.0), (2.0, 1.0, 1.0)), ((0.0, 0.0, 0.0), (1.0, 2.0, 1.0))))
GAP = Blocks((((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((2.0, 0.0, 0.0), (3.0, 1.0, 1.0))))
BODIES = {
    "L": (L_SHAPE, 0.25),
    "two parts, a cell apart": (GAP, 1.0),
    "jittered": (Box(jitter=0.3), 0.25),
    "jittered, too small to move": (Box(jitter=0.3), 1.0),
    "tetrahedra": (TetBox(upper=(1.0, 1.0, 1.0)), 0.4),
}


@pytest.mark.parametrize("name", BODIES)
def test_what_is_no_box(name):
    body, spacing = BODIES[name]
    assert box_of(body.mesh(spacing)) == NoBox()


def test_a_union_of_blocks_that_is_a_box_is_one():
    halves = Blocks((((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((1.0, 0.0, 0.0), (2.0, 1.0, 1.0))))
    box = box_of(halves.mesh(0.5))
    assert isinstance(box, BoxLattice)
    assert box.counts == (5, 3, 3)


def test_a_lattice_with_uneven_planes_is_none():
    mesh = Box().mesh(0.25)
    vertices = mesh.vertices.copy()
    vertices[vertices[:, 0] == 0.25, 0] = 0.3
    assert box_of(replace(mesh, vertices=vertices)) == NoBox()


def test_the_order_of_a_box_is_known():
    mesh = Box(upper=(1.0, 1.5, 0.75)).mesh(0.25)
    assert box_of(mesh).is_ordered
    assert not box_of(renumbered(mesh)).is_ordered
