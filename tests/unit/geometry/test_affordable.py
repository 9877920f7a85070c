"""A spacing in the wrong unit is refused before memory is asked for, by every body that has one."""

from __future__ import annotations

import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, Surface, TetBox
from sphsolid.geometry.point_cloud import interior_lattice
from sphsolid.scenes import Blocks

CUBE = Box().mesh(0.5)
SURFACE = Surface.closed(vertices=CUBE.vertices, faces=CUBE.faces)
LONG = Blocks((((0, 0, 0), (10, 1, 1)), ((0, 0, 0), (1, 10, 1))))


@pytest.mark.parametrize(
    ("mesh", "cells"),
    [
        (lambda: Box().mesh(1e-9), "1e.27"),
        (lambda: Box(upper=(1.0, 40.0, 1.0)).mesh(1e-3), "4e.10"),
        (lambda: LONG.mesh(1e-4), "1e.14"),
        (lambda: interior_lattice(surface=SURFACE, spacing=1e-3), "1e.09"),
        (lambda: TetBox().mesh(1e-6), "1e.18"),
    ],
)
def test_too_many_cells_are_refused_in_one_sentence(mesh, cells):
    with pytest.raises(InputError, match=cells):
        mesh()


def test_the_counts_of_a_big_study_are_not_refused():
    assert len(Box().mesh(1.0 / 64.0).cells) == 64**3
