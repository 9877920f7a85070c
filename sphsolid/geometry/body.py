"""Bodies: the region a scene is about, able to mesh itself at any spacing."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from numbers import Real
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.grid_mesh import Block, Triple, block_breaks, block_mesh, box_mesh, covered
from sphsolid.geometry.mesh import GridMesh, Mesh


@dataclass(frozen=True)
class AsMeshed:
    """No spacing is asked for: the body comes with its own points."""


Spacing = float | AsMeshed
#: The one there is: what a caller who gives no spacing asks for.
AS_MESHED = AsMeshed()


def chosen(spacing: Spacing, body: str) -> float:
    """The spacing of a body that can be meshed at any; raises ``InputError`` if none is given."""
    if isinstance(spacing, AsMeshed):
        raise InputError(f"{body} can be meshed at any spacing: give spacing = ... [m]")
    given: object = spacing
    if isinstance(given, bool) or not isinstance(given, Real):
        raise InputError(f"spacing = {spacing!r} is not a number; give a length in m")
    return spacing


class Body(Protocol):
    """Anything that can be meshed."""

    def mesh(self, spacing: Spacing) -> Mesh:
        """Cells of about ``spacing`` [m], or of its own, with tagged boundary faces."""
        ...

    @property
    def volume(self) -> float:
        """Exact volume [m^3]."""
        ...


@dataclass(frozen=True)
class Box:
    """Axis-aligned box with faces ``X- X+ Y- Y+ Z- Z+``; ``jitter`` disorders its particles.

    ``aspect``: edge of a cell along X, Y, Z over the spacing, before rounding to whole cells.
    """

    lower: Triple = (0.0, 0.0, 0.0)
    upper: Triple = (1.0, 1.0, 1.0)
    jitter: float = 0.0
    seed: int = 0
    aspect: Triple = (1.0, 1.0, 1.0)

    def mesh(self, spacing: Spacing) -> GridMesh:
        """See :func:`sphsolid.geometry.grid_mesh.box_mesh`."""
        edge = chosen(spacing, "a Box")
        return box_mesh(self.lower, self.upper, edge, self.jitter, self.seed, self.aspect)

    @property
    def volume(self) -> float:
        """Product of the edge lengths [m^3]."""
        volume = 1.0
        for low, high in zip(self.lower, self.upper, strict=True):
            volume *= high - low
        return volume


@dataclass(frozen=True)
class Blocks:
    """Union of axis-aligned boxes ``(lower, upper)`` [m] that meet in faces or overlap.

    Faces ``X- X+ Y- Y+ Z- Z+`` on its bounding box; others by direction and plane, ``X+@3``.
    ``jitter``, ``seed`` and ``aspect`` as for :class:`Box`.
    """

    blocks: tuple[Block, ...]
    jitter: float = 0.0
    seed: int = 0
    aspect: Triple = (1.0, 1.0, 1.0)

    def mesh(self, spacing: Spacing) -> GridMesh:
        """See :func:`sphsolid.geometry.grid_mesh.block_mesh`."""
        edge = chosen(spacing, "Blocks")
        return block_mesh(self.blocks, edge, self.jitter, self.seed, self.aspect)

    @property
    def volume(self) -> float:
        """Volume of the union [m^3]; what blocks share counts once."""
        x, y, z = (np.array(breaks) for breaks in block_breaks(self.blocks))
        sizes = np.diff(x)[:, None, None] * np.diff(y)[:, None] * np.diff(z)
        return math.fsum(sizes[covered(self.blocks, (x, y, z))])


@dataclass(frozen=True)
class Region:
    """A part of the boundary tag ``face`` with a tag ``name`` of its own.

    ``contains(X (n, 3)) -> (n,)`` is asked at the centroids of the face's quadrilaterals.
    """

    name: str
    face: str
    contains: Callable[[NDArray[np.float64]], NDArray[np.bool_]]


@dataclass(frozen=True)
class Tagged:
    """A body some of whose faces are split into named regions.

    A quadrilateral belongs to the first region that contains it and to no other tag; the face
    keeps the rest, if any is left.  So tags never overlap, and a condition on the whole face is
    one condition on each of its parts.
    """

    body: Body
    regions: tuple[Region, ...]

    def mesh(self, spacing: Spacing) -> Mesh:
        """The body's mesh with the regions' tags.

        Raises ``InputError`` for a name that is taken, an unknown face, an answer of the wrong
        shape, or a region without a quadrilateral at this spacing.
        """
        mesh = self.body.mesh(spacing)
        faces = dict(mesh.faces)
        for region in self.regions:
            require(
                region.name not in faces,
                f"region {region.name!r}: the name is taken; the body has {sorted(faces)}",
            )
            quads = replace(mesh, faces=faces).face(region.face)
            chosen = np.asarray(region.contains(mesh.vertices[quads].mean(axis=1)))
            if chosen.shape != (len(quads),) or chosen.dtype != bool:
                raise InputError(
                    f"region {region.name!r}: contains must return a bool for each of the "
                    f"{len(quads)} points, got {chosen.dtype} of shape {chosen.shape}"
                )
            require(
                bool(chosen.any()),
                f"region {region.name!r} contains no facet of face {region.face!r} at "
                f"spacing {mesh.spacing:g} m; refine, or enlarge the region",
            )
            faces[region.name] = quads[chosen]
            faces[region.face] = quads[~chosen]
            if chosen.all():
                del faces[region.face]
        return replace(mesh, faces=faces)

    @property
    def volume(self) -> float:
        """Volume of the body [m^3]."""
        return self.body.volume
