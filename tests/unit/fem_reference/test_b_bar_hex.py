"""The Q1-P0 element against its energy, against scikit-fem's own assembly, and in rigid motion."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from skfem import Basis, ElementHex0, ElementHex1, ElementVector, LinearForm
from skfem.helpers import ddot, det, grad, inv, transpose

from fem_reference.b_bar_hex import BBarHex, BBarHexElements
from fem_reference.lanes import side_by_side
from fem_reference.mesh import scikit_fem_mesh
from sphsolid.continuum import MooneyRivlin, NeoHookean, law
from sphsolid.continuum.tensor import cofactor, determinant, split
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh
from sphsolid.run.held_bytes import held_bytes
from sphsolid.scenes import Box
from tests.oracles.hexahedra import gauss_data

Array = NDArray[Any]
ELASTIC = {"young_modulus": 17.0e6, "density": 1100.0}
RUBBER = NeoHookean.from_young(poisson_ratio=0.3, **ELASTIC)
NEARLY_INCOMPRESSIBLE = NeoHookean.from_young(poisson_ratio=0.499, **ELASTIC)
MOONEY = MooneyRivlin.from_young(poisson_ratio=0.45, cofactor_share=0.4, **ELASTIC)


def elements_of(mesh: HexMesh, material: Any) -> BBarHexElements:
    return BBarHex().discretise(mesh=mesh, sk=scikit_fem_mesh(mesh), material=material)


def deformed(mesh: HexMesh, size: float = 0.15) -> Array:
    """A stretched, turned and randomly disturbed position of every node."""
    random = np.random.default_rng(7)
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.05, 0.0, 1.05]])
    return mesh.vertices @ F.T + size * mesh.spacing * random.uniform(-1, 1, mesh.vertices.shape)


def force(elements: BBarHexElements, x: Array) -> Array:
    result = np.empty_like(x)
    elements.internal_force(x, result)
    return result


def energy(material: Any, mesh: HexMesh, x: Array, mean_dilatation: bool = True) -> Any:
    """The energy of the module text in numpy: takes complex positions too."""
    gradients, weights, _ = gauss_data(mesh.vertices[mesh.cells], CORNERS.astype(float), 2)
    F = split(np.einsum("eai,egak->egik", x[mesh.cells], gradients))
    J = determinant(F)
    W = law.energy(material, F, cofactor(F), J)
    if not mean_dilatation:
        return np.sum(weights * W)
    V = weights.sum(axis=1)
    Jbar = np.sum(weights * J, axis=1) / V
    volumetric = 0.5 * material.kappa * (J - 1.0) ** 2
    return np.sum(weights * (W - volumetric)) + np.sum(V * 0.5 * material.kappa * (Jbar - 1.0) ** 2)


def energy_gradient(material: Any, mesh: HexMesh, x: Array, **options: bool) -> Array:
    """Complex-step derivative: exact to round-off, no step size to choose."""
    gradient = np.empty_like(x)
    for a, i in np.ndindex(x.shape):
        moved = x.astype(complex)
        moved[a, i] += 1e-40j
        gradient[a, i] = energy(material, mesh, moved, **options).imag / 1e-40
    return gradient


@pytest.mark.parametrize("jitter", [0.0, 0.5])
@pytest.mark.parametrize("material", [RUBBER, NEARLY_INCOMPRESSIBLE, MOONEY])
def test_internal_force_is_the_gradient_of_the_energy(material: Any, jitter: float) -> None:
    mesh = Box(upper=(1.0, 0.8, 1.2), jitter=jitter).mesh(0.5)
    elements = elements_of(mesh, material)
    x = deformed(mesh)
    expected = energy_gradient(material, mesh, x)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(force(elements, x), expected, atol=1e-13 * scale, rtol=0)
    at_rest = energy(material, mesh, mesh.vertices)
    stored = energy(material, mesh, x) - at_rest
    assert elements.strain_energy(x) == pytest.approx(stored, rel=1e-12)
    assert abs(elements.strain_energy(mesh.vertices)) < 1e-13 * at_rest


def test_the_gradient_check_notices_a_missing_mean_dilatation_and_a_wrong_node_order() -> None:
    mesh = Box(jitter=0.5).mesh(0.5)
    elements = elements_of(mesh, RUBBER)
    x = deformed(mesh)
    right = force(elements, x)
    without = energy_gradient(RUBBER, mesh, x, mean_dilatation=False)
    assert np.abs(without - right).max() > 1e-3 * np.abs(right).max()
    # One element with two nodes exchanged.
    cells = mesh.cells.copy()
    cells[3, [2, 3]] = cells[3, [3, 2]]
    elements._corners = side_by_side(cells.astype(np.uint32))
    bad = force(elements, x)
    assert not np.abs(bad - right).max() < 1e-2 * np.abs(right).max()


def scikit_fem_force(mesh: HexMesh, material: NeoHookean, x: Array, transposed: bool) -> Array:
    """Q1-P0 force written with scikit-fem alone: ``P = dev part + kappa (Jbar - 1) J F^-T``."""
    sk = scikit_fem_mesh(mesh)
    basis = Basis(sk, ElementVector(ElementHex1()), intorder=3)
    constant = basis.with_element(ElementHex0())
    u = np.empty(basis.N)
    u[basis.nodal_dofs] = (x - mesh.vertices).T
    displacement = basis.interpolate(u)
    identity = np.eye(3)[:, :, None, None]
    J = det(grad(displacement) + identity)
    Jbar = np.sum(J * basis.dx, axis=1) / np.sum(basis.dx, axis=1)
    mean = np.empty(constant.N)
    mean[constant.element_dofs[0]] = Jbar

    def internal_work(v: Any, w: Any) -> Any:
        F = grad(w["u"]) + identity
        J = det(F)
        inverse_transpose = transpose(inv(F))
        P = material.mu * J ** (-2.0 / 3.0) * (F - ddot(F, F) / 3.0 * inverse_transpose)
        P = P + material.kappa * (w["Jbar"] - 1.0) * J * inverse_transpose
        return ddot(transpose(P) if transposed else P, grad(v))

    fields = {"u": displacement, "Jbar": constant.interpolate(mean)}
    assembled = LinearForm(internal_work).assemble(basis, **fields)
    return np.asarray(assembled[basis.nodal_dofs].T)


@pytest.mark.parametrize("jitter", [0.0, 0.4])
@pytest.mark.parametrize("material", [RUBBER, NEARLY_INCOMPRESSIBLE])
def test_internal_force_equals_scikit_fem_assembly(material: NeoHookean, jitter: float) -> None:
    mesh = Box(jitter=jitter).mesh(1.0 / 3.0)
    x = deformed(mesh)
    expected = scikit_fem_force(mesh, material, x, transposed=False)
    scale = np.abs(expected).max()
    result = force(elements_of(mesh, material), x)
    np.testing.assert_allclose(result, expected, atol=1e-12 * scale, rtol=0)
    transposed = scikit_fem_force(mesh, material, x, transposed=True)
    assert np.abs(result - transposed).max() > 1e-2 * scale


def test_equal_bricks_give_the_same_force_as_hexahedra_of_any_shape() -> None:
    mesh = Box().mesh(0.25)
    x = deformed(mesh)
    shared = elements_of(mesh, RUBBER)
    stored = elements_of(dataclasses.replace(mesh, is_lattice=False), RUBBER)
    assert shared.quadrature.congruent
    assert not stored.quadrature.congruent
    assert held_bytes(shared) < held_bytes(stored)
    f = force(shared, x)
    np.testing.assert_allclose(f, force(stored, x), atol=1e-13 * np.abs(f).max(), rtol=0)


@pytest.mark.parametrize("material", [RUBBER, MOONEY])
def test_forces_have_no_resultant_and_no_moment(material: Any) -> None:
    mesh = Box(jitter=0.4).mesh(0.25)
    x = deformed(mesh)
    f = force(elements_of(mesh, material), x)
    scale = np.abs(f).sum()
    assert np.abs(f.sum(axis=0)).max() < 1e-14 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-14 * scale


def test_a_rigid_rotation_gives_no_force_and_no_stress() -> None:
    mesh = Box(jitter=0.4).mesh(0.25)
    elements = elements_of(mesh, RUBBER)
    angle = 2.1
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    x = mesh.vertices @ rotation.T + [3.0, -2.0, 1.0]
    scale = RUBBER.kappa * mesh.spacing**2
    assert np.abs(force(elements, x)).max() < 1e-13 * scale
    stress = elements.stress(x)
    assert np.abs(stress.P).max() < 1e-13 * RUBBER.kappa
    np.testing.assert_allclose(stress.F, np.broadcast_to(rotation, stress.F.shape), atol=1e-13)


def test_recovered_stress_is_exact_for_affine_motion_and_carries_the_mean_pressure() -> None:
    mesh = Box(jitter=0.4).mesh(0.25)
    elements = elements_of(mesh, MOONEY)
    F = np.array([[1.2, 0.3, 0.0], [-0.1, 0.8, 0.1], [0.0, 0.2, 1.1]])
    stress = elements.stress(mesh.vertices @ F.T)
    entries = split(F)
    P = law.first_piola(MOONEY, entries, cofactor(entries), determinant(entries))
    np.testing.assert_allclose(stress.P, np.broadcast_to(np.reshape(P, (3, 3)), stress.P.shape))
    np.testing.assert_allclose(stress.J, np.linalg.det(F), rtol=1e-13)

    x = deformed(mesh)
    stress = elements.stress(x)
    # tr(P F^T) / 3 = J_c kappa (Jbar - 1): the deviatoric part of the law has no trace.
    trace = np.einsum("eik,eik->e", stress.P, stress.F)
    pressure = trace / (3.0 * np.linalg.det(stress.F) * MOONEY.kappa)
    np.testing.assert_allclose(pressure, stress.J - 1.0, atol=1e-12)
    assert np.abs(np.linalg.det(stress.F) - stress.J).max() > 1e-4


def test_the_shortest_length_follows_compression_and_expansion() -> None:
    mesh = Box().mesh(0.25)
    elements = elements_of(mesh, RUBBER)
    for stretches, expected in (((1, 1, 1), 0.25), ((0.5, 1, 1.2), 0.125), ((1, 2, 2), 0.0625)):
        force(elements, mesh.vertices * stretches)
        assert elements.smallest_length() == pytest.approx(expected, rel=1e-7)


def test_the_shortest_length_finds_the_thinnest_gauss_point() -> None:
    mesh = Box(jitter=0.3).mesh(0.25)
    elements = elements_of(mesh, NEARLY_INCOMPRESSIBLE)
    q = elements.quadrature
    x = mesh.vertices.copy()
    # Squeezed towards X = 0 inside every element as well as from one to the next.
    x[:, 0] = 0.4 * x[:, 0] + 0.6 * x[:, 0] ** 2
    force(elements, x)
    gradients, _, _ = gauss_data(mesh.vertices[mesh.cells], CORNERS.astype(float), 2)
    F = np.einsum("eai,egak->egik", x[mesh.cells], gradients)
    stretch = np.linalg.svd(F, compute_uv=False)[..., -1].min(axis=1)
    assert elements.smallest_length() == pytest.approx(np.min(q.length * stretch), rel=1e-6)


def test_an_inverted_and_a_non_finite_element_are_found() -> None:
    mesh = Box().mesh(0.5)
    elements = elements_of(mesh, RUBBER)
    force(elements, mesh.vertices)
    assert elements.invalid_element() == -1
    x = mesh.vertices.copy()
    corner = int(np.argmin(np.abs(x - 1.0).sum(axis=1)))
    touching = int(np.flatnonzero((mesh.cells == corner).any(axis=1))[0])
    for value in ((0.3, 0.3, 0.3), (np.nan, 1.0, 1.0), (np.inf, 1.0, 1.0)):
        x[corner] = value
        force(elements, x)
        assert elements.invalid_element() == touching
