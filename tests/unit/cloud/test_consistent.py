"""The consistent gradient: C0, C1 and D0 at once, by the smallest change there is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud import Cloud, build_cloud, consistency_report
from sphsolid.cloud.consistent import divergence_defect, least_change
from sphsolid.cloud.divergence_system import DivergenceSystem
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.errors import InputError
from sphsolid.geometry.integrals import layers_from_boundary
from sphsolid.scenes import Box
from tests.oracles.dense import dense

Array = NDArray[np.float64]
MakeCloud = Callable[..., Cloud]
VOLUME = 0.96


def residuals(cloud: Cloud, G: Array) -> tuple[float, float, float]:
    """C0, C1 and D0 by dense sums, each dimensionless: the checker, not the package's report."""
    dense_G = dense(cloud.pairs, G, cloud.size)  # [b, a]
    C0 = np.abs(np.sum(dense_G, axis=1)).max() * cloud.spacing
    C1 = np.abs(np.einsum("ai,bak->bik", cloud.X, dense_G) - np.eye(3)).max()
    D0 = np.abs(np.einsum("b,bak->ak", cloud.V, dense_G) - cloud.areas).max()
    return float(C0), float(C1), float(D0 / np.max(np.linalg.norm(cloud.areas, axis=1)))


@pytest.mark.parametrize("kind", ["corrected_kernel", "linear_kernel"])
@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_all_three_identities_hold(make_cloud: MakeCloud, jitter: float, kind: Any) -> None:
    cloud = make_cloud(jitter=jitter, operator=sph.Consistent(gradient=kind))
    assert cloud.gradients.is_adjoint
    assert max(residuals(cloud, cloud.gradients.force)) < 1e-11


@pytest.mark.parametrize("h_over_dx", [0.75, 0.9, 1.0, 1.05, 1.2, 1.6])
@pytest.mark.parametrize("spacing", [0.2, 0.1])
def test_they_hold_on_a_lattice_at_any_support(
    make_cloud: MakeCloud, spacing: float, h_over_dx: float
) -> None:
    """Wider supports reach further in: the band that may change has to follow."""
    cloud = make_cloud(operator=sph.Consistent(), h_over_dx=h_over_dx, spacing=spacing)
    report = consistency_report(cloud, VOLUME)
    assert max(report.C0, report.C1, report.D0) < 1e-11


def test_they_hold_for_a_longer_smoothing_function(make_cloud: MakeCloud) -> None:
    cloud = make_cloud(operator=sph.Consistent(), smoothing=sph.QuinticSpline(), spacing=0.1)
    assert consistency_report(cloud, VOLUME).D0 < 1e-11


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_they_hold_for_any_weight(make_cloud: MakeCloud, exponent: float) -> None:
    operator = sph.Consistent(weight_exponent=exponent)
    assert consistency_report(make_cloud(jitter=0.2, operator=operator), VOLUME).D0 < 1e-11


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_the_literal_operator_violates_the_divergence_theorem(
    make_cloud: MakeCloud, jitter: float
) -> None:
    """By a fixed share of the boundary area that refinement does not cure."""
    for spacing in (0.2, 0.1):
        cloud = make_cloud(jitter=jitter, spacing=spacing)
        C0, C1, D0 = residuals(cloud, cloud.gradients.force)
        assert max(C0, C1) < 1e-11
        assert D0 > 0.1


def test_use_force_leaves_the_kinematics_as_printed(make_cloud: MakeCloud) -> None:
    literal = make_cloud(jitter=0.2).gradients
    force_only = make_cloud(jitter=0.2, operator=sph.Consistent(use="force")).gradients
    everywhere = make_cloud(jitter=0.2, operator=sph.Consistent()).gradients
    np.testing.assert_array_equal(force_only.kinematic, literal.kinematic)
    np.testing.assert_array_equal(force_only.force, everywhere.force)
    assert not force_only.is_adjoint
    assert np.max(np.abs(force_only.force - literal.force)) > 1e-2 * np.max(np.abs(literal.force))


def test_the_divergence_is_the_adjoint_of_the_force_gradient(make_cloud: MakeCloud) -> None:
    """``V_a g_ab = V_b G_a(X_b)`` entry by entry."""
    cloud = make_cloud(jitter=0.2, operator=sph.Consistent(use="force"))
    g = dense(cloud.pairs, cloud.divergence, cloud.size)
    G = dense(cloud.pairs, cloud.gradients.force, cloud.size)
    expected = np.swapaxes(cloud.V[:, None, None] * G, 0, 1) / cloud.V[:, None, None]
    np.testing.assert_allclose(g, expected, atol=1e-12 * np.max(np.abs(G)))


