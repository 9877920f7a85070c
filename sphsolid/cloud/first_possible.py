"""The first operator of a list that exists on a mesh: a default where the best does not exist."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

from sphsolid.cloud.cloud import Cloud, build_cloud
from sphsolid.cloud.operator import OperatorKind
from sphsolid.cloud.smoothing import SmoothingFunction
from sphsolid.errors import InputError
from sphsolid.geometry.mesh import Mesh


@dataclass(frozen=True)
class Candidate:
    """An operator and the smoothing length over the spacing to build it with."""

    operator: OperatorKind
    h_over_dx: float

    def __str__(self) -> str:
        return f"{self.operator.name} with h_over_dx = {self.h_over_dx:g}"


@dataclass(frozen=True)
class Found:
    """The cloud, what it was built with, and the candidates refused before with their reasons."""

    cloud: Cloud
    candidate: Candidate
    refused: tuple[tuple[Candidate, str], ...]


def first_possible(
    mesh: Mesh, smoothing: SmoothingFunction, candidates: Sequence[Candidate]
) -> Found:
    """Build the first candidate that exists.

    One warning says which were refused and why; where all are, the first refusal is raised, an
    ``InputError`` of ``build_cloud``.
    """
    refused: list[tuple[Candidate, str]] = []
    first: InputError | None = None
    for candidate in candidates:
        try:
            cloud = build_cloud(
                mesh,
                smoothing=smoothing,
                h_over_dx=candidate.h_over_dx,
                operator=candidate.operator,
            )
        except InputError as error:
            first = first or error
            refused.append((candidate, str(error)))
            continue
        if refused:
            tried = "; ".join(f"{other}: {reason}" for other, reason in refused)
            warnings.warn(
                f"the default operator does not exist on this cloud, {candidate} is used instead, "
                f"which is less accurate where particles are disordered. Tried: {tried}",
                stacklevel=4,
            )
        return Found(cloud, candidate, tuple(refused))
    assert first is not None, "no candidates"
    raise first
