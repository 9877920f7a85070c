"""The plane problem by quadratic finite elements: what every method here should come to.

Elements of second order in geometry and displacement, linear elasticity.  Neither Poisson's ratio
nor stress or strain being plane changes the stress in the plane.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshQuad,
    MeshQuad2,
    asm,
    condense,
    solve,
)
from skfem.helpers import ddot, sym_grad, trace

Array = NDArray[np.float64]
_LAME = (1.5, 1.0)
#: Corners of the reference quadrilateral.
_CORNERS = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]])


def plane_stress_over_pull(
    *, cells: int, radius: float = 0.1, half_width: float = 0.5
) -> tuple[Array, Array]:
    """``sigma / S (n, 2, 2)`` at the corners ``X (n, 2)`` of ``cells x cells`` elements.

    Mean of what the elements around a corner have there.
    """

    def place(s: Array) -> Array:
        """From the unit square (from the hole outwards, around it) to the quarter plate."""
        angle = 0.5 * np.pi * s[1]
        direction = np.stack([np.cos(angle), np.sin(angle)])
        outer = half_width / direction.max(axis=0)
        # Finer at the hole.
        out = s[0] * (0.35 + 0.65 * s[0])
        return (radius + (outer - radius) * out) * direction

    planes = np.linspace(0.0, 1.0, cells + 1)
    flat = MeshQuad2.from_mesh(MeshQuad.init_tensor(planes, planes))
    mesh = MeshQuad2(place(flat.doflocs), flat.t)
    element = ElementVector(ElementQuad2())
    lam, mu = _LAME

    @BilinearForm
    def stiffness(u, v, w):  # type: ignore[no-untyped-def]
        e, f = sym_grad(u), sym_grad(v)
        return lam * trace(e) * trace(f) + 2.0 * mu * ddot(e, f)

    @LinearForm
    def pull(v, w):  # type: ignore[no-untyped-def]
        return v[1]

    basis = Basis(mesh, element)
    top = mesh.facets_satisfying(lambda x: np.isclose(x[1], half_width), boundaries_only=True)
    fixed = np.concatenate(
        [
            basis.get_dofs(lambda x, axis=axis: np.isclose(x[axis], 0.0)).all(f"u^{axis + 1}")
            for axis in (0, 1)
        ]
    )
    u = solve(*condense(asm(stiffness, basis), asm(pull, FacetBasis(mesh, element, facets=top)),
                        D=fixed))  # fmt: skip
    corners = Basis(mesh, element, quadrature=(_CORNERS, np.ones(4)))
    e = sym_grad(corners.interpolate(u))
    sigma = 2.0 * mu * e + lam * trace(e) * np.eye(2)[:, :, None, None]
    X = np.asarray(corners.global_coordinates())
    key = np.round(X.reshape(2, -1).T / (1e-7 * half_width)).astype(np.int64)
    _, first, number = np.unique(key, axis=0, return_index=True, return_inverse=True)
    count = np.bincount(number.ravel())
    values = np.asarray(sigma).reshape(4, -1)
    mean = [np.bincount(number.ravel(), weights=row) / count for row in values]
    return X.reshape(2, -1).T[first], np.stack(mean, axis=1).reshape(-1, 2, 2)
