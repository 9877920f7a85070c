"""A load whose answer depends on what it was asked before would depend on who looks at the run.

How often a function is asked is the method's own affair: stages, records, checkpoints.  An object
with ``__call__`` may have a memory: whoever asks beside the run asks a copy of it.  What a plain
function remembers, in a list around it or a generator of random numbers, nobody can copy.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.callbacks import asked
from sphsolid.scenes.constraint import Fixed, vertex_normals
from sphsolid.scenes.scene import NoBodyForce, Scene

Array = NDArray[np.float64]


def refuse_hidden_memory(scene: Scene, mesh: Mesh) -> None:
    """Raise ``InputError`` for a plain function of time that forgets what it said of ``t = 0``.

    Loads and prescribed motions are asked at the start, at the end, and at the start again.
    """
    for what, function, points in _functions_of_time(scene, mesh):
        if copy.deepcopy(function) is not function:
            continue
        try:
            first, _, again = (
                asked(function, *points, what=what, t=t) for t in (0.0, scene.end_time, 0.0)
            )
        except Exception:
            # It is refused, or not, where the run asks it.
            continue
        if not np.array_equal(first, again):
            raise InputError(
                f"{what} says something else of t = 0 when it is asked again: it must depend on "
                "its arguments alone. What it remembers belongs into an object with __call__, of "
                "which others can ask a copy; random numbers are drawn before the run"
            )


def _functions_of_time(
    scene: Scene, mesh: Mesh
) -> Iterator[tuple[str, Callable[..., Any], tuple[Array, ...]]]:
    """Name, function and all points at which the run will ask it."""
    X = mesh.vertices
    for constraint in scene.constraints:
        if not isinstance(constraint.velocity, Fixed):
            for particles, _ in vertex_normals(mesh, constraint.face):
                what = f"prescribed velocity on {constraint.face}"
                yield what, constraint.velocity, (X[particles],)
    for traction in scene.tractions:
        for particles, normal in vertex_normals(mesh, traction.face):
            yield f"traction on {traction.face}", traction.value, (X[particles], normal)
    if not isinstance(scene.body_force, NoBodyForce):
        yield "body force", scene.body_force, (X,)
