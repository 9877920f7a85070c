"""Pairs whose straight line leaves the body are none, on every kind of mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import build_cloud, build_secondary
from sphsolid.cloud.pairs.neighbours import pairs_within
from sphsolid.cloud.pairs.parts import parts_of
from sphsolid.cloud.pairs.sight import Sight
from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, Box, HexMesh, Mesh, PointCloud, Surface, TetBox
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.integrals import vertex_volumes
from tests.oracles.hidden_pairs import BLOCKS, both, leaves_blocks, tetrahedra, with_slit
from tests.oracles.surfaces import boundary, sphere

TURN = np.linalg.qr(np.array([[2.0, 1.0, 0.3], [-0.7, 1.9, 0.4], [0.2, -0.5, 2.2]]))[0]
TURN = TURN * np.linalg.det(TURN)


def found(mesh: Mesh, reach: float):
    """All pairs within ``reach``, and those that are left."""
    pairs = pairs_within(mesh.vertices, mesh.vertices, reach)
    return pairs, Sight.within(mesh).seen(mesh.vertices, pairs)


@pytest.mark.parametrize("reach", [0.77, 1.0])
@pytest.mark.parametrize("name", BLOCKS)
def test_pairs_of_blocks_are_those_that_lie_in_them(name: str, reach: float) -> None:
    mesh = BLOCKS[name].mesh(0.5)
    X = mesh.vertices
    pairs, seen = found(mesh, reach)
    row, column = pairs.row_of_pair, pairs.indices
    inside = ~leaves_blocks(BLOCKS[name], X[row], X[column])
    inside |= row == column
    if name == "parts":
        # A gap of a tenth of a spacing: any two particles of different parts.
        inside &= (X[row, 2] > 1.01) == (X[column, 2] > 1.01)
    expected = set(zip(row[inside].tolist(), column[inside].tolist(), strict=True))
    assert both(seen) == expected
    assert len(expected) < pairs.pairs or (name == "hinge" and reach < 0.8)
    assert {(b, a) for a, b in both(seen)} == both(seen)
    assert np.all(np.diff(seen.indptr) > 0)


@pytest.mark.parametrize("name", BLOCKS)
def test_the_same_in_any_direction_sheared_and_far_away(name: str) -> None:
    """Slots that no axis is aligned with: the same pairs are left of the same list."""
    mesh = BLOCKS[name].mesh(0.5)
    pairs, seen = found(mesh, 0.9)
    shear = np.eye(3) + 0.2 * np.outer([1.0, 0.0, 0.0], [0.0, 0.3, 1.0])
    X = 1.0e-3 * (mesh.vertices @ (TURN @ shear).T) + [3.0, -7.0, 1.0]
    turned = replace(mesh, vertices=X, is_lattice=False)
    for moved in (turned, tetrahedra(turned)):
        assert both(Sight.within(moved).seen(X, pairs)) == both(seen)


def test_a_convex_body_keeps_its_list_as_it_is() -> None:
    ball = PointCloud.fill(surface=sphere(0.25), spacing=0.2)
    bodies = [
        Box().mesh(0.2), Box(jitter=0.4, seed=3).mesh(0.2), TetBox().mesh(0.34),
        Box(aspect=(1, 2, 0.5)).mesh(0.2), ball.mesh(AS_MESHED),
    ]  # fmt: skip
    for mesh in bodies:
        pairs, seen = found(mesh, 0.5)
        assert seen is pairs
    X = Box().mesh(0.2).vertices @ TURN.T
    assert Sight.within(replace(bodies[0], vertices=X)).is_clear


@pytest.mark.parametrize("turn", [np.eye(3), TURN])
def test_a_slit_without_width_parts_its_two_sides(turn: np.ndarray) -> None:
    """Two particles at one place, on both sides of a crack that ends in the middle of the body."""
    mesh = with_slit(Box((0, 0, 0), (2, 1, 1)).mesh(0.25), 2, 0.5, 1.0)
    mesh = replace(mesh, vertices=mesh.vertices @ turn.T)
    upper = np.unique(mesh.cells[(mesh.vertices @ turn)[mesh.cells].mean(axis=1)[:, 2] > 0.5])
    pairs, seen = found(mesh, 0.45)
    X = mesh.vertices @ turn
    above = np.isin(np.arange(len(X)), upper)
    cracked = X[:, 0] > 1.0 + 1e-9

    def across(of):
        row, column = of.row_of_pair, of.indices
        return np.count_nonzero(
            (above[row] != above[column]) & cracked[row] & cracked[column]
        )

    assert across(pairs) > 100
    assert across(seen) == 0
    # The end of the crack does not hide what lies ahead of it.
    ahead = (X[pairs.row_of_pair, 0] <= 1.0) & (X[pairs.indices, 0] <= 1.0)
    kept = (X[seen.row_of_pair, 0] <= 1.0) & (X[seen.indices, 0] <= 1.0)
    assert np.count_nonzero(ahead) == np.count_nonzero(kept)


def ring(around: int, radius: float, layers: int = 3) -> HexMesh:
    """A thick-walled tube of axis Z: ``around`` cells around a hole of ``radius`` [m]."""
    size = 2.0 * np.pi * radius / around
    box = Box((0, 0, 0), (around, layers, 3)).mesh(1.0)
    angle = 2.0 * np.pi * (box.vertices[:, 0] % around) / around
    r = radius + size * (layers - box.vertices[:, 1])
    X = np.stack([r * np.cos(angle), r * np.sin(angle), size * box.vertices[:, 2]], axis=1)
    _, first, number = np.unique(
        np.round(X / size, 6), axis=0, return_index=True, return_inverse=True
    )
    number = number.ravel()
    faces = {name: number[box.faces[name]] for name in ("Y-", "Y+", "Z-", "Z+")}
    return HexMesh(X[first], number[box.cells], faces, size, is_lattice=False)


def test_chords_of_a_wide_hole_are_kept_and_those_across_a_narrow_one_are_not() -> None:
    wide = ring(around=40, radius=1.0)
    assert vertex_volumes(wide).min() > 0.0
    # Chords over two facets lie a twelfth of their length off the surface.
    pairs, seen = found(wide, 2.02 * wide.spacing)
    assert pairs.pairs == seen.pairs
    narrow = ring(around=6, radius=1.0)
    X = narrow.vertices
    pairs, seen = found(narrow, 2.02 * narrow.spacing)
    on_hole = np.hypot(X[:, 0], X[:, 1]) < 1.0 + 1e-9
    angle = np.arctan2(X[:, 1], X[:, 0])

    def opposite(of):
        row, column = of.row_of_pair, of.indices
        turn = np.abs(np.angle(np.exp(1j * (angle[row] - angle[column]))))
        return np.count_nonzero(on_hole[row] & on_hole[column] & (turn > 1.1))

    assert opposite(pairs) > 0
    assert opposite(seen) == 0


@pytest.mark.parametrize("name", ["slot", "notch", "hole", "parts"])
def test_point_clouds_and_their_secondary_points(name: str) -> None:
    """Delaunay cells and their clusters do not reach across either."""
    blocks = BLOCKS[name]
    cloud = PointCloud.fill(surface=boundary(blocks, 0.5), spacing=0.5, jitter=0.2, seed=1)
    made = build_cloud(
        cloud.mesh(AS_MESHED), smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=sph.Literal()
    )
    points = build_secondary(made, sph.cloud.agglomerated.Agglomerated())
    assert made.left_out > 0
    assert points.left_out > 0
    for start, pairs in ((made.X, made.pairs), (points.X, points.pairs)):
        one, two = start[pairs.row_of_pair], made.X[pairs.indices]
        # By much less than a slot is wide they may: a tenth of their length off the body.
        grown = Blocks(
            tuple(
                (tuple(np.subtract(low, 0.1)), tuple(np.add(high, 0.1)))
                for low, high in blocks.blocks
            )
        )
        assert not np.any(leaves_blocks(grown, one, two))
        if name == "parts":
            assert np.array_equal(one[:, 2] > 1.025, two[:, 2] > 1.025)


@pytest.mark.parametrize("points", [sph.H1(), sph.H6()], ids=lambda p: p.name)
def test_secondary_points_of_hexahedra(points) -> None:
    mesh = BLOCKS["slot"].mesh(0.5)
    cloud = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=sph.Literal()
    )
    secondary = build_secondary(cloud, points)
    pairs = secondary.pairs
    assert secondary.left_out > 0
    one, two = secondary.X[pairs.row_of_pair], cloud.X[pairs.indices]
    prong = [np.where(X[:, 0] > 1.0, np.sign(X[:, 2] - 1.25), 0.0) for X in (one, two)]
    assert not np.any(prong[0] * prong[1] < 0.0)
    # What is left still interpolates a linear field exactly.
    a = secondary.sample[:, 3] * (cloud.X[pairs.indices] @ [1.0, -2.0, 3.0])
    np.testing.assert_allclose(
        np.add.reduceat(a, pairs.indptr[:-1]), secondary.X @ [1.0, -2.0, 3.0], atol=1e-12
    )


def test_neither_step_nor_lengths_see_a_gap() -> None:
    mesh = BLOCKS["parts"].mesh(0.5)
    assert mesh.is_lattice
    assert mesh.spacing == pytest.approx(0.5)
    assert mesh.widest == pytest.approx(0.5)
    cloud = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=0.77, operator=sph.Consistent()
    )
    assert cloud.h_min == pytest.approx(0.5)
    assert cloud.parts == 2
    assert np.array_equal(parts_of(cloud.pairs), (cloud.X[:, 2] > 1.02).astype(int))
    # Each part has the operator of one alone.
    alone = build_cloud(
        Box().mesh(0.5), smoothing=sph.WendlandC2(), h_over_dx=0.77, operator=sph.Consistent()
    )
    np.testing.assert_allclose(
        np.sort(np.abs(cloud.gradients.force), axis=0),
        np.sort(np.abs(np.concatenate([alone.gradients.force] * 2)), axis=0), atol=1e-9,
    )  # fmt: skip


def test_the_spacing_of_a_point_is_that_of_its_own_part() -> None:
    """A fine part beside a coarse one: the fine one's points see fine particles only."""
    coarse, fine = Box((0, 0, 0), (1, 1, 1)).mesh(0.25), Box((0, 0, 1.02), (1, 1, 2.02)).mesh(0.1)
    count = len(coarse.vertices)
    mesh = HexMesh(
        np.concatenate([coarse.vertices, fine.vertices]),
        np.concatenate([coarse.cells, fine.cells + count]),
        {"boundary": np.concatenate([coarse.boundary, fine.boundary + count])},
        0.1, is_lattice=False,
    )  # fmt: skip
    lengths = sph.cloud.lengths.lengths_of(mesh, 1.0)
    points = np.array([[0.37, 0.4, 0.93], [0.5, 0.52, 1.03]])
    np.testing.assert_allclose(lengths.spacings(points), [0.25, 0.1])
    assert lengths.spacings(mesh.vertices) is lengths.spacing


