"""Differences along the lines of a box are the sums over its pairs."""

from __future__ import annotations

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.compiled import numba, set_threads, threads
from sphsolid.fields import components, tensor_field, vector_field
from sphsolid.geometry import Box
from sphsolid.scenes import Scene
from sphsolid.scheme.lattice_operator import LatticeSums, operator_on
from sphsolid.scheme.pair_sums import PairSums

SIDES = [(1.0, 1.0, 1.0), (0.25, 0.5, 1.5), (0.5, 1.5, 0.25), (1.25, 0.25, 0.25)]


def both(order: int, sides: tuple[float, float, float]) -> tuple[LatticeSums, PairSums]:
    scene = Scene(
        name="box", body=Box(upper=sides), end_time=1.0,
        material=sph.NeoHookean(
            density=1e3, mu=4e5, kappa=9e5
        ),
    )  # fmt: skip
    sim = sph.Simulation(scene, spacing=0.125, operator=sph.LatticeDifference(order=order))
    made = operator_on(sim.cloud)
    assert isinstance(made, LatticeSums)
    return made, PairSums(sim.cloud)


def same(a: np.ndarray, b: np.ndarray) -> None:
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * np.max(np.abs(b)))


@pytest.mark.parametrize("order", [2, 4, 6])
@pytest.mark.parametrize("sides", SIDES)
def test_gradient_and_divergence_are_those_of_the_pairs(order, sides):
    lines, pairs = both(order, sides)
    random = np.random.default_rng(order)
    f, P = vector_field(lines.size), tensor_field(lines.size)
    # Kernels of whole tiles leave anything beside the last particle.
    components(f)[:] = components(P)[:] = np.nan
    f[:], P[:] = random.normal(size=f.shape), random.normal(size=P.shape)
    for name in ("gradient", "force_gradient"):
        found, expected = tensor_field(lines.size), tensor_field(lines.size)
        getattr(lines, name)(f, 0.7, found)
        getattr(pairs, name)(f, 0.7, expected)
        same(found, expected)
    found, expected = vector_field(lines.size), vector_field(lines.size)
    lines.internal_force(P, found)
    pairs.internal_force(P, expected)
    same(found, expected)


def test_an_entry_of_the_stress_acts_in_its_own_direction():
    """Planted: rows and columns of the stress exchanged must be seen."""
    lines, pairs = both(4, SIDES[1])
    P = tensor_field(lines.size)
    found, expected = vector_field(lines.size), vector_field(lines.size)
    P[:, 0, 1] = np.random.default_rng(0).normal(size=lines.size)
    lines.internal_force(P, found)
    pairs.internal_force(P, expected)
    same(found, expected)
    assert np.all(found[:, 1:] == 0.0)
    assert np.max(np.abs(found[:, 0])) > 0.0


def test_arrays_that_are_no_fields_and_rooms_of_the_wrong_length():
    lines, pairs = both(2, SIDES[0])
    f = np.random.default_rng(1).normal(size=(lines.size, 3))
    found, expected = np.zeros((lines.size, 3, 3)), np.zeros((lines.size, 3, 3))
    lines.gradient(f, 2.0, found)
    pairs.gradient(f, 2.0, expected)
    same(found, expected)
    with pytest.raises(ValueError, match="room for 5 particles"):
        lines.gradient(f, 1.0, np.zeros((5, 3, 3)))


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one thread")
def test_bits_do_not_depend_on_threads():
    lines, _ = both(4, SIDES[1])
    f, P = vector_field(lines.size), tensor_field(lines.size)
    f[:] = np.random.default_rng(2).normal(size=f.shape)
    P[:] = np.random.default_rng(3).normal(size=P.shape)
    before, found = threads(), []
    for count in (1, 2):
        set_threads(count)
        out, force = tensor_field(lines.size), vector_field(lines.size)
        lines.gradient(f, 1.0, out)
        lines.internal_force(P, force)
        found.append((out, force))
    set_threads(before)
    for one, two in zip(*found, strict=True):
        np.testing.assert_array_equal(one, two)
