"""The rates nearest to given ones that change neither momentum of a free body ([Lee2016]).

See :mod:`sphsolid.continuum.kept_momenta`; the rates are those without loads.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.kept_momenta import momentum_correction
from sphsolid.fields import vector_field
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage

Array = NDArray[np.float64]


class FreeMomenta:
    """Nothing is corrected."""

    works: tuple[str, ...] = ()
    words = "no momentum kept"

    def correct(self, stage: Stage) -> None:
        """Nothing."""

    def powers(self, stage: Stage) -> tuple[float, ...]:
        """None."""
        return ()


class KeptMomenta(FreeMomenta):
    """``correction (N, 3)`` [N/m^3] is what it last added to the rates of ``p``."""

    works = ("momentum_correction",)
    words = "both momenta by least squares"

    def __init__(self, set_up: SetUp) -> None:
        self._V, self._loads = set_up.cloud.V, set_up.loads
        self._density = set_up.material.density
        self.correction = vector_field(set_up.cloud.size)

    def correct(self, stage: Stage) -> None:
        """Add the correction of all that acts but loads, about the positions of the stage."""
        loads, rate = self._loads, stage.rates.p
        of_itself = rate - loads.at(stage.t)[0] if loads.any else rate
        self.correction[:] = momentum_correction(self._V, stage.arms, of_itself)
        rate += self.correction

    def powers(self, stage: Stage) -> tuple[float, ...]:
        """``sum V v . c`` [W]."""
        work = np.sum(stage.state.p * self.correction, axis=1)
        return (float(self._V @ work) / self._density,)


def momenta(set_up: SetUp, *, kept: bool) -> FreeMomenta:
    """What keeps the momenta of one body, or nothing."""
    return KeptMomenta(set_up) if kept else FreeMomenta()
