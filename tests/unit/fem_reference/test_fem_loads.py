"""Load vectors: exact resultants and moments, and the input they refuse."""

import numpy as np
import pytest
from numpy.typing import NDArray

from fem_reference.load_shapes import trilinear_shapes
from fem_reference.loads import Load, loads_of, nodal_force
from fem_reference.mesh import scikit_fem_mesh
from sphsolid.continuum import NeoHookean
from sphsolid.errors import InputError
from sphsolid.geometry.mesh import HexMesh
from sphsolid.scenes import Box, Scene, Traction

Array = NDArray[np.float64]
MATERIAL = NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.3, density=1000.0)
FACES = ("X-", "X+", "Y-", "Y+", "Z-", "Z+")
BOX = Box(upper=(1.0, 2.0, 0.5), jitter=0.5, seed=2)


def trilinear_loads(scene: Scene, mesh: HexMesh) -> tuple[Load, ...]:
    sk = scikit_fem_mesh(mesh)
    return loads_of(scene, sk, trilinear_shapes(sk))


def forces(scene: Scene, t: float = 0.0) -> tuple[HexMesh, Array]:
    mesh = scene.body.mesh(0.25)
    loads = trilinear_loads(scene, mesh)
    return mesh, nodal_force(loads, t, len(mesh.vertices))


def test_a_body_without_loads_has_no_load_vectors() -> None:
    scene = Scene("free", BOX, MATERIAL, 1.0)
    assert trilinear_loads(scene, BOX.mesh(0.25)) == ()


@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_body_force_has_exact_resultant_and_moments(jitter: float) -> None:
    def field(X: Array, t: float) -> Array:
        return np.stack([3.0 * t + 0.0 * X[:, 0], X[:, 1], X[:, 0] * X[:, 2]], axis=1)

    body = Box(upper=BOX.upper, jitter=jitter)
    mesh, f = forces(Scene("pulled", body, MATERIAL, 1.0, body_force=field), t=2.0)
    # Integrals over [0,1] x [0,2] x [0,1/2]: of 6, of Y, of X Z.  2x2x2 points integrate degree
    # 3 per direction: quadratics on bricks, linears where the volume element varies too.
    np.testing.assert_allclose(f.sum(axis=0)[:2], [6.0, 1.0], rtol=1e-12)
    quadratic = 1e-12 if jitter == 0.0 else 1e-5
    np.testing.assert_allclose(f[:, 2].sum(), 0.125, rtol=quadratic)
    # The shape functions reproduce X, so first moments are moments of the field.
    np.testing.assert_allclose(mesh.vertices[:, 0] @ f[:, 1], 0.5, rtol=quadratic)
    np.testing.assert_allclose(mesh.vertices[:, 1] @ f[:, 1], 0.5 * 8.0 / 3.0, rtol=quadratic)


def test_tractions_of_a_constant_stress_have_no_resultant_and_its_virial() -> None:
    sigma = np.array([[1.0, 0.3, -0.2], [0.3, 2.0, 0.5], [-0.2, 0.5, -1.0]])
    tractions = tuple(Traction(face, lambda X, N, t: N @ sigma) for face in FACES)
    mesh, f = forces(Scene("squeezed", BOX, MATERIAL, 1.0, tractions=tractions))
    assert np.abs(f.sum(axis=0)).max() < 1e-13
    np.testing.assert_allclose(f.T @ mesh.vertices, sigma * 1.0, atol=1e-13)


def test_a_traction_acts_on_its_own_face_with_its_time() -> None:
    top = Traction("Z+", lambda X, N, t: np.outer(t * X[:, 0], [0.0, 0.0, 1.0]))
    mesh, f = forces(Scene("pushed", BOX, MATERIAL, 1.0, tractions=(top,)), t=3.0)
    on_top = mesh.face_particles("Z+")
    assert np.abs(np.delete(f, on_top, axis=0)).max() == 0.0
    np.testing.assert_allclose(f.sum(axis=0), [0.0, 0.0, 3.0], atol=1e-13)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tractions": (Traction("top", lambda X, N, t: N),)}, "'top'.*X-"),
        ({"tractions": (Traction("X+", lambda X, N, t: N[:, 0]),)}, "traction on X.*shape"),
        ({"body_force": lambda X, t: X[:5]}, "body force.*shape"),
        ({"body_force": lambda X, t: np.full_like(X, np.nan)}, "body force.*not finite"),
    ],
)
def test_wrong_loads_are_refused_by_name(change: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        forces(Scene("wrong", BOX, MATERIAL, 1.0, **change))


@pytest.mark.parametrize("place", [0.0, 10.0, 1.0e4])
@pytest.mark.parametrize("size", [0.04, 1.0, 2.0e3])
def test_tractions_are_the_same_far_from_the_origin_and_at_any_size(
    size: float, place: float
) -> None:
    def value(X: Array, N: Array, t: float) -> Array:
        return N * (1.0 + ((X - place) / size)[:, :1] ** 2)

    scene = Scene(
        "far", Box((place,) * 3, (place + size,) * 3), MATERIAL, 1.0,
        tractions=(Traction("Z+", value), Traction("X-", value)),
    )  # fmt: skip
    mesh = scene.body.mesh(0.5 * size)
    total = nodal_force(trilinear_loads(scene, mesh), 0.0, len(mesh.vertices)).sum(axis=0)
    # Coordinates are rounded to 1e-16 of the place.
    within = 1e-12 + 1e-14 * place / size
    np.testing.assert_allclose(total / size**2, [-1.0, 0.0, 4.0 / 3.0], atol=within)


def test_a_load_is_asked_once_an_instant() -> None:
    asked = []

    def field(X: Array, t: float) -> Array:
        asked.append(t)
        return np.ones_like(X)

    [load] = trilinear_loads(Scene("s", BOX, MATERIAL, 1.0, body_force=field), BOX.mesh(0.5))
    asked.clear()
    for t in (0.1, 0.1, 0.2, 0.2):
        load.nodal_force(t)
    assert asked == [0.1, 0.2]
