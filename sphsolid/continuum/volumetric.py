"""The volumetric energy ``U(J)`` of a law: what a pure change of volume stores.

A law may be written in any form; its ``U`` is always

    U(J) = W(J^(1/3) I, J^(2/3) I, J) - W(I, I, 1),

and ``U'(J)`` is a third of the trace of the Cauchy stress of that state, positive in tension.  Of
a law that splits, ``W = W_iso(J^(-1/3) F) + U(J)``, that is the ``U`` in the formula, and ``U'(J)``
is the mean stress of every state.  ``U''(1)`` is the bulk modulus.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from sphsolid.continuum.inverse_root import inverse_two_thirds
from sphsolid.continuum.tensor import IDENTITY, contract, scale

Function = Callable[..., Any]


class Volumetric(NamedTuple):
    """``U [J/m^3], U' [Pa], U'' [Pa]``, each a function of ``(parameters, J)``."""

    energy: Function
    pressure: Function
    stiffness: Function


@dataclass(frozen=True)
class FromEnergy:
    """The law states no ``U`` of its own: it is asked at pure changes of volume."""


def volumetric_of(
    energy: Function, conjugate_stresses: Function, hessian_action: Function
) -> Volumetric:
    """``U, U', U''`` along ``F = a I``, ``H = a^2 I``, ``a = J^(1/3)``, by the chain rule.

    Exact for every law, and slower than a formula: two or three evaluations of the law.
    """

    def U(m: Any, J: Any) -> Any:
        a = J * inverse_two_thirds(J)
        return energy(m, scale(a, IDENTITY), scale(a * a, IDENTITY), J) - energy(
            m, IDENTITY, IDENTITY, 1.0
        )

    def dU(m: Any, J: Any) -> Any:
        a = J * inverse_two_thirds(J)
        S_F, S_H, S_J = conjugate_stresses(m, scale(a, IDENTITY), scale(a * a, IDENTITY), J)
        along_F = a / (3.0 * J) * contract(S_F, IDENTITY)
        return S_J + along_F + 2.0 * a * a / (3.0 * J) * contract(S_H, IDENTITY)

    def ddU(m: Any, J: Any) -> Any:
        a = J * inverse_two_thirds(J)
        F, H = scale(a, IDENTITY), scale(a * a, IDENTITY)
        da, db = a / (3.0 * J), 2.0 * a * a / (3.0 * J)
        S_F, S_H, _ = conjugate_stresses(m, F, H, J)
        dS_F, dS_H, dS_J = hessian_action(
            m, F, H, J, scale(da, IDENTITY), scale(db, IDENTITY), 1.0
        )
        # a'' = -2 a / (9 J^2) and (a^2)'' = -2 a^2 / (9 J^2).
        bend = -2.0 * a / (9.0 * J * J)
        straight = dS_J + da * contract(dS_F, IDENTITY) + db * contract(dS_H, IDENTITY)
        return straight + bend * (contract(S_F, IDENTITY) + a * contract(S_H, IDENTITY))

    return Volumetric(U, dU, ddU)
