"""The Q2-Q1 element against its energy, in numpy, and in rigid and affine motion."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fem_reference import ConsistentMass, LumpedMass, TaylorHoodHex
from fem_reference.mesh import scikit_fem_mesh
from fem_reference.quadratic_mesh import NODES
from fem_reference.taylor_hood_hex import TaylorHoodElements
from sphsolid.continuum import MooneyRivlin, NeoHookean, law
from sphsolid.continuum.tensor import cofactor, determinant, split
from sphsolid.geometry.mesh import HexMesh
from sphsolid.scenes import Box
from tests.oracles.hexahedra import gauss_data

Array = NDArray[Any]
ELASTIC = {"young_modulus": 17.0e6, "density": 1100.0}
RUBBER = NeoHookean.from_young(poisson_ratio=0.3, **ELASTIC)
NEARLY_INCOMPRESSIBLE = NeoHookean.from_young(poisson_ratio=0.499, **ELASTIC)
MOONEY = MooneyRivlin.from_young(poisson_ratio=0.45, cofactor_share=0.4, **ELASTIC)


def elements_of(
    mesh: HexMesh, material: Any, option: TaylorHoodHex = TaylorHoodHex()
) -> TaylorHoodElements:
    return option.discretise(mesh=mesh, sk=scikit_fem_mesh(mesh), material=material)


def deformed(elements: TaylorHoodElements, size: float = 0.15) -> Array:
    """A stretched, turned and randomly disturbed position of every node."""
    random = np.random.default_rng(7)
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.05, 0.0, 1.05]])
    X = elements.mesh.vertices
    return X @ F.T + size * elements.mesh.spacing * random.uniform(-1, 1, X.shape)


def force(elements: TaylorHoodElements, x: Array) -> Array:
    result = np.empty_like(x)
    elements.internal_force(x, result)
    return result


def energy(elements: TaylorHoodElements, mesh: HexMesh, A: Array, x: Array) -> Any:
    """The energy of the module text in numpy, with the matrix ``A`` given; takes complex ``x``."""
    material = elements.material
    gradients, weights, N = gauss_data(mesh.vertices[mesh.cells], NODES, 3)
    F = split(np.einsum("eai,egak->egik", x[elements._cells], gradients))
    J = determinant(F)
    volumetric = 0.5 * material.kappa * (J - 1.0) ** 2
    isochoric = np.sum(weights * (law.energy(material, F, cofactor(F), J) - volumetric))
    r = np.zeros(len(mesh.vertices), dtype=x.dtype)
    np.add.at(r, mesh.cells, np.einsum("eg,ga,eg->ea", weights, N, J - 1.0))
    return isochoric + 0.5 * material.kappa * (r @ A @ r)


def matrix_of(elements: TaylorHoodElements) -> Array:
    """``A`` by its definition, from the mass matrix alone."""
    M = elements._mass.toarray()
    if isinstance(elements._dilatation, ConsistentMass):
        return np.linalg.inv(M)
    D = np.diag(1.0 / M.sum(axis=1))
    defect = np.eye(len(M)) - D @ M
    return sum(
        np.linalg.matrix_power(defect, k) @ D for k in range(elements._dilatation.sweeps + 1)
    )


@pytest.mark.parametrize("jitter", [0.0, 0.5])
@pytest.mark.parametrize(
    ("material", "dilatation"),
    [(RUBBER, ConsistentMass()), (NEARLY_INCOMPRESSIBLE, LumpedMass(sweeps=1)),
     (MOONEY, ConsistentMass()), (MOONEY, LumpedMass(sweeps=0))],
)  # fmt: skip
def test_internal_force_is_the_gradient_of_the_energy(
    material: Any, dilatation: Any, jitter: float
) -> None:
    mesh = Box(upper=(1.0, 0.8, 0.6), jitter=jitter).mesh(0.5)
    elements = elements_of(mesh, material, TaylorHoodHex(dilatation))
    x, A = deformed(elements), matrix_of(elements)
    expected = np.empty_like(x)
    # Complex step: exact to round-off, no step size to choose.  Every third entry is enough.
    chosen = list(np.ndindex(x.shape))[::3]
    for a, i in chosen:
        moved = x.astype(complex)
        moved[a, i] += 1e-40j
        expected[a, i] = energy(elements, mesh, A, moved).imag / 1e-40
    picked = tuple(np.array(chosen).T)
    scale = np.abs(expected[picked]).max()
    found = force(elements, x)
    np.testing.assert_allclose(found[picked], expected[picked], atol=1e-13 * scale, rtol=0)
    X = elements.mesh.vertices
    stored = energy(elements, mesh, A, x) - energy(elements, mesh, A, X)
    assert elements.strain_energy(x) == pytest.approx(stored, rel=1e-12)
    # Planted bugs: the pressure of another projection, and two nodes of one element exchanged.
    other = LumpedMass(sweeps=2) if isinstance(dilatation, ConsistentMass) else ConsistentMass()
    wrong = force(elements_of(mesh, material, TaylorHoodHex(other)), x)
    assert np.abs(wrong - found).max() > 1e-4 * scale
    elements._node_lanes[0, [12, 13], 1] = elements._node_lanes[0, [13, 12], 1]
    assert not np.abs(force(elements, x) - found).max() < 1e-2 * scale


@pytest.mark.parametrize("jitter", [0.0, 0.4])
@pytest.mark.parametrize("material", [RUBBER, MOONEY])
def test_forces_have_no_resultant_and_no_moment(material: Any, jitter: float) -> None:
    elements = elements_of(Box(jitter=jitter).mesh(0.25), material)
    x = deformed(elements)
    f = force(elements, x)
    scale = np.abs(f).sum()
    assert np.abs(f.sum(axis=0)).max() < 1e-14 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-14 * scale


def test_equal_bricks_give_the_same_force_as_hexahedra_of_any_shape() -> None:
    mesh = Box(upper=(1.0, 0.8, 1.2)).mesh(0.4)
    bricks = elements_of(mesh, RUBBER)
    shapes = elements_of(dataclasses.replace(mesh, is_lattice=False), RUBBER)
    assert "equal bricks" in bricks.description()
    assert "any shape" in shapes.description()
    x = deformed(bricks)
    f = force(bricks, x)
    np.testing.assert_allclose(f, force(shapes, x), atol=1e-12 * np.abs(f).max(), rtol=0)


def test_a_rigid_rotation_gives_no_force_and_no_stress() -> None:
    elements = elements_of(Box(jitter=0.4).mesh(0.25), RUBBER)
    c, s = np.cos(2.1), np.sin(2.1)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    x = elements.mesh.vertices @ rotation.T + [3.0, -2.0, 1.0]
    assert np.abs(force(elements, x)).max() < 1e-13 * RUBBER.kappa * elements.mesh.spacing**2
    stress = elements.stress(x)
    assert np.abs(stress.P).max() < 1e-12 * RUBBER.kappa
    np.testing.assert_allclose(stress.F, np.broadcast_to(rotation, stress.F.shape), atol=1e-12)


def test_stress_is_exact_for_affine_motion_and_carries_the_continuous_pressure() -> None:
    elements = elements_of(Box(jitter=0.4).mesh(0.25), MOONEY)
    F = np.array([[1.2, 0.3, 0.0], [-0.1, 0.8, 0.1], [0.0, 0.2, 1.1]])
    stress = elements.stress(elements.mesh.vertices @ F.T)
    entries = split(F)
    P = law.first_piola(MOONEY, entries, cofactor(entries), determinant(entries))
    expected = np.broadcast_to(np.reshape(P, (3, 3)), stress.P.shape)
    np.testing.assert_allclose(stress.P, expected, rtol=1e-10, atol=1e-10 * np.abs(P).max())
    np.testing.assert_allclose(stress.J, np.linalg.det(F), rtol=1e-12)

    x = deformed(elements)
    stress = elements.stress(x)
    # tr(P F^T) / 3 = det F kappa (theta - 1): the deviatoric part of the law has no trace.
    trace = np.einsum("eik,eik->e", stress.P, stress.F)
    pressure = trace / (3.0 * np.linalg.det(stress.F) * MOONEY.kappa)
    np.testing.assert_allclose(pressure, stress.J - 1.0, atol=1e-11)
    theta = 1.0 + elements.dilatation(x)
    middles = theta[elements._corners].mean(axis=1)
    np.testing.assert_allclose(stress.J.reshape(-1, 8).mean(axis=1), middles, rtol=1e-13)


def test_the_shortest_length_follows_compression_and_expansion() -> None:
    elements = elements_of(Box().mesh(0.5), RUBBER)
    X = elements.mesh.vertices
    force(elements, X)
    rest = elements.smallest_length()
    # Nodes are 0.25 apart; the share of the quadratic element is in test_taylor_hood.
    assert 0.4 * 0.25 < rest < 0.25
    for stretches, factor in (((0.5, 1, 1.2), 0.5), ((1, 2, 2), 0.25)):
        force(elements, X * stretches)
        assert elements.smallest_length() == pytest.approx(factor * rest, rel=1e-6)


def test_an_inverted_and_a_non_finite_element_are_found() -> None:
    elements = elements_of(Box().mesh(0.5), RUBBER)
    X = elements.mesh.vertices
    force(elements, X)
    assert elements.invalid_element() == -1
    corner = int(np.argmin(np.abs(X - 1.0).sum(axis=1)))
    touching = int(np.flatnonzero((elements._cells == corner).any(axis=1))[0])
    np.testing.assert_allclose(elements.centre(touching), 0.75)
    x = X.copy()
    for value in ((-0.5, -0.5, -0.5), (np.nan, 1.0, 1.0)):
        x[corner] = value
        force(elements, x)
        # One nan spreads through the pressure of all; the Jacobians still name the element.
        assert elements.invalid_element() == touching
