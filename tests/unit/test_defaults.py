"""What is used where nothing is given, and that it is said."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import sphsolid as sph
from sphsolid import defaults
from sphsolid.errors import InputError
from sphsolid.recommendation import recommend_supg
from sphsolid.scenes import Blocks, Box, Scene, swinging_cube, twisting_column

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("formulation", "nu", "tau_p"),
    [(sph.PF(), 0.495, 0.0), (sph.PFJ(), 0.495, 0.1), (sph.PFHJ(), 0.45, 0.0),
     (sph.PFHJ(), 0.4999, 0.1), (sph.PFJ(), 0.3, 0.0)],
)  # fmt: skip
def test_supg_is_what_a_formulation_that_evolves_a_strain_gets(
    formulation: Any, nu: float, tau_p: float
) -> None:
    sim = sph.Simulation(
        twisting_column(poisson_ratio=nu), spacing=0.5, formulation=formulation
    )
    # min(0.5, 5 c_s / c_p) h / c_p, and (c_s / c_p)^2 = (1 - 2 nu) / (2 - 2 nu).
    own = min(0.5, 5.0 * ((1.0 - 2.0 * nu) / (2.0 - 2.0 * nu)) ** 0.5)
    supg = sim.stabilisation
    assert isinstance(supg, sph.SUPG)
    assert isinstance(supg.tau_F, sph.OfMesh)
    assert supg.tau_F.c == pytest.approx(own, rel=1e-9)
    assert supg == sph.SUPG(
        tau_F=supg.tau_F, xi_F=0.0, tau_p=tau_p, weighting=sph.SelfAdjoint()
    )
    assert sim.integrator == sph.PositionVerlet()
    assert sim._time_step.cfl == 0.7
    assert sim.h_over_dx == 0.77
    plan = sim.plan()
    assert "CFL 0.7 (on a free lattice block at rest modes grow slowly above" in plan
    chosen = "stabilisation, dilatation, h_over_dx, integrator, cfl, operator, smoothing"
    assert f"by default     {chosen}" in plan


@pytest.mark.parametrize(
    ("body", "operator"),
    [
        (Box(), sph.LatticeDifference()),
        (Blocks((((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((1.0, 0.0, 0.0), (2.0, 0.5, 1.0)))),
         sph.Consistent()),
        (Box(jitter=0.3), sph.SummationByParts()),
    ],
    ids=["box", "L", "jitter"],
)  # fmt: skip
def test_who_chooses_nothing_gets_a_form_that_holds_its_shape(body: Any, operator: Any) -> None:
    scene = Scene("body", body, twisting_column(poisson_ratio=0.3).material, 0.01)
    for given in ({}, {"formulation": sph.Displacement()}, {"stabilisation": sph.Restraint()}):
        sim = sph.Simulation(scene, spacing=0.25, **given)
        assert sim.formulation == sph.Displacement()
        assert sim.stabilisation == sph.Restraint()
        assert sim.dilatation == sph.FilteredDilatation()
        assert sim.operator == operator
    assert "the highest frequency of the undeformed body allows" in sim.plan()


def test_a_stabilisation_of_supg_brings_its_formulation() -> None:
    scene = twisting_column(poisson_ratio=0.3)
    for given in (sph.SUPG(), sph.NoStabilisation()):
        sim = sph.Simulation(scene, spacing=0.5, stabilisation=given)
        assert sim.formulation == recommend_supg(scene).formulation == sph.PF()
        assert sim.dilatation == sph.OwnDilatation()
        assert sim.operator == sph.Consistent()


@pytest.mark.parametrize("nu", [0.3, 0.499])
def test_tau_F_is_a_time_of_the_solid_and_the_spacing(nu: float) -> None:
    """No CFL number, integrator or deformation enters it."""
    scene = twisting_column(poisson_ratio=nu)
    times = []
    for options in ({}, {"cfl": 0.35}, {"integrator": sph.SSPRK3()}):
        sim = sph.Simulation(scene, spacing=0.5, formulation=sph.PFJ(), **options)
        sim.advance(sim.stable_time_step())
        times.append(sim._rhs.terms[0].times.F)
    speed = (scene.material.kappa + 4.0 / 3.0 * scene.material.mu) / scene.material.density
    shear = (scene.material.mu / scene.material.density / speed) ** 0.5
    assert times == [times[0]] * 3
    assert times[0] == pytest.approx(min(0.5, 5.0 * shear) * 0.5 / speed**0.5, rel=1e-9)


def test_the_plan_promises_no_fewer_steps_than_there_will_be() -> None:
    """The step shrinks with the smallest stretch, so what the undeformed one says is a least."""
    sim = sph.Simulation(twisting_column(), spacing=0.5, formulation=sph.PFJ())
    least = math.ceil(sim.scene.end_time / sim._time_step.reference)
    assert f"at least {least} steps and {least} evaluations to " in sim.plan()
    sim.run(until=0.2 * sim.scene.end_time)
    assert sim.step > 0.2 * least
    left = math.ceil(0.8 * sim.scene.end_time / sim._time_step.reference - 1e-9)
    assert f"at least {left} steps" in sim.plan()


def test_recommend_is_a_function_of_the_package() -> None:
    scene = twisting_column()
    advice = sph.recommend(scene)
    assert advice.formulation == sph.Simulation(scene, spacing=0.5).formulation
    assert "recommend" in sph.__all__


def test_auto_takes_a_share_of_the_limit() -> None:
    scene = twisting_column(poisson_ratio=0.3)
    sim = sph.Simulation(scene, spacing=0.5, formulation=sph.PF(), cfl="auto")
    limit = defaults.stability_limit(sim.integrator, sim.formulation, scene.material)
    assert isinstance(limit, defaults.StabilityLimit)
    assert sim._time_step.cfl == pytest.approx(defaults.MARGIN * limit.slow)
    assert sim._time_step.cfl > 0.7


def test_auto_has_no_number_for_the_displacement_form() -> None:
    with pytest.raises(InputError, match="cfl = 'auto': the stability map has no displacement"):
        sph.Simulation(twisting_column(), spacing=0.5, cfl="auto")


@pytest.mark.parametrize(
    ("integrator", "said"),
    [
        (sph.PositionVerlet(), "CFL 0.7 (1 is what the highest frequency"),
        (sph.SymplecticRKN4(), "CFL 1.5 (3.73 is what the highest frequency"),
        (sph.SSPRK3(), "CFL 0.5 (0.866 is what the highest frequency"),
        (sph.TVDRK2(), "CFL 0.3 (no step is short enough"),
    ],
)
def test_the_plan_of_the_default_says_what_its_integrator_allows(
    integrator: Any, said: str
) -> None:
    assert said in sph.Simulation(twisting_column(), spacing=0.5, integrator=integrator).plan()


def test_the_plan_says_the_step_that_the_viscosity_allows() -> None:
    viscous = sph.Restraint(viscosity=0.5)
    sim = sph.Simulation(twisting_column(), spacing=0.5, stabilisation=viscous)
    step = sim.stable_time_step()
    assert step < 0.9 * sim._time_step.reference
    assert f"undeformed step {step:.4g} s (a term allows" in sim.plan()


def test_two_filters_of_the_dilatation_are_refused() -> None:
    def build(**options: Any) -> sph.Simulation:
        return sph.Simulation(twisting_column(), spacing=0.5, **options)

    coarse = sph.FilteredDilatation(order=1)
    with pytest.raises(InputError, match="2 filtered dilatations"):
        build(dilatation=sph.FilteredDilatation(), terms=[coarse])
    with pytest.raises(InputError, match="2 filtered dilatations"):
        build(terms=[coarse, coarse])
    assert build(terms=[coarse]).dilatation == sph.OwnDilatation()


def test_what_lines_do_not_read_is_refused() -> None:
    given: dict[str, Any]
    for given in ({"h_over_dx": 0.9}, {"smoothing": sph.CubicSpline()}):
        with pytest.raises(InputError, match=f"{next(iter(given))} would have no effect"):
            sph.Simulation(twisting_column(), spacing=0.5, **given)
        sph.Simulation(twisting_column(), spacing=0.5, operator=sph.Consistent(), **given)


def test_a_restraint_among_the_terms_counts_as_one() -> None:
    scene = dataclasses.replace(swinging_cube(), body=Box(jitter=0.2))
    sims = [
        sph.Simulation(scene, spacing=0.25, formulation=sph.Displacement(), **options)
        for options in (
            {"stabilisation": sph.Restraint()},
            {"stabilisation": sph.NoStabilisation(), "terms": [sph.Restraint()]},
        )
    ]
    assert sims[0].cloud.h == sims[1].cloud.h
    assert sims[0].dilatation == sims[1].dilatation == sph.FilteredDilatation()


@pytest.mark.parametrize("integrator", [sph.PositionVerlet(), sph.SSPRK3(), sph.TVDRK2()])
@pytest.mark.parametrize("formulation", [sph.PF(), sph.PFJ()])
def test_every_integrator_has_its_limits(integrator: Any, formulation: Any) -> None:
    for nu in (0.0, 0.3, 0.4, 0.45, 0.495, 0.499, 0.4999):
        material = twisting_column(poisson_ratio=nu).material
        limit = defaults.stability_limit(integrator, formulation, material)
        assert isinstance(limit, defaults.StabilityLimit)
        assert 0.0 < limit.slow <= limit.fast


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.4, 0.45, 0.495, 0.499, 0.4999])
@pytest.mark.parametrize("formulation", [sph.PF(), sph.PFJ()])
def test_the_default_step_is_below_the_limit_of_every_solid(formulation: Any, nu: float) -> None:
    integrator = defaults.default_integrator()
    material = twisting_column(poisson_ratio=nu).material
    limit = defaults.stability_limit(integrator, formulation, material)
    assert isinstance(limit, defaults.StabilityLimit)
    assert defaults.default_cfl(integrator) < limit.slow


def test_what_is_given_is_kept_and_said() -> None:
    sim = sph.Simulation(
        swinging_cube(jitter=0.2), spacing=0.25, formulation=sph.PF(), integrator=sph.TVDRK2(),
        stabilisation=sph.SUPG(), operator=sph.Literal(), smoothing=sph.CubicSpline(),
    )  # fmt: skip
    assert sim._time_step.cfl == 0.3, "the paper's, with the paper's integrator"
    assert sim.h_over_dx == 0.9
    assert "by default     dilatation, h_over_dx, cfl" in sim.plan()
    assert "not tabulated" in sim.plan()


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.495, 0.4999])
def test_poisson_ratio_is_that_of_the_material(nu: float) -> None:
    material = twisting_column(poisson_ratio=nu).material
    assert defaults.poisson_ratio(material) == pytest.approx(nu, abs=1e-12)


def test_the_limit_is_that_of_the_next_larger_ratio(tmp_path: Any, monkeypatch: Any) -> None:
    table = tmp_path / "limits.csv"
    table.write_text(
        "integrator,formulation,nu,slow,fast\n"
        'SSP-RK3,"{p,F}",0.499,0.5,0.7\nSSP-RK3,"{p,F}",0.3,0.8,0.9\n'
        'SSP-RK3,"{p,F,J}",0.3,0.1,0.2\n'
    )
    monkeypatch.setattr(defaults, "LIMITS", table)
    for nu, limit in ((0.0, 0.8), (0.3, 0.8), (0.31, 0.5), (0.499, 0.5), (0.4999, 0.5)):
        material = twisting_column(poisson_ratio=nu).material
        assert defaults.stability_limit(sph.SSPRK3(), sph.PF(), material).slow == limit
    assert defaults.stability_limit(sph.SSPRK3(), sph.PFHJ(), material).fast == 0.2


def test_the_limits_are_those_of_the_report() -> None:
    """Shipped with the package, measured by ``python -m studies.stability``."""
    shipped = pd.read_csv(defaults.LIMITS)
    report = pd.read_csv(ROOT / "reports" / "stability" / "limits.csv")
    report = report.rename(columns={"cfl_slow": "slow", "cfl_fast": "fast"})
    pd.testing.assert_frame_equal(shipped, report[shipped.columns.tolist()], check_dtype=False)
