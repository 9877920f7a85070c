"""Deformed surfaces: the boundary faces of the background mesh, coloured by a field."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from sphsolid.scenes.hex_mesh import HexMesh

Array = NDArray[np.float64]
#: Light comes from here; faces that look away are darker, so that the form can be seen.
_LIGHT = np.array([0.35, -0.75, 0.55])


def draw_surface(
    axes: Any, mesh: HexMesh, x: Array, values: Array, scale: ScalarMappable, up: str = "y"
) -> None:
    """Add the boundary at positions ``x (N, 3)`` [m], each face in the colour of its mean value.

    ``values (N,)`` at the vertices.  ``up`` names the material axis that points up in the picture.
    """
    quads = mesh.boundary
    order = {"y": [2, 0, 1], "z": [0, 1, 2]}[up]
    corners = x[quads][:, :, order]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    shade = 0.72 + 0.28 * np.clip(normal @ (_LIGHT / np.linalg.norm(_LIGHT)), -1.0, 1.0)
    colours = scale.to_rgba(values[quads].mean(axis=1))
    colours[:, :3] = np.clip(colours[:, :3] * shade[:, None], 0.0, 1.0)
    axes.add_collection3d(
        Poly3DCollection(corners, facecolors=colours, edgecolors=(0, 0, 0, 0.25), linewidths=0.2)
    )


def frame_axes(axes: Any, low: Array, high: Array, up: str = "y") -> None:
    """Equal axes around the box ``low .. high`` [m], no panes, a view from the side."""
    order = {"y": [2, 0, 1], "z": [0, 1, 2]}[up]
    low, high = low[order], high[order]
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=0.9)
    axes.set_axis_off()
    axes.view_init(elev=14.0, azim=-58.0)


def pressure_scale(limit: float) -> ScalarMappable:
    """Symmetric diverging colours for pressures in ``-limit .. limit`` [Pa]."""
    return ScalarMappable(Normalize(-limit, limit), "RdBu_r")
