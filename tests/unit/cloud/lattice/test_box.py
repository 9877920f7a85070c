"""Which bodies are a full box of lattice points, and how they are numbered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sphsolid.cloud.lattice.box import BoxLattice, NoBox, arranged, box_of
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.scenes import Box, l_shaped_block


def mesh(upper=(1.0, 1.0, 1.0), spacing=0.25, **kw):
    return Box(upper=upper, **kw).mesh(spacing)


@pytest.mark.parametrize("upper", [(1.0, 1.5, 0.75), (2.0, 1.0, 1.0), (1.0, 1.0, 1.0)])
def test_every_grid_point_is_found_whatever_the_numbering(upper):
    body = mesh(upper)
    rng = np.random.default_rng(2)
    order = rng.permutation(len(body.vertices))
    place = np.argsort(order)
    mixed = replace(
        body, vertices=body.vertices[order] + 1.0e6 * np.ones(3), cells=place[body.cells],
        faces={name: place[quads] for name, quads in body.faces.items()},
    )  # fmt: skip
    box = box_of(mixed)
    assert isinstance(box, BoxLattice)
    assert box.counts == tuple(round(side / 0.25) + 1 for side in upper)
    X = mixed.vertices[box.number] - 1.0e6
    for axis in range(3):
        steps = np.diff(X[..., axis], axis=axis)
        np.testing.assert_allclose(steps, box.dx[axis], rtol=1e-8)


def test_the_longest_axis_runs_fastest_and_the_body_stays_what_it_is():
    body = mesh((1.0, 1.5, 0.75))
    box = box_of(body)
    made = arranged(body, box)
    again = box_of(made)
    assert again.is_arranged
    assert again.directions == (2, 0, 1)
    line = made.vertices[:7]
    np.testing.assert_array_equal(line[:, 0], line[0, 0])
    np.testing.assert_array_equal(line[:, 2], line[0, 2])
    assert np.sum(vertex_volumes(made)) == pytest.approx(1.125)
    for name in body.faces:
        np.testing.assert_array_equal(
            np.unique(body.vertices[body.face_particles(name)], axis=0),
            np.unique(made.vertices[made.face_particles(name)], axis=0),
        )


@pytest.mark.parametrize(
    "body",
    [
        mesh(jitter=0.2),
        l_shaped_block().body.mesh(1.0),
    ],
    ids=["jitter", "L"],
)
def test_other_bodies_are_none(body):
    assert isinstance(box_of(body), NoBox)
