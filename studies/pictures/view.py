"""Views: how a deformed body is laid flat on paper, by orthographic projection.

Lengths on paper are lengths of the body, in every panel and at every depth, so pictures can be
compared and measured.  ``mplot3d`` is not used: it shrinks what it draws to a fraction of its
axes and sorts the faces of a whole collection only together with its perspective.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sphsolid.errors import InputError, require

Array = NDArray[np.float64]
_AXES = {"x": 0, "y": 1, "z": 2}
_UNIT = np.eye(3)


@dataclass(frozen=True)
class View:
    """An orthographic camera: unit vectors to the ``right``, ``up`` and ``towards`` the viewer.

    They are orthonormal and right-handed: ``right x up = towards``.  Use :func:`flat_view` or
    :func:`angled_view`.
    """

    right: tuple[float, float, float]
    up: tuple[float, float, float]
    towards: tuple[float, float, float]

    @property
    def rotation(self) -> Array:
        """Rows ``right``, ``up``, ``towards`` ``(3, 3)``: body to picture coordinates."""
        return np.array([self.right, self.up, self.towards], dtype=float)

    def project(self, x: ArrayLike) -> Array:
        """``(..., 3)`` [m] as seen: to the right, up, and towards the viewer (depth)."""
        return np.asarray(np.asarray(x, dtype=float) @ self.rotation.T)


def flat_view(*, right: str = "x", up: str = "z") -> View:
    """Along an axis: the default looks along +Y at the X-Z plane.

    ``right`` and ``up`` name axes of the body, ``x y z``; raises ``InputError`` for others.
    """
    first, second = _axis(right), _axis(up)
    require(
        first != second, f"flat_view: right and up are both {right!r}; give two different axes"
    )
    return _view(_UNIT[first], _UNIT[second])


def angled_view(*, up: str = "y", azimuth: float = -58.0, elevation: float = 14.0) -> View:
    """From the side and above: ``azimuth`` about the ``up`` axis, ``elevation`` [degree].

    At azimuth 0 the viewer stands on the axis that follows ``up`` (``x y z x``), at 90 on the one
    after.  Raises ``InputError`` for an unknown axis or an elevation outside (-90, 90).
    """
    axis = _axis(up)
    require(
        -90.0 < elevation < 90.0,
        f"angled_view: elevation = {elevation} degree is outside (-90, 90); use flat_view to look "
        "straight down",
    )
    a, e = np.radians([azimuth, elevation])
    towards = (
        np.cos(e) * (np.cos(a) * _UNIT[(axis + 1) % 3] + np.sin(a) * _UNIT[(axis + 2) % 3])
        + np.sin(e) * _UNIT[axis]
    )
    right = np.cross(_UNIT[axis], towards)
    right /= np.linalg.norm(right)
    return _view(right, np.cross(towards, right))


def _view(right: Array, up: Array) -> View:
    a, b, c = (tuple(float(v) for v in vector) for vector in (right, up, np.cross(right, up)))
    return View(right=a, up=b, towards=c)  # type: ignore[arg-type]


def _axis(name: str) -> int:
    if name not in _AXES:
        raise InputError(f"view: axis {name!r} is none of x, y, z")
    return _AXES[name]


@dataclass(frozen=True)
class Window:
    """What part of the picture plane a panel shows: ``width`` and ``height`` [m].

    With ``follow`` a panel is centred on its body, else on ``centre`` [m] in picture coordinates.
    """

    width: float
    height: float
    centre: tuple[float, float] = (0.0, 0.0)
    follow: bool = False

    def of(self, positions: Iterable[ArrayLike], view: View) -> Window:
        """The window itself, whatever is drawn."""
        return self

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
        boxes = []
        for x in positions:
            seen = view.project(x)[:, :2]
            seen = seen[np.isfinite(seen).all(axis=1)]
            if len(seen):
                boxes.append((seen.min(axis=0), seen.max(axis=0)))
        require(len(boxes) > 0, "picture: none of the frames has a finite position to draw")
        low, high = np.array([box[0] for box in boxes]), np.array([box[1] for box in boxes])
        size = high.max(axis=0) - low.min(axis=0)
        centre = 0.5 * (high.max(axis=0) + low.min(axis=0))
        if self.follow:
            size, centre = (high - low).max(axis=0), np.zeros(2)
        # A body seen edge on still gets a panel one can see.
        size = np.maximum(size, 0.02 * max(float(size.max()), 1e-300))
        size = size + 2.0 * self.margin * size.max()
        return Window(
            float(size[0]), float(size[1]), (float(centre[0]), float(centre[1])), self.follow
        )
