"""What a particle method hands out at an instant."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, contract, determinant, join, split
from sphsolid.geometry.mesh import Mesh, read_only
from sphsolid.record.budget import Budget, NotTracked
from sphsolid.record.placement import (
    NO_SECONDARY_GRADIENT,
    NoSecondaryGradient,
    SecondaryGradient,
)
from sphsolid.record.snapshot import Snapshot
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.state import State
from sphsolid.scheme.time_step import STRETCH

Array = NDArray[np.float64]
_KNOWN = {"p", "x", "F", "H", "J", STRETCH}


def snapshot_of(
    state: State, rhs: RightHandSide, material: Any, mesh: Mesh, *, time: float, step: int,
    budget: Budget | NotTracked,
) -> Snapshot:  # fmt: skip
    """Copies of ``state``, with the constitutive stress [Pa] and all energy that is stored.

    Both are the law's and what terms add to them.
    """
    s, formulation, cloud = rhs.of_geometry(state), rhs.formulation, rhs.set_up.cloud
    F = split(s.F)
    H = split(s.H) if formulation.evolves_H else cofactor(F)
    J = s.J if formulation.evolves_J else determinant(F)
    density = law.stored_energy(material, F, H, J)
    P = join(law.first_piola(material, F, H, J))
    of_law = P.copy()
    energy, volumetric = float(np.sum(cloud.V * density)), 0.0
    for term in rhs.terms:
        term.add_constitutive(s, P)
        stored = term.stored_energy(s)
        energy += stored
        volumetric += stored if term.stores_volume else 0.0
    # Mean Cauchy stress of what the terms add: zero to the bit where none does.
    mean = contract(split(P - of_law), F) / (3.0 * determinant(F))
    X, V = read_only(cloud.X), read_only(cloud.V)
    return Snapshot(
        time=time,
        step=step,
        material=material,
        mesh=mesh,
        X=X,
        V=V,
        x=s.x.copy(),
        velocity=s.p / material.density,
        stress_X=X,
        stress_V=V,
        F=s.F.copy(),
        J=np.array(J, copy=True),
        P=P,
        strain_energy=energy,
        added_pressure=mean,
        added_volumetric_energy=volumetric,
        budget=budget,
        secondary=secondary_gradient(rhs, s.x),
        further={name: read_only(s[name].copy()) for name in s if name not in _KNOWN},
    )


def secondary_gradient(rhs: RightHandSide, x: Array) -> SecondaryGradient | NoSecondaryGradient:
    """The gradient of ``x (N, 3)`` [m] at the secondary particles of the first term with some."""
    for term in rhs.terms:
        if term.secondary is not None:
            return SecondaryGradient(term.secondary.X, term.at_secondary(x))
    return NO_SECONDARY_GRADIENT
