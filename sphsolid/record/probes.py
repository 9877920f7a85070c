"""Are the probes of a scene where its body is?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.scene import Scene

Array = NDArray[np.float64]
#: A length more than this share of a spacing is more than a spacing.
_SLACK = 1.0 + 1.0e-9
#: What a place, or a body, may have been given in [m].
_UNITS = {"millimetres": 1.0e-3, "centimetres": 1.0e-2, "inches": 0.0254}


def check_probes(scene: Scene, mesh: Mesh) -> None:
    """Raise ``InputError`` for a probe further than a spacing from the body, with its distance.

    The distance is that to the nearest of the cells' bounding boxes: never more than that to the
    body, and less by a part of a cell where cells are slanted.
    """
    if not scene.probes:
        return
    corners = mesh.vertices[mesh.cells]
    low, high = corners.min(axis=1), corners.max(axis=1)
    for name, place in scene.probes.items():
        point = np.asarray(place)
        distance = _distance(point, low, high)
        if distance > _SLACK * mesh.widest:
            raise InputError(
                f"scene {scene.name!r}: probe {name!r} at X = {list(place)} m is {distance:.4g} m "
                f"from the body, more than a spacing ({mesh.widest:.4g} m); the body reaches from "
                f"{low.min(axis=0).tolist()} to {high.max(axis=0).tolist()} m: "
                + _advice(point, low, high, mesh.widest)
            )


def _distance(point: Array, low: Array, high: Array) -> float:
    outside = np.maximum(0.0, np.maximum(low - point, point - high))
    return float(np.sqrt(np.min(np.sum(outside**2, axis=1))))


def _advice(point: Array, low: Array, high: Array, spacing: float) -> str:
    size = max(float(np.abs(low).max()), float(np.abs(high).max()))
    reach = float(np.abs(point).max())
    if reach > 10.0 * size:
        for unit, metres in reversed(_UNITS.items()):
            if _distance(metres * point, low, high) <= _SLACK * spacing:
                return f"give the place in metres (it would fit as {unit})"
    if reach < 0.1 * size:
        for unit, metres in _UNITS.items():
            if _distance(point / metres, low, high) <= _SLACK * spacing:
                return f"give both in metres (it would fit if the body were in {unit})"
    return "give the place of a point of the undeformed body"
