"""One face of a body in colour, from facets of any kind, quadrilaterals or triangles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from sphsolid.geometry.closed_surface import halves
from sphsolid.geometry.mesh import Mesh

Array = NDArray[np.float64]


def save_face(path: Path, mesh: Mesh, face: str, x: Array, values: Array) -> None:
    """Facets of a tag, where their vertices are, ``x (N, 3)`` [m], and ``values (N,)`` there."""
    facets = mesh.face(face)
    used, number = np.unique(facets, return_inverse=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, x=x[used], facets=number.reshape(facets.shape), values=values[used])


def draw_face(
    ax: Axes,
    path: Path,
    *,
    across: tuple[int, int] = (0, 1),
    limits: tuple[float, float],
    colour_map: str,
) -> Any:
    """Colour a face that :func:`save_face` kept, in the plane of two axes; gives what is drawn."""
    with np.load(path) as shot:
        drawn = draw_facets(
            ax, shot["x"][:, list(across)], shot["facets"], shot["values"],
            limits=limits, colour_map=colour_map,
        )  # fmt: skip
    names = "XYZ" if across == (0, 1) else "xyz"
    ax.set(xlabel=f"{names[across[0]]} [m]", ylabel=f"{names[across[1]]} [m]")
    return drawn


def draw_facets(
    ax: Axes,
    plane: Array,
    facets: NDArray[np.int64],
    values: Array,
    *,
    limits: tuple[float, float],
    colour_map: str,
) -> Any:
    """Colour facets ``(n, 3 or 4)`` by ``values (N,)`` at their vertices ``plane (N, 2)`` [m].

    Colours are linear between the vertices of a triangle; the edges of the facets are drawn.
    """
    drawn = ax.tripcolor(
        Triangulation(plane[:, 0], plane[:, 1], halves(facets)),
        values, shading="gouraud", cmap=colour_map, vmin=limits[0], vmax=limits[1],
        rasterized=True,
    )  # fmt: skip
    ax.add_collection(
        PolyCollection(
            list(plane[facets]), facecolors="none", edgecolors="black", linewidths=0.15, alpha=0.5
        )
    )
    ax.set(aspect="equal", xlabel="X [m]", ylabel="Y [m]")
    ax.grid(visible=False)
    return drawn
