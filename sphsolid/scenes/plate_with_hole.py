"""A plate with a hole, pulled slowly: the static stress concentration by an explicit method.

The body is a quarter of a square plate ``|X|, |Y| <= W`` with a hole of radius ``a`` about the Z
axis.  It has rollers on its two planes of symmetry, and a traction ``s(t) S`` along Y at ``Y = W``.
The load rises over several periods of the plate's slowest mode,

    s(t) = x^3 (10 - 15 x + 6 x^2),   x = min(t / rise, 1),

with two continuous derivatives.  Then it holds, so that the body is nearly at rest.  What is left
of the slowest mode is some thousandths of the static answer.  An average over the hold takes most
of that away.

The hoop stress is largest at ``X = a, Y = 0``.  Over ``S``, the stress of the *gross* section:

* 3 in an infinite plate [Kirsch1898];
* ``(2 + (1 - a/W)^3) / (1 - a/W)`` in a long strip of half-width ``W`` [Heywood1952], within 1 %
  of Howland's series [Howland1930]: 3.14 for ``a/W = 0.2``.  Over the mean stress of the *net*
  section, which is left beside the hole, that is ``2 + (1 - a/W)^3 = 2.51``.

A square plate is shorter than a strip, and its concentration larger.  In a plane problem without a
net force on the hole the stress does not depend on Poisson's ratio, nor on whether stress or strain
is plane.  Not in [Lee2017]; sizes, material and load are ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.errors import InputError, require
from sphsolid.geometry.body import Body
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene, Traction

Array = NDArray[np.float64]
#: Rollers of either reading of the thickness: the plane Z = 0 does not move along Z in both.
ROLLERS = {
    "plane_strain": ("symmetry_x", "symmetry_y", "back", "front"),
    "free": ("symmetry_x", "symmetry_y", "back"),
}


@dataclass(frozen=True)
class SlowPull:
    """The traction ``(0, s(t) stress, 0)`` [Pa] that rises within ``rise`` [s] and holds."""

    stress: float
    rise: float

    def share(self, t: float) -> float:
        """``s(t)``, 0 to 1."""
        x = min(max(t / self.rise, 0.0), 1.0)
        return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)

    def __call__(self, X: Array, N: Array, t: float) -> Array:
        """The traction ``(n, 3)``."""
        return np.tile([0.0, self.stress * self.share(t), 0.0], (len(X), 1))


def gross_concentration(*, radius: float, half_width: float) -> float:
    """Largest hoop stress over that of the gross section in a long strip [Heywood1952].

    ``(2 + (1 - a/W)^3) / (1 - a/W)``, ``a`` the ``radius`` and ``W`` the ``half_width`` [m]; 3
    for ``a/W -> 0``.  Raises ``InputError`` for a hole wider than the strip.
    """
    require(
        0.0 < radius < half_width,
        f"radius = {radius} m of the hole must be within (0, half_width = {half_width} m)",
    )
    left = 1.0 - radius / half_width
    return (2.0 + left**3) / left


def plate_with_hole(
    *,
    body: Body,
    thickness: Literal["plane_strain", "free"] = "plane_strain",
    stress: float = 2.1e7,
    radius: float = 0.1,
    half_width: float = 0.5,
    young_modulus: float = 2.1e11,
    poisson_ratio: float = 0.3,
    density: float = 7850.0,
    rise: float = 4.0,
    hold: float = 1.0,
) -> Scene:
    """The quarter plate under ``stress`` [Pa], a strain of 1e-4 by default.

    ``body``: the quarter ``X, Y >= 0`` of the plate between ``Z = 0`` and its thickness, with tags
    ``hole``; ``symmetry_x`` in the plane X = 0 and ``symmetry_y`` in Y = 0; ``pull`` at
    ``Y = half_width`` and ``side`` at ``X = half_width``; ``back`` at Z = 0 and ``front``.
    ``thickness``: ``"plane_strain"`` has rollers on back and front; ``"free"`` on back alone, which
    makes it half of a plate with two free faces.  ``radius``, ``half_width`` [m] are those of the
    body.  ``rise`` and ``hold``: times in ``4 half_width / c_s``, ``c_s`` the shear wave speed:
    about 1.4 periods of the slowest mode of a square without a hole.

    Raises ``InputError`` for a ``thickness`` that is none of these, times or stresses that are not
    positive and finite, or a hole as wide as the plate.
    """
    if thickness not in ROLLERS:
        raise InputError(
            f"plate_with_hole: thickness {thickness!r} is not one of {sorted(ROLLERS)}"
        )
    for name, value in (("stress", stress), ("rise", rise), ("hold", hold)):
        require(
            math.isfinite(value) and value > 0.0,
            f"plate_with_hole: {name} = {value} must be positive and finite",
        )
    strip = gross_concentration(radius=radius, half_width=half_width)
    material = NeoHookean.from_young(
        young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density
    )
    unit = 4.0 * half_width / math.sqrt(material.mu / material.density)
    return Scene(
        name=f"plate_with_hole_{thickness}",
        body=body,
        material=material,
        end_time=(rise + hold) * unit,
        constraints=tuple(Constraint(face, "normal") for face in ROLLERS[thickness]),
        tractions=(Traction("pull", SlowPull(stress, rise * unit)),),
        probes={
            "hole_side": (radius, 0.0, 0.0),
            "hole_top": (0.0, radius, 0.0),
            "pulled_middle": (0.0, half_width, 0.0),
            "pulled_corner": (half_width, half_width, 0.0),
        },
        provenance=(
            "Not in [Lee2017]. Published: 3 for an infinite plate [Kirsch1898], "
            f"{strip:.3f} of the gross section for a long strip of this width [Heywood1952]. "
            f"Chosen: a square plate, steel, {stress:g} Pa, the rise and hold of the load, "
            f"thickness: {thickness}."
        ),
    )
