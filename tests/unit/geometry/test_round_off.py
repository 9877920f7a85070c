"""What differs by round-off only is one: sides of blocks, and parts that were meant to touch."""

from __future__ import annotations

import re

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, Box, MeshFile, Surface, check_mesh
from sphsolid.geometry.body import AS_MESHED
from tests.oracles.gmsh_text import write_gmsh
from tests.unit.geometry.test_grid_mesh import digest

#: Three tenths twice: they differ in the last digit.
A = 0.1 + 0.2
SIDES = {
    "a gap": ((((0, 0, 0), (0.3, 1, 1)), ((A, 0, 0), (1, 1, 1))), 1.0),
    "an overlap": ((((0, 0, 0), (A, 1, 1)), ((0.3, 0, 0), (1, 1, 1))), 1.0),
    "a gap along Z": ((((0, 0, 0), (1, 1, 0.3)), ((0, 0, A), (1, 1, 1))), 1.0),
    "an outer side": ((((0, 0, 0), (0.5, A, 1)), ((0.5, 0, 0), (1, 0.3, 1))), 0.3),
    "an inner step": ((((0, 0, 0), (0.5, A, 1)), ((0.5, 0, 0), (1, 0.3, 1)),
                       ((0, 0, 0), (0.25, 1, 1))), 0.475),
    "negative sides": ((((-1, 0, 0), (-A, 1, 1)), ((-0.3, 0, 0), (0, 1, 1))), 1.0),
    "far from the origin": ((((1e5, 0, 0), (1e5 + 0.3, 1, 1)),
                             ((1e5 + A + 1e-11, 0, 0), (1e5 + 1, 1, 1))), 1.0),
}  # fmt: skip


@pytest.mark.parametrize("name", SIDES)
@pytest.mark.parametrize("turned", [False, True])
def test_sides_that_differ_by_round_off_are_one_plane(name, turned):
    blocks, volume = SIDES[name]
    body = Blocks(blocks[::-1] if turned else blocks)
    mesh = body.mesh(0.1)
    assert check_mesh(mesh).parts == 1
    assert np.ptp(mesh.vertices[mesh.cells], axis=1).min() > 0.02
    assert {"X-", "X+", "Y-", "Y+", "Z-", "Z+"} <= set(mesh.faces)
    assert len(mesh.faces) == (8 if name == "an inner step" else 6)
    assert body.volume == pytest.approx(volume, rel=1e-12)
    assert check_mesh(mesh).volume_of_cells == pytest.approx(volume, rel=1e-9)


