"""Draws the surface of a body in two-dimensional axes.

The painter's way: what looks away is left out, the rest is painted from far to near.  Each
boundary quadrilateral is first cut into small bilinear ones, so that colours run smoothly and the
order by mean depth is right also where long faces pass each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

from sphsolid.errors import require
from sphsolid.look.frame import Shot
from sphsolid.look.view import View

Array = NDArray[np.float64]
#: Towards the light, in picture coordinates (right, up, towards the viewer).
_LIGHT = np.array([-0.45, 0.45, 0.77])
_LINE = (0.0, 0.0, 0.0, 0.42)
#: Most pieces along an edge.
FINEST = 8


@dataclass(frozen=True)
class Surface:
    """The boundary of the background mesh, coloured by the values at its vertices.

    ``lines`` [point]: width of the lines of the mesh, 0 for none.  ``detail``: about how many
    pieces the boundary is cut into.  ``shading`` from 0 (the colours of the bar, everywhere) to 1:
    how much darker a face is that looks away from the light.
    """

    lines: float = 0.25
    detail: int = 20000
    shading: float = 0.22

    def __post_init__(self) -> None:
        require(self.lines >= 0.0, f"Surface: lines = {self.lines} points must not be negative")
        require(self.detail >= 1, f"Surface: detail = {self.detail} must be at least 1")
        require(
            0.0 <= self.shading <= 1.0, f"Surface: shading = {self.shading} is outside [0, 1]"
        )

    def draw(self, axes: Any, shot: Shot, view: View, scale: ScalarMappable, name: str) -> None:
        """Add the surface, coloured by field ``name``, to ``axes`` (in metres)."""
        pieces = int(np.clip(np.sqrt(self.detail / max(1, len(shot.quads))), 1, FINEST))
        faces = seen_faces(shot, view, shot.value(name).astype(float), pieces=pieces)
        colours = scale.to_rgba(faces.values)
        light = np.clip(faces.normals @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
        colours[:, :3] *= (1.0 - self.shading * (1.0 - light))[:, None]
        polygons, depth = faces.corners[..., :2], faces.corners[..., 2].mean(axis=1)
        # A hairline of its own colour closes the gaps that antialiasing leaves between faces.
        borders, widths = colours, np.full(len(polygons), 0.3)
        if self.lines > 0.0:
            lines = _lines(faces.loops, pieces)
            # A line flattened to a polygon, and just nearer than the faces it belongs to.
            polygons = np.concatenate([polygons, lines[:, [0, 1, 1, 0], :2]])
            reach = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
            depth = np.concatenate([depth, lines[..., 2].mean(axis=1) + 0.6 * reach])
            none = np.zeros((len(lines), 4))
            colours = np.concatenate([colours, none])
            borders = np.concatenate([borders, np.broadcast_to(_LINE, none.shape)])
            widths = np.concatenate([widths, np.full(len(lines), self.lines)])
        order = np.argsort(depth, kind="stable")
        axes.add_collection(
            PolyCollection(
                list(polygons[order]),
                facecolors=colours[order],
                edgecolors=borders[order],
                linewidths=widths[order],
                joinstyle="round",
                capstyle="round",
                # Thousands of pieces: an image inside a vector file.
                rasterized=True,
            ),
            autolim=False,
        )


@dataclass(frozen=True, eq=False)
class SeenFaces:
    """Pieces of the surface that face the viewer, in picture coordinates (right, up, depth) [m].

    ``corners (n, 4, 3)``, ``values (n,)`` at their centres, unit ``normals (n, 3)``; ``loops
    (m, 4, 3)`` the whole quadrilaterals of which some piece is seen, ``seen (f,)`` which they are.
    """

    corners: Array
    values: Array
    normals: Array
    loops: Array
    seen: NDArray[np.bool_]


def seen_faces(shot: Shot, view: View, values: Array, *, pieces: int = 1) -> SeenFaces:
    """Cut the boundary into pieces and leave out those that look away or are not finite."""
    whole = view.project(shot.x[shot.quads])
    whole_values = values[shot.quads]
    finite = np.isfinite(whole).all(axis=(1, 2)) & np.isfinite(whole_values).all(axis=1)
    whole, whole_values = whole[finite], whole_values[finite]
    cut = np.linspace(0.0, 1.0, pieces + 1)
    grid = _bilinear(whole, cut)
    corners = np.stack(
        [grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:]], axis=3
    )
    centres = _bilinear(whole_values[..., None], 0.5 * (cut[1:] + cut[:-1]))[..., 0]
    normals = np.cross(
        corners[..., 2, :] - corners[..., 0, :], corners[..., 3, :] - corners[..., 1, :]
    )
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-300)
    # Round-off must not decide about faces that are seen edge on.
    facing = normals[..., 2] > 1e-6
    seen = np.zeros(len(shot.quads), dtype=bool)
    seen[finite] = facing.any(axis=(1, 2))
    return SeenFaces(
        corners=corners[facing],
        values=centres[facing],
        normals=normals[facing],
        loops=whole[facing.any(axis=(1, 2))],
        seen=seen,
    )


def _bilinear(quads: Array, at: Array) -> Array:
    """``quads (m, 4, k)`` interpolated at all pairs of ``at (n,)``: ``(m, n, n, k)``."""
    u, v = at[:, None], at[None, :]
    shapes = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
    return np.einsum("cuv,mck->muvk", shapes, quads)


def _lines(loops: Array, pieces: int) -> Array:
    """Edges of quadrilaterals ``(m, 4, 3)``, each once, cut into pieces: ``(n, 2, 3)``."""
    ends = np.stack([loops, np.roll(loops, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    # A triangle is a quadrilateral with an edge of no length.
    ends = ends[(ends[:, 0] != ends[:, 1]).any(axis=1)]
    # The same edge of two faces has the same ends in the other order.
    middle = np.round(ends.sum(axis=1), 9)
    ends = ends[np.unique(middle, axis=0, return_index=True)[1]]
    cut = np.linspace(0.0, 1.0, pieces + 1)[:, None]
    points = ends[:, None, 0] * (1.0 - cut) + ends[:, None, 1] * cut
    return np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3)
