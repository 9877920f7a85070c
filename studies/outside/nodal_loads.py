"""Tractions as forces of nodes: ``f_a(t) = int N_a t_B dA``, in the undeformed state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import require
from sphsolid.scenes import Scene, Traction
from studies.outside.hexahedra import QuadraticHexahedra, face_shapes

Array = NDArray[np.float64]
#: Gauss's three points a direction: exact for the product of a shape and a quadratic traction.
_POINTS = ((-np.sqrt(0.6), 5.0 / 9.0), (0.0, 8.0 / 9.0), (np.sqrt(0.6), 5.0 / 9.0))
#: A load is a product of functions of place and time when it is so to within this share.
_SEPARATE = 1.0e-9


@dataclass(frozen=True)
class History:
    """``force (n, 3)`` [N] on ``nodes (n,)``, times ``amplitude (T,)``."""

    nodes: NDArray[np.int64]
    force: Array
    amplitude: Array


def nodal_history(
    scene: Scene, traction: Traction, elements: QuadraticHexahedra, times: Array
) -> History:
    """The forces of ``traction`` at ``times (T,)`` [s]; dead loads, as the scene states them.

    Raises ``InputError`` for an unknown face and for a traction that is no product of a function of
    place and one of time.
    """
    require(
        traction.face in elements.faces,
        f"deck of scene {scene.name!r}: the body has no face {traction.face!r}, only "
        f"{sorted(elements.faces)}",
    )
    loops = elements.faces[traction.face]
    X = elements.nodes[loops]
    at = []
    for r, by_r in _POINTS:
        for s, by_s in _POINTS:
            N, slope = face_shapes(r, s)
            along, across = (np.einsum("a,fai->fi", slope[:, d], X) for d in (0, 1))
            area = np.cross(along, across)
            size = np.linalg.norm(area, axis=1)
            at.append((by_r * by_s * size, area / size[:, None], N, np.einsum("a,fai->fi", N, X)))
    nodes = np.unique(loops)
    place = np.searchsorted(nodes, loops)
    forces = np.zeros((len(times), len(nodes), 3))
    for k, t in enumerate(times):
        for weight, normal, N, point in at:
            load = weight[:, None] * traction.at(point, normal, float(t))
            np.add.at(forces[k], place, N[None, :, None] * load[:, None, :])
    largest = int(np.argmax(np.abs(forces).sum(axis=(1, 2))))
    force = forces[largest]
    size_of = float(np.sum(force**2))
    if size_of == 0.0:
        return History(nodes, force, np.zeros(len(times)))
    amplitude = np.einsum("tai,ai->t", forces, force) / size_of
    rest = forces - amplitude[:, None, None] * force
    require(
        float(np.abs(rest).max()) <= _SEPARATE * float(np.abs(force).max()),
        f"deck of scene {scene.name!r}: the traction on {traction.face!r} is no product of a "
        "function of place and one of time; a deck has one amplitude a load",
    )
    return History(nodes, force, amplitude)
