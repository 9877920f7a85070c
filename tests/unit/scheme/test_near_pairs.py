"""Near pairs in tiles."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.geometry import TetBox
from sphsolid.geometry.edges import edges_of
from sphsolid.scenes import Box
from sphsolid.scheme.near_pairs import PARTICLES, SHARES, near_pairs


@pytest.fixture(scope="module", params=[Box(jitter=0.4), TetBox()], ids=["hexahedra", "tetrahedra"])
def made(request):
    mesh = request.param.mesh(0.07)
    X, edges = mesh.vertices, edges_of(mesh)
    return X, edges, near_pairs(edges, X, np.ones(len(X)))


def test_every_particle_has_a_place_in_a_tile(made):
    X, _, near = made
    np.testing.assert_array_equal(np.sort(near.particle), np.arange(len(X)))
    sizes = np.diff(near.tile.astype(int))
    assert len(sizes) % SHARES == 0
    assert len(sizes) > SHARES
    assert sizes.max() <= PARTICLES
    assert sizes.min() >= sizes.max() - 1


def test_every_particle_has_its_edges_in_the_order_of_their_other_ends(made):
    X, edges, near = made
    of = [[] for _ in X]
    for a, b, volume in zip(edges.a, edges.b, edges.volume, strict=True):
        square = 1.0 / np.sum((X[b] - X[a]) ** 2)
        of[a].append((b, volume, pytest.approx(square)))
        of[b].append((a, volume, pytest.approx(square)))
    begin = near.begin.astype(int)
    for tile, row in enumerate(near.row[:-1].astype(int)):
        for i in range(int(near.tile[tile]), int(near.tile[tile + 1])):
            a = near.particle[i]
            k = row + near.slot[begin[2 * i] : begin[2 * i + 2]].astype(int)
            assert np.all(k < near.row[tile + 1])
            lower = np.arange(len(k)) < begin[2 * i + 1] - begin[2 * i]
            assert np.all(np.where(lower, near.b[k], near.a[k]) == a)
            other = np.where(lower, near.a[k], near.b[k])
            found = list(zip(other, near.volume[k], near.per_square[k], strict=True))
            assert found == sorted(of[a], key=lambda pair: pair[0])


def test_few_edges_are_in_two_tiles(made):
    _, edges, near = made
    assert near.most_rows == np.diff(near.row.astype(int)).max()
    assert len(near.a) < 1.3 * len(edges.a)
