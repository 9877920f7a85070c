"""A load whose answer depends on what it was asked before would depend on who looks at the run.

How often a function is asked is the method's own affair: stages, records, checkpoints.  An object
with ``__call__`` may have a memory: whoever asks beside the run asks a copy of it.  What a plain
function remembers, in a list around it or a generator of random numbers, nobody can copy.
"""

from __future__ import annotations

import copy

import numpy as np

from sphsolid.errors import InputError
from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.callbacks import asked
from sphsolid.scenes.functions_of_time import functions_of_time
from sphsolid.scenes.scene import Scene


def refuse_hidden_memory(scene: Scene, mesh: Mesh) -> None:
    """Raise ``InputError`` for a plain function of time that forgets what it said of ``t = 0``.

    Loads and prescribed motions are asked at the start, at the end, and at the start again.
    """
    for what, function, points in functions_of_time(scene, mesh):
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
