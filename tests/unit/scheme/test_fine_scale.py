"""The fine-scale kernels against loops written straight from eqs. (22)-(28), (34) and (35)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud.pairs.neighbours import PairList, transposed
from sphsolid.cloud.pairs.pair_operator import PairOperator, pair_operators
from sphsolid.continuum import law
from sphsolid.continuum.tensor import Tensor, contract, scale
from sphsolid.fields import as_field, components, scalar_field, tensor_field, vector_field
from sphsolid.scheme import fine_scale, pressure
from sphsolid.scheme.fine_scale import Coefficients, Evolved, Forms, Matched, Rates, Simplified
from sphsolid.scheme.tile import make_scratch
from tests.oracles import numpy_sph

Array = NDArray[np.float64]
N, M, DT = 9, 7, 2.0e-4
MATERIAL = sph.MooneyRivlin.from_young(
    young_modulus=17.0e6, poisson_ratio=0.4, density=1100.0, cofactor_share=0.4
)
ORACLE = numpy_sph.MooneyRivlin(
    MATERIAL.varsigma, MATERIAL.xi, MATERIAL.kappa, MATERIAL.mu
)


class Data(NamedTuple):
    """Random fields at ``N`` particles, ``M`` points that see some of them."""

    pairs: PairList
    sample: Array
    v: Array
    x: Array
    F: Array
    H: Array
    J: Array
    Fdot: Array
    Hdot: Array
    Jdot: Array


def data() -> Data:
    """Weights sum to one and gradients to zero, so the interpolated fields are near identity."""
    random = np.random.default_rng(41)
    rows = [np.sort(random.choice(N, size=4 + q % 4, replace=False)) for q in range(M)]
    indptr = np.concatenate([[0], np.cumsum([len(row) for row in rows])])
    pairs = PairList(indptr.astype(np.int64), np.concatenate(rows).astype(np.uint32))
    sample = np.empty((pairs.pairs, 4))
    X = random.uniform(0.0, 1.0, (N, 3))
    for q in range(M):
        here = slice(indptr[q], indptr[q + 1])
        weight = random.uniform(0.5, 1.0, len(rows[q]))
        sample[here, 3] = weight / weight.sum()
        # Gradients with sum G = 0 and sum G (x) X = I, as the real ones have.
        q_matrix = np.concatenate([np.ones((len(rows[q]), 1)), X[rows[q]]], axis=1)
        sample[here, :3] = np.linalg.pinv(q_matrix)[1:].T
    near = np.broadcast_to(np.eye(3), (N, 3, 3))

    def noise(*shape: int) -> Array:
        return random.uniform(-1.0, 1.0, shape)

    return Data(
        pairs, sample, 30.0 * noise(N, 3), X + 0.05 * noise(N, 3), near + 0.1 * noise(N, 3, 3),
        near + 0.1 * noise(N, 3, 3), 1.0 + 0.1 * noise(N), 100.0 * noise(N, 3, 3),
        100.0 * noise(N, 3, 3), 100.0 * noise(N),
    )  # fmt: skip


def operator(pairs: PairList, values: Array, columns: int) -> PairOperator:
    """Values of pairs as a kernel wants them."""
    return pair_operators(pairs, [values], columns)[0]


def rows(*fields: Array) -> list[Array]:
    """Fields as a kernel wants them."""
    return [components(as_field(field)) for field in fields]


def interpolated(d: Data, q: int, field: Array) -> Array:
    """``sum_a V_a W~_a(X_q) f_a``, one by one."""
    total = np.zeros(field.shape[1:])
    for k in range(d.pairs.indptr[q], d.pairs.indptr[q + 1]):
        total = total + d.sample[k, 3] * field[d.pairs.indices[k]]
    return total


def gradient(d: Data, q: int, field: Array) -> Array:
    """``sum_a f_a (x) G_a(X_q)``, one by one."""
    total = np.zeros((3, 3))
    for k in range(d.pairs.indptr[q], d.pairs.indptr[q + 1]):
        total += np.outer(field[d.pairs.indices[k]], d.sample[k, :3])
    return total


def expected(d: Data, options: numpy_sph.Options, projects: bool) -> tuple[Array, Array]:
    """``P_fine`` and ``F_x`` at every point."""
    fine, F_x = np.empty((M, 3, 3)), np.empty((M, 3, 3))
    for q in range(M):
        F_x[q] = gradient(d, q, d.x)
        at_q = [interpolated(d, q, f)[None] for f in (d.F, d.H, d.J)]
        rate = [interpolated(d, q, f)[None] for f in (d.Fdot, d.Hdot, d.Jdot)]
        fine[q] = numpy_sph.fine_stress(
            ORACLE, options, DT, gradient(d, q, d.v)[None], F_x[q][None],
            numpy_sph.Fields(d.v, d.x, *at_q), numpy_sph.Fields(d.v, d.x, *rate),
        )[0]  # fmt: skip
    return (numpy_sph.project(fine, F_x) if projects else fine), F_x


@pytest.mark.parametrize("projects", [False, True])
def test_the_simplified_kernel_is_eq_27(projects: bool) -> None:
    d = data()
    tau_gamma, xi_alpha = 0.7 * DT * MATERIAL.kappa, 0.2 * MATERIAL.mu
    fine, F_x = tensor_field(M), tensor_field(M)
    density = 2.0
    fine_scale.simplified(
        operator(d.pairs, d.sample, N), Simplified(density, tau_gamma, xi_alpha, True), projects,
        Matched(*rows(density * d.v, d.x, d.F, d.Fdot)), *rows(fine, F_x), make_scratch(),
    )  # fmt: skip
    options = numpy_sph.Options("F", "simplified", tau=(0.7, 0, 0), xi=(0.2, 0, 0))
    P_fine, exact = expected(d, options, projects)
    np.testing.assert_allclose(F_x, exact, atol=1e-13)
    np.testing.assert_allclose(fine, P_fine, atol=1e-12 * np.max(np.abs(P_fine)))


def general(d: Data, material: object, options: numpy_sph.Options, projects: bool) -> Array:
    """The compiled kernel, or its Python text for a law that only this file knows."""
    compiled = isinstance(material, sph.MooneyRivlin)
    kernel = fine_scale.general if compiled else fine_scale.general.py_func
    fine, F_x = tensor_field(M), tensor_field(M)
    H, Hdot = (d.H, d.Hdot) if "H" in options.evolved else (tensor_field(0), tensor_field(0))
    J, Jdot = (d.J, d.Jdot) if "J" in options.evolved else (scalar_field(0), scalar_field(0))
    kernel(
        operator(d.pairs, d.sample, N), material, Forms(options.form == "strains", projects),
        Coefficients(*(np.array(options.tau) * DT).tolist(), *options.xi, MATERIAL.mu),
        Evolved(*rows(material.density * d.v, d.x, d.F, H, J)),
        Rates(*rows(d.Fdot, Hdot, Jdot, fine, F_x)), make_scratch(),
    )  # fmt: skip
    return fine


@pytest.mark.parametrize("projects", [False, True])
@pytest.mark.parametrize("form", ["hessian", "strains"])
@pytest.mark.parametrize("evolved", ["F", "FJ", "FHJ"])
def test_the_general_kernel_is_eqs_22_23_and_28(evolved: str, form: str, projects: bool) -> None:
    d = data()
    # Also for fields that are not evolved: then their residuals follow from those of F.
    tau = (0.7, 0.4, 0.3)
    xi = (0.2, 0.0, 0.0) if form == "hessian" else (0.2, 0.15, 0.12)
    options = numpy_sph.Options(evolved, form, tau=tau, xi=xi)
    P_fine, _ = expected(d, options, projects)
    mine = general(d, MATERIAL, options, projects)
    np.testing.assert_allclose(mine, P_fine, atol=1e-12 * np.max(np.abs(P_fine)))


class Quadratic(NamedTuple):
    """``W~ = gamma/2 F:F``, eq. (25)."""

    gamma: float
    density: float = 1.0


law.register_law(
    Quadratic,
    energy=lambda m, F, H, J: 0.5 * m.gamma * contract(F, F),
    conjugate_stresses=lambda m, F, H, J: (scale(m.gamma, F), scale(0.0, H), 0.0),
    first_piola=lambda m, F, H, J: scale(m.gamma, F),
    hessian_action=lambda m, F, H, J, dF, dH, dJ: (scale(m.gamma, dF), scale(0.0, dH), 0.0),
)


@pytest.mark.parametrize("form", ["hessian", "strains"])
def test_the_general_forms_become_the_simplified_one_for_its_own_energy(form: str) -> None:
    """(22)-(23) and (28) with (25) are (26): the simplification is the paper's, not ours."""
    d = data()
    xi = (0.2, 0.0, 0.0) if form == "hessian" else (0.2 * MATERIAL.mu / MATERIAL.kappa, 0.0, 0.0)
    options = numpy_sph.Options("FHJ", form, tau=(0.7, 0.4, 0.3), xi=xi)
    mine = general(d, law.in_kernels(Quadratic(MATERIAL.kappa)), options, True)
    simplified = numpy_sph.Options("F", "simplified", tau=(0.7, 0, 0), xi=(0.2, 0, 0))
    P_fine, _ = expected(d, simplified, True)
    np.testing.assert_allclose(mine, P_fine, atol=1e-12 * np.max(np.abs(P_fine)))


