"""The defaults of summation by parts, by what they give: accuracy and distance from the kernel."""

from __future__ import annotations

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import Cloud, build_cloud
from sphsolid.defaults import default_h_over_dx, default_operator
from sphsolid.geometry import Box
from tests.oracles.dense import dense

BODY = Box(jitter=0.4, seed=3)
#: Recorded: error of the gradients of all quadratics, and the change of the printed gradient.
ERROR, CHANGE = 0.16836, 0.8510


def cloud_of(*, h_over_dx: float | None = None, **options: float) -> Cloud:
    """The disordered cube of 6^3 particles, by default but for what is named."""
    mesh = BODY.mesh(0.2)
    operator = default_operator(mesh)
    assert operator == sph.SummationByParts()
    return build_cloud(
        mesh,
        smoothing=sph.WendlandC2(),
        h_over_dx=default_h_over_dx(mesh, operator) if h_over_dx is None else h_over_dx,
        operator=sph.SummationByParts(**options) if options else operator,
    )


def error_of(cloud: Cloud) -> float:
    """Root of ``sum V |e|^2``, ``e`` the errors of the gradients of the six quadratics."""
    G = dense(cloud.pairs, cloud.gradients.kinematic, cloud.size)
    X = cloud.X - 0.5
    total = 0.0
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
        exact = np.zeros_like(X)
        exact[:, i] += X[:, j]
        exact[:, j] += X[:, i]
        found = np.einsum("abd,b->ad", G, X[:, i] * X[:, j])
        total += float(np.sum(cloud.V[:, None] * (found - exact) ** 2))
    return total**0.5


def is_recorded(cloud: Cloud) -> bool:
    close = error_of(cloud) == pytest.approx(ERROR, rel=3e-3)
    return bool(close and cloud.change == pytest.approx(CHANGE, rel=1e-2))


def test_the_defaults_give_what_was_recorded() -> None:
    assert is_recorded(cloud_of())
    # The record is that of the operator, not of how far it was solved.
    assert is_recorded(cloud_of(tolerance=1e-6))


@pytest.mark.parametrize(
    "changed", [{"epsilon": 0.2}, {"epsilon": 0.002}, {"h_over_dx": 0.95}, {"h_over_dx": 1.05}]
)
def test_other_settings_leave_the_recorded_band(changed: dict[str, float]) -> None:
    assert not is_recorded(cloud_of(**changed))
