"""A constant traction has the resultant and the moment of the facets, whatever the operator."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.geometry.mesh import HexMesh
from sphsolid.scenes import Box, Constraint, Region, Scene, Tagged, Traction

LAW = sph.NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.3, density=1000.0)
OPERATORS = (sph.LatticeDifference(2), sph.LatticeDifference(4), sph.LatticeDifference(6))
#: Part of X+ by its ends along Y and Z, inside and at an edge.
PATCHES = ((0.0, 0.125), (0.0, 0.25), (0.25, 0.5), (0.5, 1.0))


def loaded(body: Any, operator: sph.OperatorKind, face: str) -> sph.Simulation:
    scene = Scene(
        "loaded", body, LAW, 1.0, constraints=(Constraint("X-", "all"),),
        tractions=(Traction(face, lambda X, N, t: np.full_like(X, 1.0)),),
    )  # fmt: skip
    return sph.Simulation(scene, spacing=0.125, operator=operator)


@pytest.mark.parametrize("operator", OPERATORS, ids=str)
@pytest.mark.parametrize("ends", PATCHES, ids=str)
def test_part_of_a_side(ends: tuple[float, float], operator: sph.OperatorKind) -> None:
    low, high = ends
    inside = lambda X: np.all((low < X[:, 1:]) & (X[:, 1:] < high), axis=1)  # noqa: E731
    sim = loaded(Tagged(Box(), (Region("part", "X+", inside),)), operator, "part")
    [side] = sim.cloud.areas_of_sides("part")
    size = (high - low) ** 2
    np.testing.assert_allclose(side.sum(axis=0), [size, 0.0, 0.0], atol=1e-13)
    middle = side[:, 0] @ sim.cloud.X / size
    np.testing.assert_allclose(middle, [1.0, (low + high) / 2, (low + high) / 2], atol=1e-12)


@dataclass(frozen=True)
class Round:
    """A box whose sides X+ and Z+ have one tag."""

    body: Box

    def mesh(self, spacing: float) -> HexMesh:
        mesh = self.body.mesh(spacing)
        faces = dict(mesh.faces)
        faces["both"] = np.concatenate([faces.pop("X+"), faces.pop("Z+")])
        return replace(mesh, faces=faces)

    @property
    def volume(self) -> float:
        return self.body.volume


@pytest.mark.parametrize("operator", OPERATORS, ids=str)
def test_a_tag_round_an_edge(operator: sph.OperatorKind) -> None:
    sim = loaded(Round(Box()), operator, "both")
    found = sim.cloud.areas_of_sides("both")
    assert len(found) == 2
    for side in found:
        sums = np.abs(side.sum(axis=0))
        assert np.sort(sums) == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
        # Normals of a flat side are its own, on the edge too.
        assert np.all(np.delete(side, int(np.argmax(sums)), axis=1) == 0.0)


@pytest.mark.parametrize("operator", OPERATORS, ids=str)
def test_whole_sides_keep_the_areas_of_the_operator(operator: sph.OperatorKind) -> None:
    sim = loaded(Box(), operator, "Y+")
    [side] = sim.cloud.areas_of_sides("Y+")
    np.testing.assert_array_equal(side, sim.cloud.areas_of("Y+"))
