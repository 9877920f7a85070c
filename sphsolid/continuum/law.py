"""What every constitutive law answers, and how a kernel reaches it.

A law is a ``NamedTuple`` of parameters plus four functions registered for its type.  Kernels
call the generic functions below; numba picks the law from the *type* of the parameters when it
compiles, so the choice costs nothing at run time and the result is cached on disk.

With ``W(F, H, J)`` the polyconvex energy [J/m^3] of [Lee2017] eq. (7):

* :func:`energy` ``W``;
* :func:`conjugate_stresses` ``(Sigma_F, Sigma_H, Sigma_J) = dW/d(F, H, J)``, eq. (8);
* :func:`first_piola` ``P = Sigma_F + Sigma_H x F + Sigma_J H``, eq. (9);
* :func:`hessian_action` ``[H_W] (dF, dH, dJ)``, eqs. (10)-(12);
* :func:`stored_energy` ``W`` counted from the undeformed state;
* :func:`tangent_action` ``dP = (dP/dF) : dF`` along ``H = cof F``, ``J = det F``.

``F``, ``H``, ``dF``, ``dH`` are nine-entry tensors (see ``tensor``), ``J`` and ``dJ`` numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sphsolid.compiled import inlined, overload
from sphsolid.continuum.tensor import (
    IDENTITY,
    Tensor,
    add,
    axpy,
    cofactor,
    contract,
    cross,
    determinant,
    scale,
)

_LAWS: dict[str, dict[type, Callable[..., Any]]] = {
    "energy": {},
    "conjugate_stresses": {},
    "first_piola": {},
    "hessian_action": {},
}

_INLINED = {"forceinline": True}


def register_law(
    parameters: type,
    *,
    energy: Callable[..., Any],
    conjugate_stresses: Callable[..., Any],
    first_piola: Callable[..., Any],
    hessian_action: Callable[..., Any],
) -> None:
    """Make a law known to the generic functions under the type of its parameters."""
    _LAWS["energy"][parameters] = inlined(energy)
    _LAWS["conjugate_stresses"][parameters] = inlined(conjugate_stresses)
    _LAWS["first_piola"][parameters] = inlined(first_piola)
    _LAWS["hessian_action"][parameters] = inlined(hessian_action)


def energy(material: Any, F: Tensor, H: Tensor, J: Any) -> Any:
    """Strain energy density ``W(F, H, J)`` [J/m^3] ([Lee2017] eq. (7))."""
    return _LAWS["energy"][type(material)](material, F, H, J)


def conjugate_stresses(
    material: Any, F: Tensor, H: Tensor, J: Any
) -> tuple[Tensor, Tensor, Any]:
    """``Sigma_F, Sigma_H, Sigma_J`` [Pa] ([Lee2017] eq. (8))."""
    return _LAWS["conjugate_stresses"][type(material)](material, F, H, J)


def first_piola(material: Any, F: Tensor, H: Tensor, J: Any) -> Tensor:
    """``P = Sigma_F + Sigma_H x F + Sigma_J H`` [Pa] ([Lee2017] eq. (9))."""
    return _LAWS["first_piola"][type(material)](material, F, H, J)


def hessian_action(
    material: Any, F: Tensor, H: Tensor, J: Any, dF: Tensor, dH: Tensor, dJ: Any
) -> tuple[Tensor, Tensor, Any]:
    """``[H_W] (dF, dH, dJ)``: increments of the conjugate stresses ([Lee2017] eqs. (10)-(12))."""
    return _LAWS["hessian_action"][type(material)](material, F, H, J, dF, dH, dJ)


@overload(energy, jit_options=_INLINED)
def _energy(material, F, H, J):  # type: ignore[no-untyped-def]
    law = _LAWS["energy"][material.instance_class]
    return lambda material, F, H, J: law(material, F, H, J)


@overload(conjugate_stresses, jit_options=_INLINED)
def _conjugate_stresses(material, F, H, J):  # type: ignore[no-untyped-def]
    law = _LAWS["conjugate_stresses"][material.instance_class]
    return lambda material, F, H, J: law(material, F, H, J)


@overload(first_piola, jit_options=_INLINED)
def _first_piola(material, F, H, J):  # type: ignore[no-untyped-def]
    law = _LAWS["first_piola"][material.instance_class]
    return lambda material, F, H, J: law(material, F, H, J)


@overload(hessian_action, jit_options=_INLINED)
def _hessian_action(material, F, H, J, dF, dH, dJ):  # type: ignore[no-untyped-def]
    law = _LAWS["hessian_action"][material.instance_class]
    return lambda material, F, H, J, dF, dH, dJ: law(material, F, H, J, dF, dH, dJ)


@inlined
def stored_energy(material: Any, F: Tensor, H: Tensor, J: Any) -> Any:
    """``W(F, H, J) - W(I, I, 1)`` [J/m^3]: the energy counted from the undeformed state.

    Eq. (7) is not zero there (3/2 mu for the neo-Hookean solid), which would drown the strain
    energy of a run.
    """
    return energy(material, F, H, J) - energy(material, IDENTITY, IDENTITY, 1.0)


@inlined
def tangent_action(material: Any, F: Tensor, dF: Tensor) -> Tensor:
    """Increment of ``P(F, cof F, det F)`` along ``dF``.

    ``dP = dSigma_F + dSigma_H x F + Sigma_H x dF + dSigma_J H + Sigma_J dH`` with
    ``dH = F x dF`` and ``dJ = H : dF`` ([Bonet2015] sections 3.2-3.3).
    """
    H = cofactor(F)
    J = determinant(F)
    dH = cross(F, dF)
    dJ = contract(H, dF)
    _, Sigma_H, Sigma_J = conjugate_stresses(material, F, H, J)
    dSigma_F, dSigma_H, dSigma_J = hessian_action(material, F, H, J, dF, dH, dJ)
    dP = add(dSigma_F, add(cross(dSigma_H, F), cross(Sigma_H, dF)))
    return axpy(dSigma_J, H, add(scale(Sigma_J, dH), dP))