def test_residuals_of_a_consistent_state_vanish() -> None:
    """Affine motion with matching fields has no fine-scale stress in any form."""
    d = data()
    A: Tensor = tuple(np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [0.1, 0.0, 1.0]]).ravel())
    F = np.reshape(A, (3, 3))
    L = np.array([[30.0, 5.0, 0.0], [-10.0, 0.0, 4.0], [0.0, 20.0, -15.0]])
    X = np.linalg.solve(F, d.x.T).T

    def everywhere(tensor: Array) -> Array:
        return np.broadcast_to(tensor, (N, *tensor.shape)).copy()

    H = numpy_sph.cof(F[None])[0]
    Hdot = numpy_sph.cross(F[None], L[None])[0]
    # Gradients of this cloud are exact for its own X, of which x and v are linear functions.
    sample = d.sample.copy()
    for q in range(M):
        here = slice(d.pairs.indptr[q], d.pairs.indptr[q + 1])
        near = X[d.pairs.indices[here]]
        sample[here, :3] = np.linalg.pinv(np.c_[np.ones(len(near)), near])[1:].T
    matching = Data(
        d.pairs, sample, X @ L.T, d.x, everywhere(F), everywhere(H),
        np.full(N, np.linalg.det(F)), everywhere(L), everywhere(Hdot),
        np.full(N, np.sum(H * L)),
    )  # fmt: skip
    for form in ("hessian", "strains"):
        options = numpy_sph.Options("FHJ", form, tau=(0.7, 0.4, 0.3), xi=(0.2, 0.2, 0.2))
        assert np.max(np.abs(general(matching, MATERIAL, options, True))) < 1e-8 * MATERIAL.mu


