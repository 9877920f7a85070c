"""What every constitutive law answers, and how a kernel reaches it.

A law is a ``NamedTuple`` of parameters plus functions registered for its type.  Kernels call the
generic functions below.  numba picks the law from the *type* of the parameters when it compiles, so
the choice costs nothing at run time and the result is cached on disk.  Kernels are handed
``in_kernels(material)``, whose type changes with the text of the law.

With ``W(F, H, J)`` the polyconvex energy [J/m^3] of [Lee2017] eq. (7):

* :func:`energy` ``W``;
* :func:`conjugate_stresses` ``(Sigma_F, Sigma_H, Sigma_J) = dW/d(F, H, J)``, eq. (8);
* :func:`first_piola` ``P = Sigma_F + Sigma_H x F + Sigma_J H``, eq. (9);
* :func:`hessian_action` ``[H_W] (dF, dH, dJ)``, eqs. (10)-(12);
* :func:`volumetric_energy`, :func:`volumetric_pressure`, :func:`volumetric_stiffness`:
  ``U, U', U''``, the energy of a pure change of volume;
* :func:`stored_energy` ``W`` counted from the undeformed state;
* :func:`tangent_action` ``dP = (dP/dF) : dF`` along ``H = cof F``, ``J = det F``.

``F``, ``H``, ``dF``, ``dH`` are nine-entry tensors (see ``tensor``), ``J`` and ``dJ`` numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sphsolid.compiled import inlined, overload
from sphsolid.continuum.law_registry import in_kernels, law_of, register_law
from sphsolid.continuum.quadratic_volume import QUADRATIC
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
from sphsolid.continuum.volumetric import Volumetric

__all__ = [
    "QUADRATIC",
    "Volumetric",
    "conjugate_stresses",
    "energy",
    "first_piola",
    "hessian_action",
    "in_kernels",
    "is_quadratic",
    "register_law",
    "stiffening",
    "stored_energy",
    "tangent_action",
    "volumetric_energy",
    "volumetric_pressure",
    "volumetric_stiffness",
]

_INLINED = {"forceinline": True}


def energy(material: Any, F: Tensor, H: Tensor, J: Any) -> Any:
    """Strain energy density ``W(F, H, J)`` [J/m^3] ([Lee2017] eq. (7))."""
    return law_of(type(material)).energy(material, F, H, J)


def conjugate_stresses(
    material: Any, F: Tensor, H: Tensor, J: Any
) -> tuple[Tensor, Tensor, Any]:
    """``Sigma_F, Sigma_H, Sigma_J`` [Pa] ([Lee2017] eq. (8))."""
    return law_of(type(material)).conjugate_stresses(material, F, H, J)


def first_piola(material: Any, F: Tensor, H: Tensor, J: Any) -> Tensor:
    """``P = Sigma_F + Sigma_H x F + Sigma_J H`` [Pa] ([Lee2017] eq. (9))."""
    return law_of(type(material)).first_piola(material, F, H, J)


def hessian_action(
    material: Any, F: Tensor, H: Tensor, J: Any, dF: Tensor, dH: Tensor, dJ: Any
) -> tuple[Tensor, Tensor, Any]:
    """``[H_W] (dF, dH, dJ)``: increments of the conjugate stresses ([Lee2017] eqs. (10)-(12))."""
    return law_of(type(material)).hessian_action(material, F, H, J, dF, dH, dJ)


def volumetric_energy(material: Any, J: Any) -> Any:
    """``U(J)`` [J/m^3], zero at ``J = 1``; see ``volumetric``."""
    return law_of(type(material)).volumetric.energy(material, J)


def volumetric_pressure(material: Any, J: Any) -> Any:
    """``U'(J)`` [Pa], positive in tension."""
    return law_of(type(material)).volumetric.pressure(material, J)


def volumetric_stiffness(material: Any, J: Any) -> Any:
    """``U''(J)`` [Pa], the bulk modulus ``kappa`` at ``J = 1``."""
    return law_of(type(material)).volumetric.stiffness(material, J)


def is_quadratic(material: Any) -> bool:
    """True where ``U'`` is known to be linear in ``J``."""
    return law_of(type(material)).is_quadratic


def stiffening(material: Any, J: Any) -> Any:
    """``sqrt(max(1, U''(J) / kappa))``: how much faster than at rest the volume answers.

    The volumetric part of the acoustic tensor is ``U'' |cof F N|^2``; a law whose ``U''`` grows
    with compression has faster waves there than its moduli at rest say.
    """
    if is_quadratic(material):
        return 1.0
    stiffness = law_of(type(material)).volumetric.stiffness
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = stiffness(material, J) / stiffness(material, 1.0)
    return np.sqrt(np.where(ratio > 1.0, ratio, 1.0))


@overload(energy, jit_options=_INLINED)
def _energy(material, F, H, J):  # type: ignore[no-untyped-def]
    law = law_of(material.instance_class).energy
    return lambda material, F, H, J: law(material, F, H, J)


@overload(conjugate_stresses, jit_options=_INLINED)
def _conjugate_stresses(material, F, H, J):  # type: ignore[no-untyped-def]
    law = law_of(material.instance_class).conjugate_stresses
    return lambda material, F, H, J: law(material, F, H, J)


@overload(first_piola, jit_options=_INLINED)
def _first_piola(material, F, H, J):  # type: ignore[no-untyped-def]
    law = law_of(material.instance_class).first_piola
    return lambda material, F, H, J: law(material, F, H, J)


@overload(hessian_action, jit_options=_INLINED)
def _hessian_action(material, F, H, J, dF, dH, dJ):  # type: ignore[no-untyped-def]
    law = law_of(material.instance_class).hessian_action
    return lambda material, F, H, J, dF, dH, dJ: law(material, F, H, J, dF, dH, dJ)


@overload(volumetric_energy, jit_options=_INLINED)
def _volumetric_energy(material, J):  # type: ignore[no-untyped-def]
    law = law_of(material.instance_class).volumetric.energy
    return lambda material, J: law(material, J)


@overload(volumetric_pressure, jit_options=_INLINED)
def _volumetric_pressure(material, J):  # type: ignore[no-untyped-def]
    law = law_of(material.instance_class).volumetric.pressure
    return lambda material, J: law(material, J)


@overload(volumetric_stiffness, jit_options=_INLINED)
def _volumetric_stiffness(material, J):  # type: ignore[no-untyped-def]
    law = law_of(material.instance_class).volumetric.stiffness
    return lambda material, J: law(material, J)


@overload(stiffening, jit_options=_INLINED)
def _stiffening(material, J):  # type: ignore[no-untyped-def]
    if law_of(material.instance_class).is_quadratic:
        return lambda material, J: 1.0
    law = law_of(material.instance_class).volumetric.stiffness

    def faster(material, J):  # type: ignore[no-untyped-def]
        ratio = law(material, J) / law(material, 1.0)
        return np.sqrt(ratio) if ratio > 1.0 else 1.0

    return faster


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
