"""Nearly incompressible neo-Hookean solid: [Lee2017] eq. (7) with ``xi = 0``."""

from __future__ import annotations

from typing import Any, NamedTuple

from sphsolid.continuum.inverse_root import inverse_two_thirds
from sphsolid.continuum.law_registry import register_law
from sphsolid.continuum.moduli import elastic
from sphsolid.continuum.quadratic_volume import QUADRATIC
from sphsolid.continuum.quadratic_volume import energy as U
from sphsolid.continuum.quadratic_volume import pressure as dU
from sphsolid.continuum.quadratic_volume import stiffness as ddU
from sphsolid.continuum.tensor import Tensor, axpy, contract, scale


class NeoHookean(NamedTuple):
    """``W = (mu/2) J^(-2/3) F:F + (kappa/2) (J-1)^2`` (so ``varsigma = mu/2``, ``xi = 0``).

    Build it with :meth:`from_young`, which checks its input.

    ``mu``, ``kappa`` [Pa] shear and bulk modulus; ``density`` [kg/m^3] in the reference state.
    """

    mu: float
    kappa: float
    density: float

    @classmethod
    def from_young(
        cls, *, young_modulus: float, poisson_ratio: float, density: float
    ) -> NeoHookean:
        """From ``E`` [Pa], ``nu`` in (-1, 0.5) and ``rho0`` [kg/m^3]; raises ``InputError``."""
        return cls(*elastic(young_modulus, poisson_ratio, density))

    @property
    def depends_on_H(self) -> bool:
        """False: the energy has no cofactor term, so no ``H`` field is needed."""
        return False


def energy(m: NeoHookean, F: Tensor, H: Tensor, J: Any) -> Any:
    """Eq. (7), ``xi = 0``."""
    deviatoric = 0.5 * m.mu * inverse_two_thirds(J) * contract(F, F)
    return deviatoric + U(m, J)


def conjugate_stresses(m: NeoHookean, F: Tensor, H: Tensor, J: Any) -> tuple[Tensor, Tensor, Any]:
    """Eq. (8), ``xi = 0``."""
    c = m.mu * inverse_two_thirds(J)
    Sigma_J = -c * contract(F, F) / (3.0 * J) + dU(m, J)
    return scale(c, F), scale(0.0, H), Sigma_J


def first_piola(m: NeoHookean, F: Tensor, H: Tensor, J: Any) -> Tensor:
    """Eq. (9) with ``Sigma_H = 0``: the tensor cross product is never formed."""
    c = m.mu * inverse_two_thirds(J)
    Sigma_J = -c * contract(F, F) / (3.0 * J) + dU(m, J)
    return axpy(Sigma_J, H, scale(c, F))


def hessian_action(
    m: NeoHookean, F: Tensor, H: Tensor, J: Any, dF: Tensor, dH: Tensor, dJ: Any
) -> tuple[Tensor, Tensor, Any]:
    """Eqs. (10)-(12), ``xi = 0``."""
    c = m.mu * inverse_two_thirds(J)
    W_FJ = -2.0 / 3.0 * c / J
    dSigma_F = axpy(W_FJ * dJ, F, scale(c, dF))
    W_JJ = 5.0 / 9.0 * c * contract(F, F) / (J * J) + ddU(m, J)
    dSigma_J = W_FJ * contract(F, dF) + W_JJ * dJ
    return dSigma_F, scale(0.0, dH), dSigma_J


register_law(
    NeoHookean,
    energy=energy,
    conjugate_stresses=conjugate_stresses,
    first_piola=first_piola,
    hessian_action=hessian_action,
    volumetric=QUADRATIC,
)
