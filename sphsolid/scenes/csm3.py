"""An elastic beam that swings under its weight: CSM3 of Turek and Hron [Turek2006].

A beam of ``0.35 x 0.02`` m along X is clamped at ``X = 0``.  It starts at rest and undeformed, and
gravity of ``g`` along ``-Y`` acts from the start.  Nothing damps it, so it swings for good.  Strain
is plane: the beam is some layers of cells thick, with rollers on ``Z-`` and ``Z+``.

Published: the vertical displacement of the middle of the free end, ``-63.607 +- 65.160`` mm at
1.0995 Hz [Turek2006].  The series that the authors give beside it goes down to -129.64 mm at
0.455 s, and to -129.73 mm in later swings.

Published: sizes, density, Young's modulus, Poisson's ratio, gravity, the law (Saint
Venant-Kirchhoff).  There the beam is fixed to a cylinder of 0.05 m radius, so that its faces are
longer than its middle by 1 mm: ``OnCylinder()``.  Ours: a plane clamp, which makes it a box, the
number of layers, and the end of the run, after the first time that the tip is lowest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.saint_venant_kirchhoff import SaintVenantKirchhoff
from sphsolid.errors import InputError, require
from sphsolid.geometry.body import Body, Box, Spacing
from sphsolid.geometry.mesh import GridMesh
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene

Array = NDArray[np.float64]
LENGTH, HEIGHT = 0.35, 0.02


@dataclass(frozen=True)
class Weight:
    """The body force ``(0, -density gravity, 0)`` [N/m^3], everywhere and at all times."""

    density: float
    gravity: float

    def __call__(self, X: Array, t: float) -> Array:
        """The force ``(n, 3)``."""
        return np.tile([0.0, -self.density * self.gravity, 0.0], (len(X), 1))


@dataclass(frozen=True)
class PlaneClamp:
    """The clamp is the plane ``X = 0``, and the beam a box."""

    def body(self, box: Box) -> Body:
        """The box itself."""
        return box


@dataclass(frozen=True)
class OnCylinder:
    """The clamp is a cylinder about the Z direction, ``radius`` [m], that ``X = 0`` touches."""

    radius: float = 0.05

    def __post_init__(self) -> None:
        """Refuse a cylinder that the beam does not end on."""
        require(
            0.5 * HEIGHT < self.radius < math.inf,
            f"csm3: radius = {self.radius} m of the cylinder must exceed half the height of the "
            f"beam, {0.5 * HEIGHT:g} m",
        )

    def body(self, box: Box) -> Body:
        """The box, its end ``X = 0`` bent onto the cylinder."""
        return EndOnCylinder(box, self.radius)


@dataclass(frozen=True)
class EndOnCylinder:
    """``box``, stretched along X so that the face ``X-`` lies on the cylinder.

    With ``s(Y) = r - sqrt(r^2 - Y^2)`` a point goes from ``X`` to ``X - s (1 - X / L)``.
    """

    box: Box
    radius: float

    def mesh(self, spacing: Spacing) -> GridMesh:
        """The mesh of the box, moved; its tags are those of the box."""
        straight = self.box.mesh(spacing)
        X = straight.vertices.copy()
        sag = self.radius - np.sqrt(self.radius**2 - X[:, 1] ** 2)
        X[:, 0] -= sag * (1.0 - X[:, 0] / LENGTH)
        return replace(straight, vertices=X, is_lattice=False)

    @property
    def volume(self) -> float:
        """That of the box and of what lies between it and the cylinder [m^3]."""
        thickness, r, half = self.box.upper[2] - self.box.lower[2], self.radius, 0.5 * HEIGHT
        segment = half * math.sqrt(r * r - half * half) + r * r * math.asin(half / r)
        return self.box.volume + thickness * (r * HEIGHT - segment)


def csm3_spacing(points: int) -> float:
    """Spacing [m] of ``points`` across the height of the beam; ``InputError`` for less than two."""
    _check_count("points", points, 2)
    return HEIGHT / (points - 1)


def csm3(
    *,
    points: int = 9,
    layers: int = 1,
    clamp: PlaneClamp | OnCylinder = PlaneClamp(),
    gravity: float = 2.0,
    young_modulus: float = 1.4e6,
    poisson_ratio: float = 0.4,
    density: float = 1000.0,
    end_time: float = 0.5,
) -> Scene:
    """The beam, as thick as ``layers`` cells of a lattice with ``points`` across its height.

    Solve it with ``spacing = csm3_spacing(points)``; an odd number of points has one in the middle
    of the free end, the probe ``tip``.  ``gravity`` [m/s^2].  Raises ``InputError`` for less than
    two points or one layer, for a ``clamp`` that is none, and for a gravity that is not finite.
    """
    spacing = csm3_spacing(points)
    _check_count("layers", layers, 1)
    if not isinstance(clamp, PlaneClamp | OnCylinder):
        raise InputError(
            f"csm3: clamp = {clamp!r} is not an option; use PlaneClamp() or OnCylinder()"
        )
    require(math.isfinite(gravity), f"csm3: gravity = {gravity} m/s^2 must be finite")
    material = SaintVenantKirchhoff.from_young(
        young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density
    )
    return Scene(
        name="csm3",
        body=clamp.body(Box((0.0, -0.5 * HEIGHT, 0.0), (LENGTH, 0.5 * HEIGHT, layers * spacing))),
        material=material,
        end_time=end_time,
        body_force=Weight(material.density, float(gravity)),
        constraints=(
            Constraint("X-", "all"), Constraint("Z-", "normal"), Constraint("Z+", "normal")
        ),
        probes={"tip": (LENGTH, 0.0, 0.0), "middle": (0.5 * LENGTH, 0.0, 0.0)},
        provenance=(
            "Published: sizes, law, E, nu, rho0, gravity, plane strain, the clamp on a cylinder "
            f"[Turek2006]. Chosen: {clamp}, {points} points across the height, {layers} layer(s) "
            "of cells, end time."
        ),
    )  # fmt: skip


def _check_count(name: str, value: object, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise InputError(f"csm3: {name} = {value!r} must be a whole number of at least {least}")
