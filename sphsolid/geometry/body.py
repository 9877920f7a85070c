"""Bodies: the region a scene is about, able to mesh itself at any spacing."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.blocks import Block, block_breaks, checked_blocks, checked_box, covered
from sphsolid.geometry.given import Triple
from sphsolid.geometry.grid_mesh import block_mesh, box_mesh
from sphsolid.geometry.mesh import GridMesh, Mesh, read_only
from sphsolid.protocols import check_protocol, members, number

Array = NDArray[np.float64]


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
    return number("spacing", spacing, "m")


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
        for low, high in zip(*checked_box(self.lower, self.upper), strict=True):
            volume *= high - low
        return volume


@dataclass(frozen=True)
class Blocks:
    """Union of axis-aligned boxes ``(lower, upper)`` [m] that meet in faces or overlap.

    Sides that differ by round-off, at most 1e-9 of the diagonal of the body, are in one plane.
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
        blocks = checked_blocks(self.blocks)
        x, y, z = (np.array(breaks) for breaks in block_breaks(blocks))
        sizes = np.diff(x)[:, None, None] * np.diff(y)[:, None] * np.diff(z)
        return math.fsum(sizes[covered(blocks, (x, y, z))])


@dataclass(frozen=True)
class Region:
    """A part of the boundary tag ``face`` with a tag ``name`` of its own.

    ``contains(X (n, 3)) -> (n,)`` is asked at the centroids of the face's quadrilaterals.  It
    cannot write to them.
    """

    name: str
    face: str
    contains: Callable[[Array], NDArray[np.bool_]]

    def at(self, X: Array) -> NDArray[np.bool_]:
        """Which of the points ``X (n, 3)`` [m] are in the region ``(n,)``.

        Raises ``InputError`` naming the region where ``contains`` fails or returns anything but a
        bool for each point.
        """
        try:
            chosen = np.asarray(self.contains(read_only(X)))
        except Exception as failure:
            how = "; it is called with (X)" if isinstance(failure, TypeError) else ""
            raise InputError(
                f"region {self.name!r}: contains raised {type(failure).__name__}: {failure}{how}"
            ) from failure
        if chosen.shape != (len(X),) or chosen.dtype != bool:
            raise InputError(
                f"region {self.name!r}: contains must return a bool for each of the "
                f"{len(X)} points, got {chosen.dtype} of shape {chosen.shape}"
            )
        return chosen


@dataclass(frozen=True)
class Tagged:
    """A body some of whose faces are split into named regions.

    A quadrilateral belongs to the first region that contains it and to no other tag; the face
    keeps the rest, if any is left.  So tags never overlap, and a condition on the whole face is
    one condition on each of its parts.
    """

    body: Body
    regions: tuple[Region, ...]

    def __post_init__(self) -> None:
        """Refuse what is no body, or no tuple of regions."""
        check_protocol("Tagged: body", self.body, ("mesh",), "give Box(...) or another body")
        object.__setattr__(self, "regions", members("regions", self.regions, Region))

    def mesh(self, spacing: Spacing) -> Mesh:
        """The body's mesh with the regions' tags.

        Raises ``InputError`` for a name that is no string or taken, an unknown face, a region
        whose ``contains`` fails (:meth:`Region.at`) or has no quadrilateral at this spacing.
        """
        mesh = self.body.mesh(spacing)
        faces = dict(mesh.faces)
        for region in self.regions:
            require(
                isinstance(region.name, str) and isinstance(region.face, str),
                f"region {region.name!r} of face {region.face!r}: give two names",
            )
            require(
                region.name not in faces,
                f"region {region.name!r}: the name is taken; the body has {sorted(faces)}",
            )
            quads = replace(mesh, faces=faces).face(region.face)
            chosen = region.at(mesh.vertices[quads].mean(axis=1))
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
