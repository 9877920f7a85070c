"""Closed surfaces of known bodies: the boundary of a grid of cubes, mapped."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry import Body, Box, Surface

Array = NDArray[np.float64]


def boundary(
    body: Body, spacing: float, mapping: Callable[[Array], Array] | None = None
) -> Surface:
    """The triangulated boundary of a body's mesh, its vertices moved by ``mapping``."""
    mesh = body.mesh(spacing)
    vertices = mesh.vertices if mapping is None else mapping(mesh.vertices)
    return Surface.closed(vertices=vertices, faces=mesh.faces)


def to_disc(X: Array) -> Array:
    """The square ``[-1, 1]^2`` to the unit disc, along rays; Z stays."""
    largest = np.max(np.abs(X[:, :2]), axis=1, keepdims=True)
    length = np.linalg.norm(X[:, :2], axis=1, keepdims=True)
    scale = np.divide(largest, length, out=np.ones_like(length), where=length > 0.0)
    return np.concatenate([X[:, :2] * scale, X[:, 2:]], axis=1)


def to_ball(X: Array) -> Array:
    """The cube ``[-1, 1]^3`` to the unit ball, along rays."""
    largest = np.max(np.abs(X), axis=1, keepdims=True)
    length = np.linalg.norm(X, axis=1, keepdims=True)
    return X * np.divide(largest, length, out=np.ones_like(length), where=length > 0.0)


def sphere(spacing: float) -> Surface:
    """A unit sphere about the origin."""
    return boundary(Box((-1.0,) * 3, (1.0,) * 3), spacing, to_ball)


def cylinder(spacing: float) -> Surface:
    """A cylinder of radius 1 and height 1 with faces ``Z-`` and ``Z+``, its axis Z."""
    return boundary(Box((-1.0, -1.0, 0.0), (1.0, 1.0, 1.0)), spacing, to_disc)
