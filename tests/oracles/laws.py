"""Laws of a user's own: neo-Hookean in shear, with a volumetric energy that is not quadratic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from sphsolid.continuum.inverse_root import inverse_two_thirds
from sphsolid.continuum.law import register_law
from sphsolid.continuum.tensor import axpy, contract, scale

Function = Callable[..., Any]


class Logarithmic(NamedTuple):
    """``U = kappa/2 (ln J)^2``, stated."""

    mu: float
    kappa: float
    density: float
    depends_on_H = False


class Unstated(NamedTuple):
    """The same, but ``U`` is left to be asked from the energy."""

    mu: float
    kappa: float
    density: float
    depends_on_H = False


class Mixed(NamedTuple):
    """``U = kappa/4 (J^2 - 1 - 2 ln J)``, stated."""

    mu: float
    kappa: float
    density: float
    depends_on_H = False


def log_energy(m: Any, J: Any) -> Any:
    """``U``."""
    return 0.5 * m.kappa * np.log(J) ** 2


def log_pressure(m: Any, J: Any) -> Any:
    """``U'``."""
    return m.kappa * np.log(J) / J


def log_stiffness(m: Any, J: Any) -> Any:
    """``U''``."""
    return m.kappa * (1.0 - np.log(J)) / (J * J)


def mixed_energy(m: Any, J: Any) -> Any:
    """``U``."""
    return 0.25 * m.kappa * (J * J - 1.0 - 2.0 * np.log(J))


def mixed_pressure(m: Any, J: Any) -> Any:
    """``U'``."""
    return 0.5 * m.kappa * (J - 1.0 / J)


def mixed_stiffness(m: Any, J: Any) -> Any:
    """``U''``."""
    return 0.5 * m.kappa * (1.0 + 1.0 / (J * J))


def neo_hookean_with(U: Function, dU: Function, ddU: Function) -> dict[str, Function]:
    """The four functions of ``W = mu/2 J^(-2/3) F:F + U(J)``; none is decorated."""

    def energy(m: Any, F: Any, H: Any, J: Any) -> Any:
        return 0.5 * m.mu * inverse_two_thirds(J) * contract(F, F) + U(m, J)

    def conjugate_stresses(m: Any, F: Any, H: Any, J: Any) -> Any:
        c = m.mu * inverse_two_thirds(J)
        return scale(c, F), scale(0.0, H), dU(m, J) - c * contract(F, F) / (3.0 * J)

    def first_piola(m: Any, F: Any, H: Any, J: Any) -> Any:
        c = m.mu * inverse_two_thirds(J)
        return axpy(dU(m, J) - c * contract(F, F) / (3.0 * J), H, scale(c, F))

    def hessian_action(m: Any, F: Any, H: Any, J: Any, dF: Any, dH: Any, dJ: Any) -> Any:
        c = m.mu * inverse_two_thirds(J)
        W_FJ = -2.0 / 3.0 * c / J
        W_JJ = 5.0 / 9.0 * c * contract(F, F) / (J * J) + ddU(m, J)
        return axpy(W_FJ * dJ, F, scale(c, dF)), scale(0.0, dH), W_FJ * contract(F, dF) + W_JJ * dJ

    return {
        "energy": energy,
        "conjugate_stresses": conjugate_stresses,
        "first_piola": first_piola,
        "hessian_action": hessian_action,
    }


LOG = (log_energy, log_pressure, log_stiffness)
MIXED = (mixed_energy, mixed_pressure, mixed_stiffness)
register_law(Logarithmic, **neo_hookean_with(*LOG), volumetric=LOG)
register_law(Unstated, **neo_hookean_with(*LOG))
register_law(Mixed, **neo_hookean_with(*MIXED), volumetric=MIXED)
#: Parameters of every law above, ``nu = 0.4``.
LAWS = tuple(law(1.0e6, 4.667e6, 1000.0) for law in (Logarithmic, Unstated, Mixed))
