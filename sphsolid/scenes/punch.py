"""The punch test ([Lee2017] section 8.2, Figs. 9-12): a nearly incompressible block in a box.

A block of 1 (X) x 0.1 (Y) x 0.5 (Z, height) m has rollers on all faces but the top, and a region
of it gets the velocity ``(0, 0, -10)`` m/s.  No exact solution; what is compared is how far the
top face goes down and bulges up.

Published: geometry, rollers, the velocity and that it acts "on a region of the top face", E, nu,
rho0, the lattices 21x11x3 and 41x21x4 (X, Z, Y), 0.015 s for the comparison.  Not published: the
region, and whether the velocity is an initial value or stays.  Ours, as options:

* ``InitialVelocity``, the primary choice: the half ``X <= 0.5``, over the whole depth;
* ``HeldVelocity``: ``X <= 0.5`` of the top face moves down at that speed for good and slides under
  the punch.  Only this one leads to the "extremely large distortions" of Fig. 12.

The cells are nominally 1.3 spacings wide in Y, which makes 1/20 and 1/40 the published lattices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.errors import InputError, require
from sphsolid.geometry.body import Body, Box, Region, Tagged
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene

Array = NDArray[np.float64]
LENGTH, DEPTH, HEIGHT = 1.0, 0.1, 0.5
ROLLERS = tuple(Constraint(face, "normal") for face in ("X-", "X+", "Y-", "Y+", "Z-"))


@dataclass(frozen=True)
class Downward:
    """``(0, 0, -speed)`` [m/s] everywhere and at all times."""

    speed: float

    def __call__(self, X: Array, t: float = 0.0) -> Array:
        """The velocity ``(n, 3)``."""
        return np.tile([0.0, 0.0, -self.speed], (len(X), 1))


@dataclass(frozen=True)
class UpTo:
    """Points with ``X <= limit`` [m], a plane of particles on the limit included."""

    limit: float

    def __call__(self, X: Array) -> NDArray[np.bool_]:
        """True ``(n,)`` inside."""
        return np.asarray(X[:, 0] <= self.limit + 1.0e-9)


@dataclass(frozen=True)
class InitialVelocity:
    """The region ``X <= limit`` [m] starts with the velocity and is then left alone.

    ``where``: ``"height"`` all particles of that part of the block, ``"top"`` those of its top
    face only (a momentum that vanishes with the spacing).
    """

    limit: float = 0.5
    where: Literal["height", "top"] = "height"

    def __post_init__(self) -> None:
        _check_limit(self.limit)
        if self.where not in ("height", "top"):
            raise InputError(f"InitialVelocity: where {self.where!r} is not one of 'height', 'top'")

    def region(self, X: Array) -> NDArray[np.bool_]:
        """Which points ``(n,)`` get the velocity."""
        inside = UpTo(self.limit)(X)
        return inside & (X[:, 2] >= HEIGHT - 1.0e-9) if self.where == "top" else inside


@dataclass(frozen=True)
class PressedDown:
    """The velocity in the region of ``press``, zero elsewhere."""

    press: InitialVelocity
    velocity: Downward

    def __call__(self, X: Array) -> Array:
        """The velocity ``(n, 3)``."""
        return np.where(self.press.region(X)[:, None], self.velocity(X), 0.0)


@dataclass(frozen=True)
class HeldVelocity:
    """``X <= limit`` [m] of the top face moves with the velocity for good; tag ``pressed``.

    ``direction``: ``"normal"`` slides under the punch, ``"all"`` sticks to it.
    """

    limit: float = 0.5
    direction: Literal["normal", "all"] = "normal"

    def __post_init__(self) -> None:
        _check_limit(self.limit)
        if self.direction not in ("normal", "all"):
            raise InputError(
                f"HeldVelocity: direction {self.direction!r} is not one of 'normal', 'all'; "
                "'tangential' would not press"
            )


def _check_limit(limit: float) -> None:
    require(
        0.0 < limit <= LENGTH,
        f"punch: limit = {limit} m of the pressed region is outside (0, {LENGTH:g}]",
    )


Press = InitialVelocity | HeldVelocity


def punch(
    *,
    press: Press | None = None,
    speed: float = 10.0,
    young_modulus: float = 1.0e6,
    poisson_ratio: float = 0.499,
    density: float = 1000.0,
    end_time: float = 0.015,
    jitter: float = 0.0,
    seed: int = 0,
    body: Body | None = None,
) -> Scene:
    """The block pressed by ``press`` (default ``InitialVelocity()``) with ``speed`` [m/s].

    ``body``: the block ``[0, LENGTH] x [0, DEPTH] x [0, HEIGHT]`` with faces ``X- X+ Y- Y+ Z- Z+``
    in another mesh or cloud than ``block(jitter=jitter, seed=seed)``.  Raises ``InputError`` for a
    non-finite speed, a ``press`` that is not one of the options, a body of another volume, or a
    body and a jitter.
    """
    press = InitialVelocity() if press is None else press
    require(math.isfinite(speed), f"punch: speed = {speed} m/s must be finite")
    body = block(jitter=jitter, seed=seed) if body is None else _checked(body, jitter)
    if isinstance(press, InitialVelocity):
        initial, constraints = PressedDown(press, Downward(speed)), ROLLERS
    elif isinstance(press, HeldVelocity):
        body = Tagged(body, (Region("pressed", "Z+", UpTo(press.limit)),))
        on_top = InitialVelocity(press.limit, where="top")
        initial = PressedDown(on_top, Downward(speed))
        # First, so that along its edges the punch and not a roller says what moves.
        constraints = (Constraint("pressed", press.direction, Downward(speed)), *ROLLERS)
    else:
        raise InputError(
            f"punch: press = {press!r} is not an option; use InitialVelocity() or HeldVelocity()"
        )
    return Scene(
        name=f"punch_{'held' if isinstance(press, HeldVelocity) else 'initial'}",
        body=body,
        material=NeoHookean.from_young(
            young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density
        ),
        end_time=end_time,
        initial_velocity=initial,
        constraints=constraints,
        probes={
            "pressed_corner": (0.0, 0.0, HEIGHT),
            "top_centre": (0.5 * LENGTH, 0.0, HEIGHT),
            "free_corner": (LENGTH, 0.0, HEIGHT),
        },
        provenance=(
            "Published: geometry, rollers, speed, E, nu, rho0, lattices [Lee2017 section 8.2]. "
            f"Not published: region and duration of the velocity; chosen: {press}."
        ),
    )


def block(*, jitter: float = 0.0, seed: int = 0) -> Box:
    """The undeformed block, for a lattice or, with ``jitter``, for disordered particles."""
    return Box(
        (0.0, 0.0, 0.0),
        (LENGTH, DEPTH, HEIGHT),
        jitter=jitter,
        seed=seed,
        aspect=(1.0, 1.3, 1.0),
    )


def _checked(body: Body, jitter: float) -> Body:
    require(
        jitter == 0.0,
        f"punch: jitter = {jitter} is for the block of its own, and a body is given; disorder "
        "that one",
    )
    wanted = block().volume
    require(
        math.isclose(body.volume, wanted, rel_tol=1.0e-6),
        f"punch: the body holds {body.volume:.6g} m^3 and the block {wanted:g} m^3; give a mesh or "
        f"cloud of the block, {LENGTH:g} x {DEPTH:g} x {HEIGHT:g} m from the origin (check units)",
    )
    return body