def test_sides_that_differ_by_more_are_two_planes():
    """A gap of 2e-9 of the body is one that somebody asked for."""
    blocks = (((0, 0, 0), (0.3, 1, 1)), ((0.3 + 4e-9, 0, 0), (1, 1, 1)))
    assert check_mesh(Blocks(blocks).mesh(0.5)).parts == 2
    with pytest.raises(InputError, match=r"box upper .* must exceed lower .* by more than 1e-09"):
        Blocks((((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (1 + 1e-12, 1, 1)))).mesh(0.5)


@pytest.mark.parametrize(
    ("blocks", "bits"),
    [
        ((((0, 0, 0), (1, 1, 0.5)), ((0, 0, 0.5), (1, 0.4, 1)), ((0, 0, 0), (0.3, 1, 1))),
         "727263776666abe2"),
        ((((0, 0, 0), (2, 1, 1)), ((1, 0.5, 0), (3, 2, 1))), "eaee7d34a6bc3bec"),
    ],
)  # fmt: skip
def test_other_blocks_keep_their_bits(blocks, bits):
    assert digest(Blocks(blocks, jitter=0.5, seed=2).mesh(0.17)) == bits


# ------------------------------------------------------------ parts of a file, or of a surface
BOX = Box().mesh(0.5)
COUNT = len(BOX.vertices)


def two_boxes(shift, turn=None):
    """Eight cubes, and eight more on the far side of X = 1, with a gap or an overlap."""
    other = BOX.vertices if turn is None else BOX.vertices @ turn.T
    return np.concatenate([BOX.vertices, other + np.asarray(shift)])


def crack(width):
    """A box cut along X = 1/2 from above to the middle, both sides with vertices of their own."""
    points, cells = BOX.vertices.copy(), BOX.cells.copy()
    side = np.flatnonzero((points[:, 0] == 0.5) & (points[:, 2] > 0.5))
    right = np.flatnonzero(points[cells].mean(axis=1)[:, 0] > 0.5)
    renumber = np.arange(COUNT)
    renumber[side] = COUNT + np.arange(len(side))
    cells[right] = renumber[cells[right]]
    return np.concatenate([points, points[side] + np.array([width, 0.0, 0.0])]), cells


def meshed(folder, points, cells):
    path = write_gmsh(folder / "body.msh", points, [("hexahedron", cells, 99)])
    return MeshFile(path).mesh(AS_MESHED)


BOTH = np.concatenate([BOX.cells, BOX.cells + COUNT])


@pytest.mark.parametrize("gap", [1e-11, 1e-8, -1e-8, 3e-7, -3e-7, 1e-5, 4e-4, -4e-4])
def test_parts_of_a_file_that_touch_up_to_round_off_are_refused(tmp_path, gap):
    with pytest.raises(InputError) as caught:
        meshed(tmp_path, two_boxes((1.0 + gap, 0.0, 0.0)), BOTH)
    said = str(caught.value)
    assert re.search(r"9 pairs of vertices .* \(vertices 18 and 27\): parts that touch there", said)
    assert "are not joined; fragment" in said
    assert "\n" not in said


def test_digits_of_a_file_are_no_gap(tmp_path):
    """Coordinates of six digits of two parts that were moved before they were written."""
    points = two_boxes((1.0, 0.0, 0.0)) / 3.0 + np.repeat([[1.0 / 7.0], [1.0 / 7.0 + 3e-7]], 27, 0)
    rounded = np.array([float(f"{x:.5e}") for x in points.ravel()]).reshape(-1, 3)
    with pytest.raises(InputError, match="parts that touch there are not joined"):
        meshed(tmp_path, rounded, BOTH)


@pytest.mark.parametrize("gap", [1e-3, 0.01, 0.05, 0.5])
def test_narrow_gaps_stay_gaps(tmp_path, gap):
    assert check_mesh(meshed(tmp_path, two_boxes((1.0 + gap, 0.0, 0.0)), BOTH)).parts == 2


def test_the_two_sides_of_a_crack(tmp_path):
    with pytest.raises(InputError, match="3 pairs of vertices lie within 1e-06 m of each other"):
        meshed(tmp_path, *crack(1e-6))
    assert check_mesh(meshed(tmp_path, *crack(0.01))).parts == 1


def test_a_gap_is_measured_by_the_edges_beside_it(tmp_path):
    """Layers of a thousandth of the other edges are no parts that touch."""
    points = BOX.vertices * np.array([1.0, 1.0, 2e-4])
    assert len(meshed(tmp_path, points, BOX.cells).cells) == 8
    apart = np.concatenate([points, points + np.array([0.0, 0.0, 3e-4])])
    assert check_mesh(meshed(tmp_path, apart, BOTH)).parts == 2


QUADS = np.concatenate([BOX.boundary, BOX.boundary + COUNT])
#: Turned by a quarter about X and moved within the plane: no vertex lies on one of the other box.
SLANTED = np.array([[1.0, 0.0, 0.0], [0.0, 0.8, -0.6], [0.0, 0.6, 0.8]])


@pytest.mark.parametrize("gap", [1e-8, -1e-8, 1e-6, 4e-4])
@pytest.mark.parametrize(
    ("along", "turn"),
    [((0.0, 0.0), None), ((0.13, 0.21), None), ((0.1, 0.05), SLANTED)],
)
def test_parts_of_a_surface_that_touch_up_to_round_off_are_refused(gap, along, turn):
    points = two_boxes((1.0 + gap, *along), turn)
    with pytest.raises(InputError, match=r"surface touches (itself|or crosses itself)"):
        Surface.closed(vertices=points, faces=QUADS)
    if gap > 0.0:
        with pytest.raises(InputError, match=r"parts that touch there are not joined; unite"):
            Surface.closed(vertices=points, faces=QUADS)


def test_bars_that_touch_across_each_other_are_refused():
    """Sides cross where they touch, and no corner of one bar is near the other."""
    one = Box((0, 0, 0), (10, 1, 1)).mesh(10.0)
    for gap, fine in ((1e-7, False), (1e-2, True)):
        two = Box((4, -5, 1 + gap), (5, 5, 2 + gap)).mesh(10.0)
        given = {
            "vertices": np.concatenate([one.vertices, two.vertices]),
            "faces": np.concatenate([one.boundary, two.boundary + len(one.vertices)]),
        }
        if fine:
            assert Surface.closed(**given).volume == pytest.approx(20.0)
            continue
        with pytest.raises(InputError, match=r"lie within 1e-07 m of each other near X ="):
            Surface.closed(**given)


@pytest.mark.parametrize("gap", [1e-3, 0.01, 0.5])
def test_narrow_gaps_of_a_surface_stay_gaps(gap):
    points = two_boxes((1.0 + gap, 0.13, 0.21))
    assert Surface.closed(vertices=points, faces=QUADS).volume == pytest.approx(2.0)