def test_too_few_particles_on_this_side_are_refused_with_what_to_do() -> None:
    """A prong of one layer of cells, whose support ended on the other prong."""
    thin = Blocks((((0, 0, 0), (1, 2, 4)), ((1, 0, 0), (3, 2, 2)), ((1, 0, 3), (3, 2, 4))))
    mesh = thin.mesh(1.0)
    stretched = replace(mesh, vertices=mesh.vertices * [1.5, 1.0, 1.0], is_lattice=False)
    with pytest.raises(InputError, match=r"h_over_dx = 0.52 .* a gap, slot or notch is between"):
        build_cloud(stretched, smoothing=sph.WendlandC2(), h_over_dx=0.52, operator=sph.Literal())


def test_the_plan_says_how_many_pairs_are_left_out() -> None:
    scene = sph.scenes.swinging_cube()

    def material(body) -> str:
        sim = sph.Simulation(
            replace(scene, body=body, constraints=(), probes={}), spacing=0.5
        )
        return next(line for line in sim.plan().splitlines() if line.startswith("material"))

    assert "nothing in the body is hidden" in material(Box())
    assert "2 parts share no pair" in material(BLOCKS["parts"])
    assert "there is no contact" in material(BLOCKS["parts"])
    assert "leaves the body" in material(BLOCKS["slot"])


def test_a_surface_around_two_bodies_is_filled_body_by_body() -> None:
    """A tenth of a spacing apart and shifted sideways: no cell joins them, both exact."""
    one, two = Box().mesh(0.25), Box((0.11, 0.11, 1.025), (1.11, 1.11, 2.025)).mesh(0.25)
    count = len(one.vertices)
    surface = Surface.closed(
        vertices=np.concatenate([one.vertices, two.vertices]),
        faces=np.concatenate([one.boundary, two.boundary + count]),
    )
    mesh = PointCloud.fill(surface=surface, spacing=0.25, jitter=0.2).mesh(AS_MESHED)
    above = mesh.vertices[:, 2] > 1.01
    assert np.all(above[mesh.cells] == above[mesh.cells[:, :1]])
    V = vertex_volumes(mesh)
    assert V[above].sum() == pytest.approx(1.0, rel=1e-13)
    assert V[~above].sum() == pytest.approx(1.0, rel=1e-13)