def changed_layers(cloud: Cloud, literal: Cloud) -> int:
    """The deepest layer of a particle in any pair that changed."""
    layer = layers_from_boundary(cloud.mesh)
    changed = np.any(cloud.gradients.force != literal.gradients.force, axis=1)
    rows, columns = cloud.pairs.row_of_pair[changed], cloud.pairs.indices[changed]
    return int(max(layer[rows].max(), layer[columns].max()))


@pytest.mark.parametrize(("h_over_dx", "deepest"), [(0.75, 2), (0.9, 2), (1.2, 4)])
def test_on_a_lattice_the_change_stays_at_the_boundary(
    make_cloud: MakeCloud, h_over_dx: float, deepest: int
) -> None:
    options = {"spacing": 0.08, "h_over_dx": h_over_dx}
    cloud, literal = make_cloud(operator=sph.Consistent(), **options), make_cloud(**options)
    assert layers_from_boundary(cloud.mesh).max() == 5
    assert changed_layers(cloud, literal) == deepest
    # The defect of the literal operator is what asks for that depth.
    defect = divergence_defect(literal.gradients.force, literal.pairs, literal.V, literal.areas)
    wrong = np.max(np.abs(defect), axis=1) > 1e-12 * np.max(np.abs(literal.areas))
    assert layers_from_boundary(cloud.mesh)[wrong].max() == deepest


def test_more_layers_may_be_asked_for(make_cloud: MakeCloud) -> None:
    wide = make_cloud(spacing=0.08, operator=sph.Consistent(layers=4))
    assert changed_layers(wide, make_cloud(spacing=0.08)) == 4
    assert consistency_report(wide, VOLUME).D0 < 1e-11


def constraints(pairs: PairList, X: Array, V: Array) -> Array:
    """Rows of C0, C1 and D0 acting on one Cartesian component of a change ``(P,)``."""
    n, P = len(X), pairs.pairs
    row, column = pairs.row_of_pair, pairs.indices.astype(int)
    A = np.zeros((5 * n, P))
    A[row, np.arange(P)] = 1.0
    for d in range(3):
        A[(d + 1) * n + row, np.arange(P)] = (X[column] - X[row])[:, d]
    A[4 * n + column, np.arange(P)] = V[row]
    return A


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_no_other_change_that_works_is_smaller(make_cloud: MakeCloud, jitter: float) -> None:
    """Random directions that keep C0, C1 and D0 only add to ``sum |D|^2 / w``."""
    cloud = make_cloud(jitter=jitter, spacing=0.4, h_over_dx=0.9)
    distance = np.linalg.norm(
        cloud.X[cloud.pairs.indices] - cloud.X[cloud.pairs.row_of_pair], axis=1
    )
    w = np.sqrt(cloud.smoothing.value(distance, cloud.h) / cloud.smoothing.value(0.0, cloud.h))
    G = cloud.gradients.force
    D = least_change(G, cloud.pairs, cloud.X, cloud.V, cloud.areas, w).D
    assert max(residuals(cloud, G + D)) < 1e-11
    A = constraints(cloud.pairs, cloud.X, cloud.V)
    A /= np.linalg.norm(A, axis=1, keepdims=True)
    size = np.sum(D**2 / w[:, None])
    directions = np.random.default_rng(12).normal(size=(len(D), 9))
    directions -= np.linalg.lstsq(A, A @ directions, rcond=1e-12)[0]
    assert np.max(np.abs(A @ directions)) < 1e-10
    for free in np.hsplit(directions, 3):
        assert np.linalg.norm(free) > 1.0  # the constraints leave room
        work = np.sum(D * free / w[:, None])
        scale = np.sqrt(size * np.sum(free**2 / w[:, None]))
        assert abs(work) < 1e-9 * scale
        for step in (-0.1, 0.1):
            other = D + step * np.linalg.norm(D) / np.linalg.norm(free) * free
            assert np.sum(other**2 / w[:, None]) > size


