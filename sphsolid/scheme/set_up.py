"""What formulation, terms and integrators are made for: one body, discretised."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from typing import Any

from sphsolid.cloud.cloud import Cloud, Secondary, build_secondary
from sphsolid.cloud.secondary import SecondaryPoints
from sphsolid.scheme.boundary import EssentialConditions, Loads
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.operator import Operator


@dataclass(frozen=True)
class SetUp:
    """The law as kernels see it, the particles, the operator on them, loads and constraints.

    ``projects``: stresses are projected to keep angular momentum.
    """

    material: Any
    cloud: Cloud
    operator: Operator
    formulation: Formulation
    projects: bool
    loads: Loads
    essential: EssentialConditions
    _secondary: dict[tuple[SecondaryPoints, bool], Secondary] = field(default_factory=dict)
    _kept: dict[Hashable, Any] = field(default_factory=dict)

    def secondary(self, points: SecondaryPoints, *, adjoint_weight: bool) -> Secondary:
        """Secondary particles, placed once for all terms and all branches of a run."""
        key = (points, adjoint_weight)
        if key not in self._secondary:
            made = build_secondary(self.cloud, points, adjoint_weight=adjoint_weight)
            self._secondary[key] = made
        return self._secondary[key]

    def kept(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """What ``make`` returns, made once for all branches of a run: nothing may write to it."""
        if key not in self._kept:
            self._kept[key] = make()
        return self._kept[key]

    def again(self, other: SetUp) -> SetUp:
        """``other``, of the same particles, with what was placed or kept here."""
        return replace(other, _secondary=self._secondary, _kept=self._kept)
