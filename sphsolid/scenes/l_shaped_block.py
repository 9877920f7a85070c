"""The L-shaped block ([Lee2017] section 8.1, Figs. 6-8): a free body kicked into a tumble.

The block ``([0, 3] x [0, 10]  U  [3, 6] x [0, 3]) x [0, 3]`` m starts at rest.  Opposite tractions
act on two of its faces, of 9 m^2 each, until 5 s:

    t_B = eta(t) (150, 300, 450) Pa on X = 6,   minus that on Y = 10,
    eta(t) = t up to 2.5 s, 5 - t up to 5 s, 0 after (t in seconds).

Linear momentum is zero at all times, angular momentum constant after 5 s.  With the arms of the
undeformed body its impulse would be ``(-2.15e5, -1.14e5, 1.48e5)`` kg m^2/s.

Published: geometry in a figure, E, nu, rho0, 388 disordered particles, CFL.  Taken from the family
of papers that it refers to for the load: the tractions and ``eta``; which face has the plus sign is
inferred.  Not published: the particles themselves and the end of the run.  Ours: a background mesh
with disorder (``jitter``), ``PUBLISHED_SPACING`` the nominal spacing whose particle number comes
closest to 388 (425), and 20 s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.errors import require
from sphsolid.geometry.body import Blocks
from sphsolid.scenes.scene import Scene, Traction

Array = NDArray[np.float64]
#: Nominal spacing [m] with 425 particles; the next are 240 (from 0.858) and 450 (0.75).
PUBLISHED_SPACING = 0.85
#: Traction per second of ``eta`` [Pa/s].
TRACTION_RATE = (150.0, 300.0, 450.0)


@dataclass(frozen=True)
class Kick:
    """The traction ``sign eta(t) factor TRACTION_RATE`` [Pa], the same all over the face."""

    factor: float
    sign: float = 1.0

    def __call__(self, X: Array, N: Array, t: float) -> Array:
        """The traction ``(n, 3)``."""
        rate = self.factor * np.array(TRACTION_RATE)
        return self.sign * np.tile(load_history(t) * rate, (len(X), 1))


def load_history(t: float) -> float:
    """``eta(t)`` [s]: up to 2.5 s at 2.5 s, back to zero at 5 s, zero after."""
    return max(0.0, min(t, 5.0 - t))


def l_shaped_block(
    *,
    load_factor: float = 1.0,
    young_modulus: float = 50046.0,
    poisson_ratio: float = 0.3,
    density: float = 1000.0,
    jitter: float = 0.2,
    seed: int = 0,
    end_time: float = 20.0,
) -> Scene:
    """The block with its tractions times ``load_factor``.

    ``jitter`` disorders the particles (0 for a regular arrangement).  Raises ``InputError`` for a
    non-finite ``load_factor``.
    """
    require(
        math.isfinite(load_factor),
        f"l_shaped_block: load_factor = {load_factor} must be finite; 1 is the published load",
    )
    return Scene(
        name="l_shaped_block",
        body=Blocks(
            (((0.0, 0.0, 0.0), (3.0, 10.0, 3.0)), ((3.0, 0.0, 0.0), (6.0, 3.0, 3.0))),
            jitter=jitter,
            seed=seed,
        ),
        material=NeoHookean.from_young(
            young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density
        ),
        end_time=end_time,
        tractions=(Traction("X+", Kick(load_factor)), Traction("Y+", Kick(load_factor, -1.0))),
        probes={
            "origin": (0.0, 0.0, 0.0),
            "long_end": (0.0, 10.0, 0.0),
            "short_end": (6.0, 0.0, 0.0),
            "inner_edge": (3.0, 3.0, 0.0),
        },
        provenance=(
            "Published: geometry, E, nu, rho0, 388 disordered particles [Lee2017 section 8.1]; "
            "tractions by reference to earlier papers. Inferred: plus sign on X = 6. Chosen: the "
            "disordered arrangement, end time."
        ),
    )