def test_dissipation_kernels_are_eqs_34_and_35() -> None:
    d = data()
    random = np.random.default_rng(43)
    V, V_q = random.uniform(0.5, 1.5, N), random.uniform(0.5, 1.5, M)
    P_fine, F_x = random.normal(size=(M, 3, 3)), np.eye(3) + 0.1 * random.normal(size=(M, 3, 3))
    P, inertia = random.normal(size=(N, 3, 3)), random.normal(size=(N, 3))
    spread_pairs, place = transposed(d.pairs, N)
    ratio = V_q[d.pairs.row_of_pair] / V[d.pairs.indices]
    spread = (d.sample[:, :3] * ratio[:, None])[place]
    rate, Jdot = random.normal(size=(N, 3)), random.normal(size=N)
    D_p, D_J = rate.copy(), Jdot.copy()
    for q in range(M):
        R_p = -interpolated(d, q, inertia)
        for k in range(d.pairs.indptr[q], d.pairs.indptr[q + 1]):
            R_p = R_p + P[d.pairs.indices[k]] @ d.sample[k, :3]
        cofactor = np.linalg.det(F_x[q]) * np.linalg.inv(F_x[q]).T
        for k in range(d.pairs.indptr[q], d.pairs.indptr[q + 1]):
            a, G = d.pairs.indices[k], d.sample[k, :3]
            D_p[a] -= V_q[q] / V[a] * P_fine[q] @ G
            D_J[a] -= 0.3 * V_q[q] / V[a] * (cofactor.T @ R_p) @ G
    spreading, scratch = operator(spread_pairs, spread, M), make_scratch()
    found_p, found_J, flux = vector_field(N), scalar_field(N), vector_field(M)
    found_p[:], found_J[:] = rate, Jdot
    fine_scale.momentum_dissipation(spreading, *rows(P_fine, found_p), scratch)
    pressure.momentum_residual(
        operator(d.pairs, d.sample, N), 0.3, *rows(P, inertia, F_x, flux), scratch
    )
    pressure.volume_dissipation(spreading, *rows(flux, found_J), scratch)
    rate, Jdot = found_p, found_J
    np.testing.assert_allclose(rate, D_p, atol=1e-12)
    np.testing.assert_allclose(Jdot, D_J, atol=1e-12)
