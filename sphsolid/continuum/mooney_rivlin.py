"""Nearly incompressible polyconvex Mooney-Rivlin solid, [Lee2017] eqs. (7)-(12)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from sphsolid.continuum.inverse_root import inverse_two_thirds
from sphsolid.continuum.law_registry import register_law
from sphsolid.continuum.moduli import elastic
from sphsolid.continuum.quadratic_volume import QUADRATIC
from sphsolid.continuum.quadratic_volume import energy as U
from sphsolid.continuum.quadratic_volume import pressure as dU
from sphsolid.continuum.quadratic_volume import stiffness as ddU
from sphsolid.continuum.tensor import Tensor, add, axpy, contract, cross, scale
from sphsolid.errors import require
from sphsolid.protocols import number


class MooneyRivlin(NamedTuple):
    """``W = varsigma J^(-2/3) I1 + xi J^-2 I2^(3/2) + (kappa/2)(J-1)^2``.

    ``I1 = F:F``, ``I2 = H:H``; ``2 varsigma + 3 sqrt(3) xi = mu`` in the small-strain limit.
    ``varsigma``, ``xi``, ``kappa`` [Pa]; ``density`` [kg/m^3].
    """

    varsigma: float
    xi: float
    kappa: float
    density: float

    @classmethod
    def from_young(
        cls, *, young_modulus: float, poisson_ratio: float, density: float, cofactor_share: float
    ) -> MooneyRivlin:
        """From ``E``, ``nu``, ``rho0`` and the share of ``mu`` that the cofactor term carries.

        ``cofactor_share`` in [0, 1]: ``3 sqrt(3) xi = share mu``.  Raises ``InputError``.
        """
        mu, kappa, density = elastic(young_modulus, poisson_ratio, density)
        require(
            0.0 <= number("cofactor_share", cofactor_share) <= 1.0,
            f"cofactor_share = {cofactor_share} is outside [0, 1]; 0 is the neo-Hookean solid",
        )
        return cls(
            varsigma=0.5 * (1.0 - cofactor_share) * mu,
            xi=cofactor_share * mu / (3.0 * math.sqrt(3.0)),
            kappa=kappa,
            density=density,
        )

    @property
    def mu(self) -> float:
        """Small-strain shear modulus ``2 varsigma + 3 sqrt(3) xi`` [Pa]."""
        return 2.0 * self.varsigma + 3.0 * math.sqrt(3.0) * self.xi

    @property
    def depends_on_H(self) -> bool:
        """True when the cofactor term is active."""
        return self.xi > 0.0


def energy(m: MooneyRivlin, F: Tensor, H: Tensor, J: Any) -> Any:
    """Eq. (7)."""
    by_F = m.varsigma * inverse_two_thirds(J) * contract(F, F)
    by_H = m.xi * contract(H, H) ** 1.5 / (J * J)
    return by_F + by_H + U(m, J)


def conjugate_stresses(m: MooneyRivlin, F: Tensor, H: Tensor, J: Any) -> tuple[Tensor, Tensor, Any]:
    """Eq. (8)."""
    a = 2.0 * m.varsigma * inverse_two_thirds(J)
    root = contract(H, H) ** 0.5
    b = 3.0 * m.xi * root / (J * J)
    Sigma_J = (
        -a * contract(F, F) / (3.0 * J)
        - 2.0 * m.xi * root * root * root / (J * J * J)
        + dU(m, J)
    )
    return scale(a, F), scale(b, H), Sigma_J


def first_piola(m: MooneyRivlin, F: Tensor, H: Tensor, J: Any) -> Tensor:
    """Eq. (9)."""
    Sigma_F, Sigma_H, Sigma_J = conjugate_stresses(m, F, H, J)
    return axpy(Sigma_J, H, add(Sigma_F, cross(Sigma_H, F)))


def hessian_action(
    m: MooneyRivlin, F: Tensor, H: Tensor, J: Any, dF: Tensor, dH: Tensor, dJ: Any
) -> tuple[Tensor, Tensor, Any]:
    """Eqs. (10)-(12)."""
    I2 = contract(H, H)
    root = I2**0.5
    a = 2.0 * m.varsigma * inverse_two_thirds(J)
    b = 3.0 * m.xi * root / (J * J)
    W_FJ = -2.0 / 3.0 * a / J
    W_HJ = -2.0 * b / J
    W_JJ = (
        5.0 / 9.0 * a * contract(F, F) / (J * J)
        + 6.0 * m.xi * I2 * root / (J * J * J * J)
        + ddU(m, J)
    )
    dSigma_F = axpy(W_FJ * dJ, F, scale(a, dF))
    dSigma_H = axpy(b * contract(H, dH) / I2 + W_HJ * dJ, H, scale(b, dH))
    dSigma_J = W_FJ * contract(F, dF) + W_HJ * contract(H, dH) + W_JJ * dJ
    return dSigma_F, dSigma_H, dSigma_J


register_law(
    MooneyRivlin,
    energy=energy,
    conjugate_stresses=conjugate_stresses,
    first_piola=first_piola,
    hessian_action=hessian_action,
    volumetric=QUADRATIC,
)
