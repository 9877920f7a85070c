"""Options that cannot work are refused when they are built, with what to use instead."""

from __future__ import annotations

import math
from typing import Any

import pytest

import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.scenes import swinging_cube
from sphsolid.scheme.stabilisation import check_formulation, check_pair
from tests.oracles.blocks import FORMULATIONS


@pytest.mark.parametrize("name", ["tau_F", "xi_F", "tau_p"])
@pytest.mark.parametrize("value", [-0.1, -1e-300, math.nan, math.inf])
def test_a_negative_or_infinite_coefficient_is_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=rf"{name} = .*>= 0"):
        sph.SUPG(**{name: value})


@pytest.mark.parametrize("name", ["tau_H", "tau_J", "xi_H", "xi_J"])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_a_negative_or_infinite_fine_scale_coefficient_is_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        sph.StabilisedStrains(**{name: value})
    if name.startswith("tau"):
        with pytest.raises(InputError, match=name):
            sph.FullHessian(**{name: value})


@pytest.mark.parametrize("make", [sph.SimplifiedHessian, sph.FullHessian])
@pytest.mark.parametrize("value", [-1.0, math.nan])
def test_a_negative_modulus_is_refused(make: Any, value: float) -> None:
    with pytest.raises(InputError, match="alpha"):
        make(alpha=value)


def test_no_coefficient_at_all_is_refused() -> None:
    with pytest.raises(InputError, match=r"NoStabilisation\(\)"):
        sph.SUPG(tau_F=0.0, xi_F=0.0, tau_p=0.0)
    assert sph.SUPG(tau_F=0.0, xi_F=0.0, tau_p=0.1).tau_p == sph.OfStep(0.1)


def test_a_term_that_only_the_fine_scale_form_holds_is_enough() -> None:
    strains = sph.StabilisedStrains(tau_J=0.5)
    assert sph.SUPG(tau_F=0.0, xi_F=0.0, fine_scale=strains).fine_scale is strains


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_terms_need_the_law_they_stabilise(formulation: Any) -> None:
    needs = {
        "J": [
            sph.SUPG(tau_p=0.1),
            sph.SUPG(fine_scale=sph.FullHessian(tau_J=0.1)),
            sph.SUPG(fine_scale=sph.StabilisedStrains(tau_J=0.1)),
            sph.SUPG(fine_scale=sph.StabilisedStrains(xi_J=0.1)),
        ],
        "H": [
            sph.SUPG(fine_scale=sph.FullHessian(tau_H=0.1)),
            sph.SUPG(fine_scale=sph.StabilisedStrains(tau_H=0.1)),
            sph.SUPG(fine_scale=sph.StabilisedStrains(xi_H=0.1)),
        ],
    }
    for field, options in needs.items():
        for option in options:
            if getattr(formulation, f"evolves_{field}"):
                check_pair(formulation, option)
            else:
                with pytest.raises(InputError, match=r"PFHJ\(\)"):
                    check_pair(formulation, option)
    check_pair(formulation, sph.SUPG())
    check_pair(formulation, sph.NoStabilisation())


@pytest.mark.parametrize("unknown", ["{p,F}", None, 3, sph.PF, sph.SUPG()])
def test_an_unknown_formulation_is_refused(unknown: Any) -> None:
    with pytest.raises(InputError, match=r"formulation = .*PF\(\), PFJ\(\)"):
        check_formulation(unknown)


@pytest.mark.parametrize("unknown", ["SUPG", None, sph.SUPG, sph.PF()])
def test_an_unknown_stabilisation_is_refused(unknown: Any) -> None:
    with pytest.raises(InputError, match=r"stabilisation = .*NoStabilisation\(\)"):
        check_pair(sph.PF(), unknown)


@pytest.mark.parametrize("unknown", ["H1", sph.H1, None])
def test_unknown_secondary_points_and_forms_are_refused(unknown: Any) -> None:
    with pytest.raises(InputError, match=r"H1\(\)"):
        sph.SUPG(secondary=unknown)
    with pytest.raises(InputError, match=r"SimplifiedHessian\(\)"):
        sph.SUPG(fine_scale=unknown)


def test_a_simulation_refuses_a_wrong_pair_before_it_builds_anything() -> None:
    with pytest.raises(InputError, match="does not solve"):
        sph.Simulation(swinging_cube(), spacing=-1.0, stabilisation=sph.SUPG(tau_p=0.1))
    with pytest.raises(InputError, match="formulation"):
        sph.Simulation(swinging_cube(), spacing=0.5, formulation="{p,F}")  # type: ignore[arg-type]


@pytest.mark.parametrize("spacing", [0.0, -0.1, math.nan, math.inf])
def test_a_wrong_spacing_is_refused(spacing: float) -> None:
    with pytest.raises(InputError, match="spacing"):
        sph.Simulation(swinging_cube(), spacing=spacing)


@pytest.mark.parametrize("option", [{"cfl": 0.0}, {"cfl": math.nan}, {"h_over_dx": -1.0}])
def test_a_wrong_number_is_refused(option: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(option))):
        sph.Simulation(swinging_cube(), spacing=0.5, **option)  # type: ignore[arg-type]
