"""Clouds that the checks of this folder share: a lattice and a disordered one."""

from __future__ import annotations

from typing import Any

import pytest

import sphsolid as sph
from sphsolid.cloud import Cloud, OperatorKind, SmoothingFunction, build_cloud
from sphsolid.scenes import Box

BOX = Box(upper=(1.0, 0.8, 1.2))
DEFAULT_H_OVER_DX = {0.0: 0.75, 0.2: 0.9, 0.4: 0.9}


def cloud(
    *,
    jitter: float = 0.0,
    spacing: float = 0.2,
    operator: OperatorKind | None = None,
    smoothing: SmoothingFunction | None = None,
    h_over_dx: float | None = None,
    seed: int = 2,
) -> Cloud:
    """A 1 x 0.8 x 1.2 m block; ``h_over_dx`` as a simulation chooses it."""
    return build_cloud(
        Box(upper=BOX.upper, jitter=jitter, seed=seed).mesh(spacing),
        smoothing=sph.WendlandC2() if smoothing is None else smoothing,
        h_over_dx=DEFAULT_H_OVER_DX[jitter] if h_over_dx is None else h_over_dx,
        operator=sph.Literal() if operator is None else operator,
    )


@pytest.fixture
def make_cloud() -> Any:
    """See :func:`cloud`."""
    return cloud
