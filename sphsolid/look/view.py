"""Views: how a deformed body is laid flat on paper, by orthographic projection.

Lengths on paper are lengths of the body, in every panel and at every depth, so pictures can be
compared and measured.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sphsolid.errors import InputError, require

Array = NDArray[np.float64]
_UNIT = dict(zip("xyz", np.eye(3), strict=True))


@dataclass(frozen=True)
class View:
    """An orthographic camera; rows of ``rotation (3, 3)``: right, up, towards the viewer.

    They are orthonormal and right-handed.  Use :func:`flat_view` or :func:`angled_view`.
    """

    rotation: tuple[tuple[float, ...], ...]

    def project(self, x: ArrayLike) -> Array:
        """``(..., 3)`` [m] as seen: to the right, up, and towards the viewer (depth)."""
        return np.asarray(np.asarray(x, dtype=float) @ np.array(self.rotation).T)


def flat_view(*, right: str = "x", up: str = "z") -> View:
    """Along an axis: the default looks along +Y at the X-Z plane.

    ``right`` and ``up`` name axes of the body, ``x y z``; raises ``InputError`` for others.
    """
    require(right != up, f"flat_view: right and up are both {right!r}; give two different axes")
    return _view(_axis(right), _axis(up))


def angled_view(*, up: str = "y", azimuth: float = -58.0, elevation: float = 14.0) -> View:
    """From the side and above: ``azimuth`` about the ``up`` axis, ``elevation`` [degree].

    At azimuth 0 the viewer stands on the axis that follows ``up`` (``x y z x``), at 90 on the one
    after.  Raises ``InputError`` for an unknown axis or an elevation outside (-90, 90).
    """
    upward = _axis(up)
    require(
        -90.0 < elevation < 90.0,
        f"angled_view: elevation = {elevation} degree is outside (-90, 90); use flat_view to look "
        "straight down",
    )
    first = np.roll(upward, 1)
    a, e = np.radians([azimuth, elevation])
    towards = np.cos(e) * (np.cos(a) * first + np.sin(a) * np.roll(first, 1)) + np.sin(e) * upward
    right = np.cross(upward, towards)
    right /= np.linalg.norm(right)
    return _view(right, np.cross(towards, right))


def _view(right: Array, up: Array) -> View:
    rows = (right, up, np.cross(right, up))
    return View(tuple(tuple(float(v) for v in row) for row in rows))


def _axis(name: str) -> Array:
    if name not in _UNIT:
        raise InputError(f"view: axis {name!r} is none of x, y, z")
    return _UNIT[name]


@dataclass(frozen=True)
class Window:
    """What part of the picture plane a panel shows: ``width`` and ``height`` [m].

    With ``follow`` a panel is centred on its body, else on ``centre`` [m] in picture coordinates.
    """

    width: float
    height: float
    centre: tuple[float, float] = (0.0, 0.0)
    follow: bool = False

    def limits(self, seen: Array) -> tuple[tuple[float, float], tuple[float, float]]:
        """Axis limits for a body projected to ``seen (n, 3)``."""
        a, b = self.centre
        if self.follow:
            a, b = 0.5 * (seen[:, :2].min(axis=0) + seen[:, :2].max(axis=0))
        w, h = 0.5 * self.width, 0.5 * self.height
        return (float(a - w), float(a + w)), (float(b - h), float(b + h))


@dataclass(frozen=True)
class Around:
    """The smallest window that holds every body, with ``margin`` around it, a share of its size.

    With ``follow`` it holds each when centred on it, which suits bodies that travel.
    """

    follow: bool = False
    margin: float = 0.03

    def of(self, positions: Iterable[ArrayLike], view: View) -> Window:
        """The window for ``positions``, arrays ``(n, 3)`` [m].

        Raises ``InputError`` where nothing finite is to be seen.
        """
        seen = [view.project(x)[:, :2] for x in positions]
        seen = [x[np.isfinite(x).all(axis=1)] for x in seen]
        boxes = np.array([(x.min(axis=0), x.max(axis=0)) for x in seen if len(x)])
        require(len(boxes) > 0, "picture: none of the frames has a finite position to draw")
        low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
        size, centre = high - low, 0.5 * (high + low)
        if self.follow:
            size, centre = (boxes[:, 1] - boxes[:, 0]).max(axis=0), np.zeros(2)
        # A body seen edge on still gets a panel one can see.
        size = np.maximum(size, 0.02 * max(float(size.max()), 1e-300))
        width, height = size + 2.0 * self.margin * size.max()
        middle = (float(centre[0]), float(centre[1]))
        return Window(float(width), float(height), middle, self.follow)
