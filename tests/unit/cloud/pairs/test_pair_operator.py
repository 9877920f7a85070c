"""Stencils, own values and exceptions: three ways to store one and the same sum."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud.cloud import build_cloud, build_secondary
from sphsolid.cloud.pairs.pair_operator import PairOperator, expanded
from sphsolid.compiled import set_threads, threads
from sphsolid.fields import as_field, components, tensor_field, vector_field
from sphsolid.scenes import Box
from sphsolid.scenes.l_shaped_block import l_shaped_block
from sphsolid.scheme import fine_scale, galerkin
from sphsolid.scheme.tile import make_scratch

RANDOM = np.random.default_rng(7)
BODIES: dict[str, Any] = {
    "cube": (Box(), 1 / 20, 0.77),
    "long rows": (Box(upper=(0.6, 0.6, 6.0)), 0.075, 0.77),
    "wide support": (Box(), 1 / 12, 1.0),
    "L": (l_shaped_block().body, 0.375, 0.77),
    "jitter": (Box(jitter=0.2, seed=3), 1 / 10, 0.9),
}


def operators(name: str, *, stencils: bool) -> dict[str, PairOperator]:
    body, spacing, h = BODIES[name]
    cloud = build_cloud(
        body.mesh(spacing), smoothing=sph.WendlandC2(), h_over_dx=h, operator=sph.Consistent(),
        stencils=stencils,
    )  # fmt: skip
    q = build_secondary(cloud, sph.H1(), adjoint_weight=True, stencils=stencils)
    return {
        "kinematic": cloud.kinematic, "adjoint": cloud.adjoint, "sampling": q.sampling,
        "spreading": q.spreading,
    }  # fmt: skip


@pytest.mark.parametrize("name", BODIES)
def test_what_is_stored_is_what_was_given(name: str) -> None:
    """Same pairs, same coefficients to 1e-12 of the largest; exactly, where nothing repeats."""
    compact, plain = (operators(name, stencils=kind) for kind in (True, False))
    for key, operator in compact.items():
        pairs, values = expanded(operator)
        all_pairs, all_values = expanded(plain[key])
        np.testing.assert_array_equal(pairs.indptr, all_pairs.indptr)
        np.testing.assert_array_equal(pairs.indices, all_pairs.indices)
        size = np.max(np.abs(all_values), axis=0)
        assert np.max(np.abs(values - all_values) / size) < 1e-12
        assert operator.mean_neighbours == pytest.approx(all_pairs.mean_neighbours, rel=1e-14)
        assert plain[key].stencil_share == 0.0
        if name == "jitter":
            np.testing.assert_array_equal(values, all_values)


def test_runs_serve_most_of_a_lattice_and_nothing_of_another_cloud() -> None:
    share = {name: operators(name, stencils=True)["kinematic"].stencil_share for name in BODIES}
    assert share["long rows"] > 0.8
    assert share["cube"] > 0.6
    assert share["jitter"] == 0.0
    lattice = operators("long rows", stencils=True)["kinematic"]
    # Shared stencils inside, own values in whole rows near the boundary: both are there.
    assert np.any(lattice.stencil < lattice.stencils)
    assert np.any(lattice.stencil >= lattice.stencils)


@pytest.mark.parametrize("name", BODIES)
def test_every_sum_is_that_of_the_pairs(name: str) -> None:
    """Gradient, divergence and the adjoint interpolation, against sums written with numpy."""
    A = operators(name, stencils=True)
    scratch = make_scratch()
    n, m = A["kinematic"].rows, A["sampling"].rows
    f, T, Q = (RANDOM.normal(size=shape) for shape in ((n, 3), (n, 3, 3), (m, 3, 3)))
    f_rows, T_rows, Q_rows = (components(as_field(a)) for a in (f, T, Q))

    def summed(operator: PairOperator, terms: Any) -> Any:
        pairs, values = expanded(operator)
        return np.add.reduceat(terms(values, pairs.indices), pairs.indptr[:-1], axis=0)

    gradient = tensor_field(n)
    galerkin.gradient(A["kinematic"], f_rows, 2.0, components(gradient), scratch)
    expected = summed(A["kinematic"], lambda c, b: 2.0 * f[b][:, :, None] * c[:, None, :])
    np.testing.assert_allclose(gradient, expected, atol=1e-12 * np.abs(expected).max())

    force = vector_field(n)
    galerkin.internal_force(A["adjoint"], T_rows, components(force), scratch)
    expected = -summed(A["adjoint"], lambda c, b: np.einsum("pij,pj->pi", T[b], c))
    np.testing.assert_allclose(force, expected, atol=1e-12 * np.abs(expected).max())

    left = tensor_field(n)
    fine_scale.subtract_back(
        A["spreading"], A["kinematic"], False, f_rows, Q_rows, components(left), scratch
    )
    expected = -summed(A["spreading"], lambda c, b: c[:, 3, None, None] * Q[b])
    np.testing.assert_allclose(left, expected, atol=1e-12 * np.abs(expected).max())


def test_both_layouts_and_any_number_of_threads_give_the_same_bits() -> None:
    A = operators("cube", stencils=False)["adjoint"]
    T = RANDOM.normal(size=(A.rows, 3, 3))
    found = []
    before = threads()
    for count in (1, before):
        set_threads(count)
        for particle_major in (False, True):
            field = tensor_field(A.rows, particle_major=particle_major)
            field[:] = T
            out = vector_field(A.rows)
            galerkin.internal_force(A, components(field), components(out), make_scratch())
            found.append(np.ascontiguousarray(out).tobytes())
    set_threads(before)
    assert len(set(found)) == 1


def test_a_planted_wrong_base_is_seen() -> None:
    A = operators("long rows", stencils=True)["kinematic"]
    f = as_field(RANDOM.normal(size=(A.rows, 3)))
    right, wrong = tensor_field(A.rows), tensor_field(A.rows)
    shifted = A._replace(base=A.base + np.uint64(1))
    for operator, out in ((A, right), (shifted, wrong)):
        galerkin.gradient(operator, components(f), 1.0, components(out), make_scratch())
    assert np.max(np.abs(right - wrong)) > 1.0
