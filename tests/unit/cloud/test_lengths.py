"""Smoothing lengths that follow a graded mesh; one length where it is not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import build_cloud, build_secondary, consistency_report
from sphsolid.cloud.lengths import Local, Uniform, lengths_of, widest_spacing
from sphsolid.cloud.long_cells import doubts
from sphsolid.cloud.pairs.neighbours import pairs_of_lengths, pairs_within
from sphsolid.errors import InputError
from sphsolid.geometry import Box, HexMesh
from sphsolid.scenes import Scene
from tests.oracles.blocks import RUBBER


@dataclasses.dataclass(frozen=True)
class Meshed:
    """A body that is a mesh already."""

    ready: HexMesh
    volume: float

    def mesh(self, spacing: object) -> HexMesh:
        return self.ready


def graded(ratio: float = 4.0) -> HexMesh:
    """A cube whose cells grow along X by ``ratio`` from one side to the other."""
    mesh = Box().mesh(0.125)
    s = np.log(ratio)
    X = mesh.vertices.copy()
    X[:, 0] = (np.exp(s * X[:, 0]) - 1.0) / (ratio - 1.0)
    return dataclasses.replace(mesh, vertices=X, is_lattice=False)


def test_pairs_of_lengths_are_those_of_a_brute_force_search() -> None:
    random = np.random.default_rng(0)
    points, particles = random.uniform(size=(40, 3)), random.uniform(size=(60, 3))
    here, there = random.uniform(0.1, 0.5, 40), random.uniform(0.1, 0.5, 60)
    pairs = pairs_of_lengths(points, particles, here, there)
    distance = np.linalg.norm(points[:, None] - particles, axis=2)
    row, column = np.nonzero(distance < 0.5 * (here[:, None] + there))
    np.testing.assert_array_equal(pairs.row_of_pair, row)
    np.testing.assert_array_equal(pairs.indices, column)


def test_equal_lengths_give_the_pairs_of_one_length() -> None:
    X = Box(jitter=0.4).mesh(0.25).vertices
    equal = pairs_of_lengths(X, X, np.full(len(X), 0.5), np.full(len(X), 0.5))
    one = pairs_within(X, X, 0.5)
    np.testing.assert_array_equal(equal.indptr, one.indptr)
    np.testing.assert_array_equal(equal.indices, one.indices)


def test_a_mesh_that_is_not_graded_has_one_length() -> None:
    for body in (Box(), Box(jitter=0.4)):
        assert isinstance(lengths_of(body.mesh(0.25), 1.0), Uniform)
    lengths = lengths_of(graded(), 1.0)
    assert isinstance(lengths, Local)
    assert np.max(lengths.spacing) > 1.6 * np.min(lengths.spacing)


def test_the_support_of_a_disordered_grid_counts_its_widest_edge() -> None:
    mesh = Box(upper=(3.0, 3.5, 3.0), jitter=0.2).mesh(0.8)
    lengths = lengths_of(mesh, 1.0)
    assert isinstance(lengths, Uniform)
    assert mesh.spacing == pytest.approx(0.75)
    assert lengths.spacing == mesh.widest == pytest.approx(0.875, rel=1e-12)
    cloud = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=sph.Consistent()
    )
    assert cloud.h == pytest.approx(0.875)


def test_the_plan_says_which_edge_the_support_counts() -> None:
    def support(upper: tuple[float, float, float]) -> str:
        scene = Scene("bar", Box(upper=upper, jitter=0.2), RUBBER, 1.0)
        return sph.Simulation(scene, spacing=0.8).plan()

    assert "support 1.925 m = 2.2 times the widest edge, 0.875 m" in support((3.0, 3.5, 3.0))
    assert "support 1.65 m = 2.2 dx" in support((3.0, 3.0, 3.0))


def test_flat_cells_reach_sideways() -> None:
    mesh = Box(upper=(1.0, 1.0, 0.25)).mesh(0.25)
    flat = dataclasses.replace(mesh, vertices=mesh.vertices * [1.0, 1.0, 0.4], is_lattice=False)
    assert np.all(widest_spacing(flat) > 0.25)


@pytest.mark.parametrize(
    "operator", [sph.Literal(), sph.Consistent(), sph.SummationByParts(tolerance=1e-6)]
)
def test_every_operator_keeps_its_identities_on_a_graded_cloud(operator: object) -> None:
    cloud = build_cloud(
        graded(),
        smoothing=sph.WendlandC2(),
        h_over_dx=1.1,
        operator=operator,  # type: ignore[arg-type]
    )
    report = consistency_report(cloud, 1.0)
    assert max(report.C0, report.C1) < 1e-11
    if not isinstance(operator, sph.Literal):
        assert report.D0 < 1e-11
    if isinstance(operator, sph.SummationByParts):
        assert report.SBP < 1e-5
    q = build_secondary(cloud, sph.H1())
    weight = q.sample[:, 3]
    total = np.add.reduceat(weight[:, None] * cloud.X[q.pairs.indices], q.pairs.indptr[:-1])
    np.testing.assert_allclose(total, q.X, atol=1e-12)


def stretched(cells: tuple[int, int, int], edges: tuple[float, float, float]) -> HexMesh:
    """Layers of sheared cells with these edges: no lattice and no grid."""
    mesh = Box(upper=tuple(map(float, cells))).mesh(1.0)
    X = mesh.vertices * edges
    X[:, 0] += 0.1 * edges[0] / edges[1] * X[:, 1]
    size = float(np.cbrt(np.prod(edges)))
    return HexMesh(X, mesh.cells, mesh.faces, size, False)


NEEDLES = {
    "two layers": stretched((16, 16, 2), (1.8e-3, 1.8e-3, 10e-3)),
    "across": stretched((2, 20, 14), (10.0, 2.0, 2.0)),
}


@pytest.mark.parametrize("name", NEEDLES)
def test_needles_whose_support_spans_the_body_are_refused(name: str) -> None:
    mesh = NEEDLES[name]
    with pytest.raises(InputError, match=r"times its shortest .* spans the whole body"):
        sph.Simulation(Scene("needles", Meshed(mesh, 1.0), RUBBER, 1.0))


@pytest.mark.parametrize("edges", [(1.0, 1.0, 4.0), (4.0, 4.0, 1.0)])
def test_cells_much_longer_than_wide_are_warned_of(edges: tuple[float, float, float]) -> None:
    mesh = stretched((4, 4, 4), edges)
    volume = float(np.prod(4.0 * np.array(edges)))
    with pytest.warns(UserWarning, match=r"4 times its shortest .* within a factor of 2"):
        sim = sph.Simulation(
            Scene("long", Meshed(mesh, volume), RUBBER, 1.0), operator=sph.Consistent()
        )
    assert "doubtful       the longest edge of a cell is 4 times its shortest" in sim.plan()


def test_a_gradient_that_had_to_change_much_is_warned_of() -> None:
    mesh = Box(jitter=0.2).mesh(0.25)
    cloud = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=0.9, operator=sph.Consistent()
    )
    assert doubts(cloud) == []
    (text,) = doubts(dataclasses.replace(cloud, change=15.0))
    assert "differs from the printed one by 15" in text
