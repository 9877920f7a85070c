"""What a scene asks again and again while it runs: prescribed motions, tractions, body force."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.constraint import Fixed, vertex_normals
from sphsolid.scenes.scene import NoBodyForce, Scene

Array = NDArray[np.float64]


class FunctionOfTime(NamedTuple):
    """A ``function`` of the scene, named by what it is of, and all points it is asked at."""

    what: str
    function: Callable[..., Any]
    points: tuple[Array, ...]


def functions_of_time(scene: Scene, mesh: Mesh) -> Iterator[FunctionOfTime]:
    """All of ``scene`` at the vertices of ``mesh``; a traction is given the normals too.

    A face of several sides yields the function once a side, under the same name.
    """
    X = mesh.vertices
    for constraint in scene.constraints:
        if not isinstance(constraint.velocity, Fixed):
            what = f"prescribed velocity on {constraint.face}"
            for particles, _ in vertex_normals(mesh, constraint.face):
                yield FunctionOfTime(what, constraint.velocity, (X[particles],))
    for traction in scene.tractions:
        what = f"traction on {traction.face}"
        for particles, normal in vertex_normals(mesh, traction.face):
            yield FunctionOfTime(what, traction.value, (X[particles], normal))
    if not isinstance(scene.body_force, NoBodyForce):
        yield FunctionOfTime("body force", scene.body_force, (X,))
