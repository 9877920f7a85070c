"""Lines of sight are looked at in blocks: memory is bounded, and the blocks do not matter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sphsolid.cloud.pairs.neighbours import pairs_within
from sphsolid.cloud.pairs.sight import Sight
from sphsolid.geometry import Blocks, line_of_sight, triangle_balls
from sphsolid.geometry.mesh import Mesh
from tests.oracles import moved_meshes as moved

CHANNEL = (((0, 0, 0), (1, 3, 1)), ((1, 0, 0), (2, 1, 1)), ((2, 0, 0), (3, 3, 1)))
BODIES = {"hole": moved.block_with_hole(12, 2, 4), "channel": Blocks(CHANNEL).mesh(0.25)}


def seen(mesh: Mesh) -> Any:
    """Neighbours that see each other, from a wide support."""
    pairs = pairs_within(mesh.vertices, mesh.vertices, 4.0 * mesh.spacing)
    kept = Sight.within(mesh).seen(mesh.vertices, pairs)
    assert kept.pairs < pairs.pairs
    return kept.indices


@pytest.mark.parametrize("body", BODIES)
def test_blocks_are_bounded_and_do_not_matter(body: str, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh, sizes = BODIES[body], [0]
    known = seen(mesh)
    through = line_of_sight._through

    def counted(X: Any, triangles: Any, ends: Any) -> Any:
        sizes.append(len(ends))
        return through(X, triangles, ends)

    monkeypatch.setattr(line_of_sight, "_through", counted)
    monkeypatch.setattr(triangle_balls, "MOST", 1000)
    np.testing.assert_array_equal(seen(mesh), known)
    assert len(sizes) > 3
    assert 0 < max(sizes) <= 1000


@pytest.mark.parametrize("most", [1, 7, 100])
def test_every_item_is_in_one_block(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(triangle_balls, "MOST", most)
    count = np.random.default_rng(0).integers(0, 30, 50)
    parts = [np.arange(50)[part] for part in triangle_balls.blocks(count)]
    np.testing.assert_array_equal(np.concatenate(parts), np.arange(50))
    assert all(len(part) == 1 or count[part].sum() <= most for part in parts)
    assert not list(triangle_balls.blocks(count[:0]))
