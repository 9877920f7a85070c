"""How the fibre map starts: from the discrete geometry or from what the scene states.

The two differ by the truncation error of the gradient, ``O(dx)`` at the boundary.  Where force
and gradient are adjoint the compatible start keeps ``F = F_x`` for good (no stored energy without
a displacement) and gives stress slopes near two instead of 1.6.  Where they are not adjoint, the
stated strain is the more accurate start.  On a disordered cloud the difference is rough, inside
too; the equilibrated start takes its force away and leaves ``F`` compatible.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Compatible:
    """``F^0 = F_x(x^0) = sum_b x_b^0 (x) G_b``."""


@dataclass(frozen=True)
class Given:
    """``F^0`` as the scene states it (``initial_deformation_gradient``)."""


@dataclass(frozen=True)
class Equilibrated:
    """Compatible, at positions moved by ``O(dx^2)`` to where the stated strain's force acts.

    See ``equilibrium``: on a disordered cloud nothing else keeps the truncation error of the stated
    displacement from setting off waves.
    """


InitialStrain = Compatible | Given | Equilibrated