def test_the_system_is_symmetric_semidefinite_and_its_diagonal_is_known(
    make_cloud: MakeCloud,
) -> None:
    """``S`` applied to every unit vector: what conjugate gradients and their scaling rest on."""
    cloud = make_cloud(jitter=0.2, spacing=0.4)
    rest = cloud.X[cloud.pairs.indices] - cloud.X[cloud.pairs.row_of_pair]
    w = np.sqrt(cloud.smoothing.value(np.linalg.norm(rest, axis=1), cloud.h))
    system = DivergenceSystem(cloud.pairs, cloud.X, cloud.V, w, cloud.spacing, coarse=False)
    S = np.empty((cloud.size, cloud.size))
    for a in range(cloud.size):
        unit = np.zeros((cloud.size, 3))
        unit[a] = 1.0
        S[:, a] = system.apply(unit)[:, 1]
    size = np.max(np.abs(S))
    np.testing.assert_allclose(S, S.T, atol=1e-13 * size)
    np.testing.assert_allclose(system.diagonal(), np.diagonal(S), atol=1e-13 * size)
    values = np.linalg.eigvalsh(S)
    assert values[0] > -1e-13 * size
    # Null space: constants and linears, and nothing else.
    assert np.count_nonzero(values < 1e-10 * values[-1]) == 4
    null = np.concatenate([np.ones((cloud.size, 1)), cloud.X], axis=1)
    np.testing.assert_allclose(S @ null, 0.0, atol=1e-13 * size)


@pytest.mark.parametrize("upper", [(1.0, 1.0, 1.0), (0.4, 1.6, 0.7), (1.2, 0.3, 1.2)])
def test_a_coarse_solution_gives_the_same_change_in_fewer_iterations(
    upper: tuple[float, float, float],
) -> None:
    mesh = Box(upper=upper, jitter=0.3, seed=3).mesh(0.1)
    cloud = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=sph.Literal("linear_kernel")
    )
    rest = cloud.X[cloud.pairs.indices] - cloud.X[cloud.pairs.row_of_pair]
    w = np.sqrt(cloud.smoothing.value(np.linalg.norm(rest, axis=1), cloud.h))
    G = cloud.gradients.force
    plain, quick = (
        least_change(G, cloud.pairs, cloud.X, cloud.V, cloud.areas, w, coarse=coarse)
        for coarse in (False, True)
    )
    size = np.max(np.abs(plain.D))
    np.testing.assert_allclose(quick.D, plain.D, atol=1e-8 * size)
    assert quick.remainder <= 1e-13
    assert quick.iterations <= 0.25 * plain.iterations


def test_a_body_too_thin_for_its_support_is_refused() -> None:
    """A bar of one cell across at the smallest support: fewer pairs than constraints."""
    mesh = Box(upper=(0.2, 0.2, 1.0), jitter=0.2).mesh(0.2)
    build_cloud(mesh, smoothing=sph.WendlandC2(), h_over_dx=0.55, operator=sph.Literal())
    with pytest.raises(InputError, match=r"no consistent gradient .* change h_over_dx"):
        build_cloud(mesh, smoothing=sph.WendlandC2(), h_over_dx=0.55, operator=sph.Consistent())
    wider = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=0.75, operator=sph.Consistent()
    )
    assert consistency_report(wider, 0.04).D0 < 1e-11


def test_the_report_says_what_the_residuals_are(make_cloud: MakeCloud) -> None:
    literal = make_cloud(jitter=0.2)
    report = consistency_report(literal, 1.01 * VOLUME)
    found = residuals(literal, literal.gradients.force)
    assert found[2] == pytest.approx(report.D0, rel=1e-9)
    assert report.volume == pytest.approx(1.0 - 1.0 / 1.01, rel=1e-9)
    # A planted error of one pair shows in all three.
    cloud = make_cloud(jitter=0.2, operator=sph.Consistent())
    cloud.force.coefficient[:, 17] += 0.1 / cloud.spacing
    spoilt = consistency_report(cloud, VOLUME)
    assert abs(spoilt.C0 - 0.1) < 1e-9
    assert spoilt.C1 > 0.01
    assert spoilt.D0 > 0.01


@pytest.mark.parametrize(
    "options", [{"use": "both"}, {"layers": 0}, {"weight_exponent": -1.0}, {"gradient": "fd"}]
)
def test_a_wrong_option_is_refused(make_cloud: MakeCloud, options: Any) -> None:
    with pytest.raises(InputError, match=str(next(iter(options.values())))):
        make_cloud(operator=sph.Consistent(**options))
