"""Constitutive laws against what they do not contain: derivatives of the energy, objectivity,
linear elasticity, convexity.  The checkers are themselves checked with planted errors.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest

from sphsolid.compiled import serial_kernel
from sphsolid.continuum import MooneyRivlin, NeoHookean, SaintVenantKirchhoff, law
from sphsolid.continuum.moduli import bulk_modulus, check_elastic, first_lame, shear_modulus
from sphsolid.continuum.tensor import (
    add,
    axpy,
    cofactor,
    contract,
    cross,
    determinant,
    join,
    load,
    scale,
    split,
    store,
)
from sphsolid.errors import InputError

STEP = 1e-30


def energy_of(material, F):
    """``W(F, cof F, det F)`` for ``F (n, 3, 3)``, real or complex."""
    entries = split(F)
    return law.energy(material, entries, cofactor(entries), determinant(entries))


def stress_of(material, F):
    entries = split(F)
    return join(law.first_piola(material, entries, cofactor(entries), determinant(entries)))


def directions():
    for i in range(3):
        for k in range(3):
            E = np.zeros((3, 3))
            E[i, k] = 1.0
            yield i, k, E


def stress_by_complex_step(material, F):
    P = np.empty(F.shape)
    for i, k, E in directions():
        P[:, i, k] = np.imag(energy_of(material, F + 1j * STEP * E)) / STEP
    return P


def stress_defect(material, F, stress=stress_of):
    """Largest difference between a stress and the derivative of the energy, relative to it."""
    exact = stress_by_complex_step(material, F)
    size = np.max(np.abs(exact), axis=(1, 2), keepdims=True)
    return float(np.max(np.abs(stress(material, F) - exact) / size))


def test_stress_is_the_derivative_of_the_energy(material, deformations):
    assert stress_defect(material, deformations) < 1e-13 * (1.0 + material.kappa / material.mu)


@pytest.mark.parametrize(
    "planted",
    [
        lambda S_F, S_H, S_J, F, H: scale(-1.0, axpy(S_J, H, add(S_F, cross(S_H, F)))),
        lambda S_F, S_H, S_J, F, H: axpy(-S_J, H, add(S_F, cross(S_H, F))),
        lambda S_F, S_H, S_J, F, H: axpy(S_J, H, add(S_F, scale(-1.0, cross(S_H, F)))),
        lambda S_F, S_H, S_J, F, H: axpy(S_J, F, add(S_F, cross(S_H, F))),
        lambda S_F, S_H, S_J, F, H: axpy(S_J, H, add(S_F, S_H)),
    ],
    ids=["-P", "-Sigma_J", "-Sigma_H", "F for H", "no cross product"],
)
def test_a_planted_error_in_the_stress_is_caught(deformations, planted):
    material = MooneyRivlin.from_young(
        young_modulus=17e6, poisson_ratio=0.3, density=1100.0, cofactor_share=0.5
    )

    def wrong(material, F):
        entries = split(F)
        H, J = cofactor(entries), determinant(entries)
        conjugate = law.conjugate_stresses(material, entries, H, J)
        return join(planted(*conjugate, entries, H))

    assert stress_defect(material, deformations) < 1e-12
    assert stress_defect(material, deformations, wrong) > 1e-2


def test_conjugate_stresses_are_partial_derivatives(material, deformations):
    """With ``F, H, J`` independent: ``H`` is not the cofactor of ``F`` here."""
    rng = np.random.default_rng(1)
    F = deformations
    H, J = F + 0.1 * rng.normal(size=F.shape), rng.uniform(0.5, 1.5, len(F))
    Sigma_F, Sigma_H, Sigma_J = law.conjugate_stresses(material, split(F), split(H), J)
    scale_ = material.mu + material.kappa
    for i, k, E in directions():
        by_F = np.imag(law.energy(material, split(F + 1j * STEP * E), split(H), J)) / STEP
        by_H = np.imag(law.energy(material, split(F), split(H + 1j * STEP * E), J)) / STEP
        np.testing.assert_allclose(join(Sigma_F)[:, i, k], by_F, atol=1e-13 * scale_)
        np.testing.assert_allclose(join(Sigma_H)[:, i, k], by_H, atol=1e-13 * scale_)
    by_J = np.imag(law.energy(material, split(F), split(H), J + 1j * STEP)) / STEP
    np.testing.assert_allclose(Sigma_J, by_J, atol=1e-12 * scale_)


def random_state(F, seed):
    rng = np.random.default_rng(seed)
    H = np.swapaxes(np.linalg.inv(F), 1, 2) + 0.1 * rng.normal(size=F.shape)
    J = rng.uniform(0.5, 1.5, len(F))
    increments = rng.normal(size=F.shape), rng.normal(size=F.shape), rng.normal(size=len(F))
    return split(H), J, split(increments[0]), split(increments[1]), increments[2]


def test_hessian_is_the_derivative_of_the_conjugate_stresses(material, deformations):
    F = split(deformations)
    H, J, dF, dH, dJ = random_state(deformations, 2)
    mine = law.hessian_action(material, F, H, J, dF, dH, dJ)
    moved = law.conjugate_stresses(
        material, axpy(1j * STEP, dF, F), axpy(1j * STEP, dH, H), J + 1j * STEP * dJ
    )
    atol = 1e-12 * (material.mu + material.kappa)
    for part, exact in zip(mine, moved, strict=True):
        part, exact = (join(v) if isinstance(v, tuple) else v for v in (part, exact))
        np.testing.assert_allclose(part, np.imag(exact) / STEP, rtol=1e-12, atol=atol)


def test_hessian_is_symmetric(material, deformations):
    F = split(deformations)
    H, J, aF, aH, aJ = random_state(deformations, 3)
    _, _, bF, bH, bJ = random_state(deformations, 4)

    def form(xF, xH, xJ, yF, yH, yJ):
        sF, sH, sJ = law.hessian_action(material, F, H, J, xF, xH, xJ)
        return contract(sF, yF) + contract(sH, yH) + sJ * yJ

    ab, ba = form(aF, aH, aJ, bF, bH, bJ), form(bF, bH, bJ, aF, aH, aJ)
    np.testing.assert_allclose(ab, ba, atol=1e-12 * np.max(np.abs(ab)))


def hessian_matrix(material, F, H, J):
    """``(19, 19)`` in the order F, H, J."""
    columns = []
    for k in range(19):
        unit = np.zeros(19)
        unit[k] = 1.0
        sF, sH, sJ = law.hessian_action(
            material, F, H, J, tuple(unit[:9]), tuple(unit[9:18]), unit[18]
        )
        columns.append([*sF, *sH, sJ])
    return np.array(columns, dtype=float)


def test_energy_is_convex_in_F_H_J(polyconvex, deformations):
    """Polyconvexity, at the identity and at random states; H counts only where W has it."""
    active = np.r_[0:9, 9:18, 18] if polyconvex.depends_on_H else np.r_[0:9, 18]
    if isinstance(polyconvex, MooneyRivlin) and polyconvex.varsigma == 0.0:
        active = np.r_[9:18, 18]
    for F in [np.eye(3), *deformations[:10]]:
        entries = tuple(F.ravel())
        matrix = hessian_matrix(polyconvex, entries, cofactor(entries), determinant(entries))
        values = np.linalg.eigvalsh(matrix[np.ix_(active, active)])
        assert values[0] > 1e-3 * polyconvex.mu


def test_energy_and_stress_are_objective(material, deformations, rotations):
    rotated = rotations @ deformations
    np.testing.assert_allclose(
        energy_of(material, rotated), energy_of(material, deformations), rtol=1e-12
    )
    stress = stress_of(material, deformations)
    # The spherical part cancels against the rest near incompressibility: compare with its size.
    atol = 1e-13 * (material.mu + material.kappa)
    np.testing.assert_allclose(stress_of(material, rotated), rotations @ stress, atol=10 * atol)
    # ... hence P F^T is symmetric: no spurious torque.
    kirchhoff = stress @ np.swapaxes(deformations, 1, 2)
    np.testing.assert_allclose(kirchhoff, np.swapaxes(kirchhoff, 1, 2), atol=20 * atol)


def test_undeformed_body_is_free_of_stress(material):
    np.testing.assert_allclose(stress_of(material, np.eye(3)[None]), 0.0, atol=1e-9 * material.mu)


def test_stress_is_positive_in_tension(material):
    grown = 1.001 * np.eye(3)[None]
    assert np.all(np.diagonal(stress_of(material, grown)[0]) > 0.0)


def tangent_defect(material, F, dF):
    mine = join(law.tangent_action(material, split(F), split(dF)))
    moved = split(F + 1j * STEP * dF)
    exact = join(law.first_piola(material, moved, cofactor(moved), determinant(moved)))
    size = np.max(np.abs(mine), axis=(1, 2), keepdims=True)
    return float(np.max(np.abs(mine - np.imag(exact) / STEP) / size))


def test_tangent_is_the_derivative_of_the_stress(material, deformations):
    dF = np.random.default_rng(5).normal(size=deformations.shape)
    assert tangent_defect(material, deformations, dF) < 1e-12


def test_small_strains_are_linear_elasticity(material):
    """``dP = lambda tr(e) I + 2 mu e`` with the moduli of E and nu, whatever the law."""
    gradient = np.random.default_rng(6).normal(size=(20, 3, 3))
    strain = 0.5 * (gradient + np.swapaxes(gradient, 1, 2))
    lam = first_lame(material.mu, material.kappa)
    exact = lam * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    exact = exact + 2.0 * material.mu * strain
    identity = split(np.broadcast_to(np.eye(3), gradient.shape))
    mine = join(law.tangent_action(material, identity, split(gradient)))
    np.testing.assert_allclose(mine, exact, atol=1e-12 * np.max(np.abs(exact)))


def test_neo_hookean_is_mooney_rivlin_without_cofactor_term(deformations):
    values = {"young_modulus": 17e6, "poisson_ratio": 0.3, "density": 1100.0}
    simple = NeoHookean.from_young(**values)
    general = MooneyRivlin.from_young(**values, cofactor_share=0.0)
    assert general.varsigma == simple.mu / 2.0
    assert not general.depends_on_H
    assert not simple.depends_on_H
    np.testing.assert_allclose(
        stress_of(simple, deformations), stress_of(general, deformations), rtol=1e-12, atol=1e-6
    )


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_shear_modulus_is_shared_out(share):
    values = {"young_modulus": 17e6, "poisson_ratio": 0.3, "density": 1100.0}
    m = MooneyRivlin.from_young(**values, cofactor_share=share)
    mu = shear_modulus(17e6, 0.3)
    assert 2.0 * m.varsigma + 3.0 * math.sqrt(3.0) * m.xi == pytest.approx(mu, rel=1e-15)
    assert m.mu == pytest.approx(mu, rel=1e-15)
    assert m.kappa == bulk_modulus(17e6, 0.3)
    assert m.depends_on_H == (share > 0.0)


@pytest.mark.parametrize(
    ("young_modulus", "poisson_ratio", "density", "named"),
    [
        (0.0, 0.3, 1.0, "young_modulus"),
        (math.nan, 0.3, 1.0, "young_modulus"),
        (1.0, 0.5, 1.0, "0.499"),
        (1.0, -1.0, 1.0, "poisson_ratio"),
        (1.0, math.nan, 1.0, "poisson_ratio"),
        (1.0, 0.3, -1.0, "density"),
        (1.0, 0.3, math.inf, "density"),
    ],
)
def test_bad_constants_are_refused(young_modulus, poisson_ratio, density, named):
    values = {"young_modulus": young_modulus, "poisson_ratio": poisson_ratio, "density": density}
    for make in (
        lambda: check_elastic(young_modulus, poisson_ratio, density),
        lambda: NeoHookean.from_young(**values),
        lambda: MooneyRivlin.from_young(**values, cofactor_share=0.5),
    ):
        with pytest.raises(InputError, match=named):
            make()


@pytest.mark.parametrize(
    "make",
    [
        NeoHookean.from_young,
        SaintVenantKirchhoff.from_young,
        partial(MooneyRivlin.from_young, cofactor_share=0.5),
    ],
)
@pytest.mark.parametrize("wrong", ["1e6", (1e6,), None, True, [1.0], 1j, np.ones(2), 10**400])
@pytest.mark.parametrize("name", ["young_modulus", "poisson_ratio", "density"])
def test_what_is_no_number_is_refused_by_its_name(make, name, wrong):
    values = {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0, name: wrong}
    with pytest.raises(InputError, match=rf"^{name} = .* (is not a number|must be finite)"):
        make(**values)


def test_all_laws_have_the_same_moduli():
    values = {"young_modulus": 17e6, "poisson_ratio": 0.45, "density": 1100}
    mu, kappa = 17e6 / (2.0 * 1.45), 17e6 / (3.0 * (1.0 - 0.9))
    assert NeoHookean.from_young(**values) == (mu, kappa, 1100.0)
    assert SaintVenantKirchhoff.from_young(**values) == (mu, kappa, 1100.0)
    general = MooneyRivlin.from_young(**values, cofactor_share=0.25)
    assert general == (0.375 * mu, 0.25 * mu / (3.0 * math.sqrt(3.0)), kappa, 1100.0)


@pytest.mark.parametrize("share", [-0.1, 1.1, math.nan, "0.5", None, (0.5,)])
def test_bad_share_is_refused(share):
    with pytest.raises(InputError, match="cofactor_share"):
        MooneyRivlin.from_young(
            young_modulus=1.0, poisson_ratio=0.3, density=1.0, cofactor_share=share
        )


@serial_kernel
def _compiled(material, F, dF, P, dP):
    for a in range(len(F)):
        F_a = load(F, a)
        store(law.first_piola(material, F_a, cofactor(F_a), determinant(F_a)), P, a)
        store(law.tangent_action(material, F_a, load(dF, a)), dP, a)


@pytest.mark.parametrize("kind", ["neo-Hookean", "Mooney-Rivlin"])
def test_a_kernel_finds_the_law_by_the_type_of_its_parameters(kind, deformations):
    values = {"young_modulus": 17e6, "poisson_ratio": 0.3, "density": 1100.0}
    material = (
        NeoHookean.from_young(**values)
        if kind == "neo-Hookean"
        else MooneyRivlin.from_young(**values, cofactor_share=0.5)
    )
    dF = np.random.default_rng(9).normal(size=deformations.shape)
    P, dP = np.empty_like(deformations), np.empty_like(deformations)
    _compiled(material, deformations, dF, P, dP)
    np.testing.assert_allclose(P, stress_of(material, deformations), rtol=1e-12, atol=1e-6)
    exact = join(law.tangent_action(material, split(deformations), split(dF)))
    np.testing.assert_allclose(dP, exact, rtol=1e-11, atol=1e-6)
