"""What is used where nothing is given, and that it is said."""

from __future__ import annotations

from typing import Any

import pytest

import sphsolid as sph
from sphsolid import defaults
from sphsolid.scenes import swinging_cube, twisting_column


@pytest.mark.parametrize(
    ("formulation", "nu", "tau_p"),
    [(sph.PF(), 0.495, 0.0), (sph.PFJ(), 0.495, 0.1), (sph.PFHJ(), 0.45, 0.1),
     (sph.PFJ(), 0.3, 0.0), (sph.Displacement(), 0.495, 0.0)],
)  # fmt: skip
def test_options_that_are_not_given_are_chosen(formulation: Any, nu: float, tau_p: float) -> None:
    sim = sph.Simulation(
        twisting_column(poisson_ratio=nu), spacing=0.5, formulation=formulation
    )
    assert sim.stabilisation == sph.SUPG(tau_F=0.5, xi_F=0.0, tau_p=tau_p)
    assert sim.integrator == sph.SSPRK3()
    assert sim._time_step.cfl == 0.5
    assert sim.h_over_dx == 0.77
    plan = sim.plan()
    assert "CFL 0.5 (a free lattice block is stable to" in plan
    assert "by default     stabilisation, h_over_dx, integrator, cfl, operator, smoothing" in plan


def test_what_is_given_is_kept_and_said() -> None:
    sim = sph.Simulation(
        swinging_cube(jitter=0.2), spacing=0.25, formulation=sph.PF(), integrator=sph.TVDRK2(),
        stabilisation=sph.SUPG(), operator=sph.Literal(), smoothing=sph.CubicSpline(),
    )  # fmt: skip
    assert sim._time_step.cfl == 0.3, "the paper's, with the paper's integrator"
    assert sim.h_over_dx == 0.9
    assert "by default     h_over_dx, cfl" in sim.plan()
    assert "not tabulated" in sim.plan()


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.495, 0.4999])
def test_poisson_ratio_is_that_of_the_material(nu: float) -> None:
    material = twisting_column(poisson_ratio=nu).material
    assert defaults.poisson_ratio(material) == pytest.approx(nu, abs=1e-12)


def test_the_limit_is_that_of_the_next_larger_ratio(tmp_path: Any, monkeypatch: Any) -> None:
    table = tmp_path / "limits.csv"
    table.write_text("integrator,poisson_ratio,cfl\nSSP-RK3,0.3,0.9\nSSP-RK3,0.499,0.6\n")
    monkeypatch.setattr(defaults, "LIMITS", table)
    for nu, limit in ((0.0, 0.9), (0.3, 0.9), (0.31, 0.6), (0.499, 0.6), (0.4999, 0.6)):
        material = twisting_column(poisson_ratio=nu).material
        assert defaults.stable_cfl(sph.SSPRK3(), material) == limit
