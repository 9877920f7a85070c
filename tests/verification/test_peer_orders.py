"""Orders of the methods of others on the swinging cube: floors of slopes and caps of errors.

Floors are those of 1/4 to 1/8 in the linear limit, TVD-RK2 at CFL 0.3, nu = 0.3, A+B+C=0; on finer
lattices slopes go on to 2 where the operator is consistent, and do not where it is not.
"""

from __future__ import annotations

from typing import Any

import pytest

import sphsolid as sph
from sphsolid.scenes import amplitude_of_gradient, swinging_cube
from studies.measures.order import last_order
from studies.measures.swinging_cube import LINEAR_AMPLITUDE, period_errors_of
from studies.methods import HOURGLASS, HOURGLASS_AS_SHIPPED, JST, UPWIND, UPWIND_LIMITED, Method

LARGE = {"amplitude": amplitude_of_gradient("A+B+C=0", 0.2), "manufactured": True}


def errors_of(method: Method, cells: int, **scene: Any) -> dict[str, float]:
    scene = {"amplitude": LINEAR_AMPLITUDE} | scene
    return period_errors_of(
        method.simulation(swinging_cube(**scene), spacing=1.0 / cells)
    )


@pytest.mark.parametrize(
    ("method", "floor", "cap"),
    [
        (HOURGLASS, 1.5, 0.04),
        (JST.but(formulation=sph.PF()), 1.75, 0.05),
        (JST.but(formulation=sph.PFHJ()), 1.75, 0.05),
        (UPWIND.but(formulation=sph.PF()), 1.75, 0.05),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_momentum_converges_at_second_order(method: Method, floor: float, cap: float) -> None:
    errors = [errors_of(method, cells) for cells in (4, 8)]
    for name in ("p_x", "p_y", "p_z"):
        assert errors[1][name] < cap
        assert last_order([1 / 4, 1 / 8], [error[name] for error in errors]) > floor
    stress = max(value for name, value in errors[1].items() if name.startswith("P"))
    assert stress < 0.15


@pytest.mark.parametrize("method", [JST, UPWIND, UPWIND_LIMITED], ids=lambda m: m.name)
def test_large_strains_too(method: Method) -> None:
    method = method.but(formulation=sph.PF())
    errors = [errors_of(method, cells, **LARGE) for cells in (4, 8)]
    for name in ("p_x", "p_y", "p_z"):
        assert last_order([1 / 4, 1 / 8], [error[name] for error in errors]) > 1.6


def test_as_shipped_it_is_of_first_order_at_best() -> None:
    errors = [errors_of(HOURGLASS_AS_SHIPPED, cells) for cells in (4, 8)]
    assert last_order([1 / 4, 1 / 8], [error["p_x"] for error in errors]) < 1.0
    assert errors[1]["p_x"] > 0.1
