"""The Saint Venant-Kirchhoff solid: linear in Green's strain, the law of many benchmarks."""

from __future__ import annotations

from typing import Any, NamedTuple

from sphsolid.compiled import inlined
from sphsolid.continuum.law_registry import register_law
from sphsolid.continuum.moduli import elastic
from sphsolid.continuum.tensor import (
    IDENTITY,
    Tensor,
    add,
    axpy,
    contract,
    multiply,
    scale,
    transpose,
)


class SaintVenantKirchhoff(NamedTuple):
    """``W = lambda/2 (tr E)^2 + mu E:E``, ``E = (F^T F - I)/2``, ``lambda = kappa - 2/3 mu``.

    For large rotations and small strains: it is not polyconvex, and under compression to less than
    about 0.6 of a length its stress falls, so a body may collapse.  ``U(J)`` is its energy of a
    pure change of volume.  Build it with :meth:`from_young`, which checks its input.

    ``mu``, ``kappa`` [Pa] shear and bulk modulus; ``density`` [kg/m^3] in the reference state.
    """

    mu: float
    kappa: float
    density: float

    @classmethod
    def from_young(
        cls, *, young_modulus: float, poisson_ratio: float, density: float
    ) -> SaintVenantKirchhoff:
        """From ``E`` [Pa], ``nu`` in (-1, 0.5) and ``rho0`` [kg/m^3]; raises ``InputError``."""
        return cls(*elastic(young_modulus, poisson_ratio, density))

    @property
    def depends_on_H(self) -> bool:
        """False: the energy has no cofactor term, so no ``H`` field is needed."""
        return False


@inlined
def _green_strain(F: Tensor) -> Tensor:
    """``E = (F^T F - I)/2``."""
    return scale(0.5, axpy(-1.0, IDENTITY, multiply(transpose(F), F)))


@inlined
def _stress_of(m: SaintVenantKirchhoff, E: Tensor) -> Tensor:
    """``S = lambda (tr E) I + 2 mu E`` [Pa]."""
    lame = m.kappa - 2.0 / 3.0 * m.mu
    return axpy(lame * contract(E, IDENTITY), IDENTITY, scale(2.0 * m.mu, E))


def energy(m: SaintVenantKirchhoff, F: Tensor, H: Tensor, J: Any) -> Any:
    """``W = S : E / 2`` [J/m^3]."""
    E = _green_strain(F)
    return 0.5 * contract(_stress_of(m, E), E)


def conjugate_stresses(
    m: SaintVenantKirchhoff, F: Tensor, H: Tensor, J: Any
) -> tuple[Tensor, Tensor, Any]:
    """``(F S, 0, 0)`` [Pa]: the energy is a function of ``F`` alone."""
    return first_piola(m, F, H, J), scale(0.0, H), 0.0 * J


def first_piola(m: SaintVenantKirchhoff, F: Tensor, H: Tensor, J: Any) -> Tensor:
    """``P = F S`` [Pa]."""
    return multiply(F, _stress_of(m, _green_strain(F)))


def hessian_action(
    m: SaintVenantKirchhoff, F: Tensor, H: Tensor, J: Any, dF: Tensor, dH: Tensor, dJ: Any
) -> tuple[Tensor, Tensor, Any]:
    """``dF S + F dS`` with ``dE`` the symmetric part of ``F^T dF``."""
    A = multiply(transpose(F), dF)
    dS = _stress_of(m, scale(0.5, add(A, transpose(A))))
    dP = add(multiply(dF, _stress_of(m, _green_strain(F))), multiply(F, dS))
    return dP, scale(0.0, dH), 0.0 * dJ


register_law(
    SaintVenantKirchhoff,
    energy=energy,
    conjugate_stresses=conjugate_stresses,
    first_piola=first_piola,
    hessian_action=hessian_action,
)
