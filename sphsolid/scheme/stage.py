"""One evaluation of the rates: what passes read and what they add to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.scheme.state import State

Array = NDArray[np.float64]


@dataclass
class Stage:
    """``state`` at ``t`` [s], and what has been found of its rates so far.

    ``x (N, 3)`` [m] are the positions whose ``F_x = sum_b x_b (x) G_b`` the projection uses, with
    the gradient whose adjoint makes the force; ``arms (N, 3)`` the same from the middle of the
    body.  ``rates`` by name, ``rates.F`` being ``grad v`` whatever is evolved; ``P (N, 3, 3)`` [Pa]
    the stress whose force is taken; ``projected_rate (N, 3, 3)`` [1/s] the projected ``grad v``
    where a term asks for it, else of zero length; ``projects`` where stresses are projected.
    ``knows_F_x``: ``state.F`` is ``F_x``, so that a stress of ``state.F`` needs no projection.
    """

    state: State
    x: Array
    arms: Array
    t: float
    rates: State
    P: Array
    projected_rate: Array
    projects: bool
    knows_F_x: bool = False
