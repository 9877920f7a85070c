"""Local angular-momentum projection, [Lee2017] section 6.

The nearest ``P^C`` to ``P`` for which ``P^C F_x^T`` is symmetric (eq. (15)):

    P^C = P + lambda x F_x,   lambda = L^-1 [E : (P F_x^T)],   L = tr(b) I - b,   b = F_x F_x^T.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

from sphsolid.continuum.symmetric_stress import project
from sphsolid.protocols import check_protocol

__all__ = [
    "AngularMomentumTreatment", "LocalProjection", "NoProjection", "check_projection", "project",
]  # fmt: skip


@dataclass(frozen=True)
class LocalProjection:
    """Project ``P`` and ``P_fine`` at every particle in every stage (the default)."""

    projects: ClassVar[bool] = True


@dataclass(frozen=True)
class NoProjection:
    """Use the stresses as they come: angular momentum drifts in mixed formulations."""

    projects: ClassVar[bool] = False


class AngularMomentumTreatment(Protocol):
    """Whether stresses are projected."""

    projects: ClassVar[bool]


def check_projection(treatment: object) -> None:
    """Raise ``InputError`` unless ``treatment`` keeps the protocol."""
    check_protocol(
        "angular_momentum", treatment, ("projects",), "use LocalProjection() or NoProjection()"
    )
