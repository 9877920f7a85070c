"""An initial ``F`` that a scene states and a method does not use must be that of its displacement.

A method that starts from the displacement alone would otherwise solve another problem than the
scene states, without a word.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.scenes.scene import Scene

Array = NDArray[np.float64]
#: Step of the differences, as a share of the size of the body.
_STEP = 1.0e-4
#: Difference that is let pass: this share of ``|F - I|``, and this much besides.
_SHARE, _BESIDES = 0.1, 1.0e-3
#: What ``plan()`` says of a stated ``F`` that is not used.
NOT_USED = (
    "the stated initial F is not used: it is checked, and F starts as the gradient of the stated "
    "displacement"
)


def refuse_contradiction(scene: Scene, X: Array) -> None:
    """Raise ``InputError`` where the stated ``F`` is not ``I + grad u`` of the stated ``u``.

    ``X (n, 3)`` [m].  ``grad u`` is taken by differences over ``1e-4`` of the body's size, forward,
    backward and central: where ``u`` has a kink, one of them is enough.  They may differ by
    ``0.1 |F - I| + 1e-3``.  Nothing is compared where ``u`` has no values beside the points.
    """
    if not scene.states_deformation:
        return
    F = scene.stated_deformation(X)
    step = _STEP * float(np.max(np.ptp(X, axis=0)))
    try:
        missed = _least_difference(scene, X, F, step)
    except InputError:
        return
    allowed = _BESIDES + _SHARE * np.linalg.norm(F - np.eye(3), axis=(1, 2))
    bad = np.flatnonzero(missed > allowed)
    if len(bad):
        a = int(np.argmax(missed - allowed))
        raise InputError(
            f"scene {scene.name!r}: initial_deformation_gradient contradicts initial_displacement "
            f"at {len(bad)} of {len(X)} points, by {missed[a]:.3g} at X = {X[a].tolist()} m, and "
            "this method starts from the displacement alone; state F = I + grad u, leave F out, or "
            "give sphsolid.Simulation initial_strain = Given(), or Compatible() to start without it"
        )


def _least_difference(scene: Scene, X: Array, F: Array, step: float) -> Array:
    """``|F - I - grad u| (n,)``, of each column the least of three differences."""
    middle = scene.displacement_at_start(X)
    columns = np.empty((len(X), 3))
    for j, e in enumerate(step * np.eye(3)):
        ahead, behind = scene.displacement_at_start(X + e), scene.displacement_at_start(X - e)
        slopes = np.stack([ahead - middle, middle - behind, 0.5 * (ahead - behind)]) / step
        wanted = F[:, :, j] - np.eye(3)[j]
        columns[:, j] = np.linalg.norm(wanted - slopes, axis=2).min(axis=0)
    return np.asarray(np.linalg.norm(columns, axis=1))
