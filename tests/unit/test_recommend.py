"""What is recommended for a scene, why, and that the shipped data are those of the report."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import sphsolid as sph
from sphsolid.cloud.secondary import default_secondary
from sphsolid.defaults import default_stabilisation, default_supg
from sphsolid.errors import InputError
from sphsolid.geometry import Box, TetBox
from sphsolid.recommendation import Evidence, NotMeasured, recommend, recommend_supg
from sphsolid.scenes import twisting_column
from sphsolid.scenes.scene import Scene

#: The room, whatever the package exports under its name.
module = importlib.import_module("sphsolid.recommendation")
ROOT = Path(__file__).resolve().parents[2]
REPORT = ROOT / "reports" / "pareto" / "recommendation.csv"
HEAD = "scene,nu,formulation,stabilisation,error_ratio,cpu_ratio,bytes_ratio,particles,compared\n"


@pytest.fixture
def table(tmp_path: Path, monkeypatch: Any) -> None:
    """{p,F} H1 to 0.3, {p,F,J} H6 to 0.45, {p,F,H,J} without stabilisation to 0.495."""
    path = tmp_path / "recommendations.csv"
    path.write_text(
        HEAD + 'cube,0.3,displacement,none,1,1,1,9,x\nall,0.495,"{p,F,H,J}",none,1.001,1,1,9,x\n'
        'all,0.3,"{p,F}",SUPG-H1,1.08,0.87,0.9,9,x\nall,0.45,"{p,F,J}",SUPG-H6,1,1,1,9,x\n'
    )
    monkeypatch.setattr(module, "RECOMMENDATIONS", path)


CHOSEN = sph.SUPG(tau_F=sph.OfMesh(0.5), xi_F=0.0, weighting=sph.SelfAdjoint())


@pytest.mark.parametrize(
    ("nu", "formulation", "stabilisation"),
    [
        (0.0, sph.PF(), CHOSEN),
        (0.3, sph.PF(), CHOSEN),
        (0.31, sph.PFJ(), replace(CHOSEN, secondary=sph.H6())),
        (0.45, sph.PFJ(), replace(CHOSEN, secondary=sph.H6())),
        (0.495, sph.PFHJ(), sph.NoStabilisation()),
        (0.4999, sph.PFHJ(), sph.NoStabilisation()),
    ],
)
def test_the_row_of_the_next_larger_ratio_is_taken(
    table: None, nu: float, formulation: Any, stabilisation: Any
) -> None:
    advice = recommend_supg(twisting_column(poisson_ratio=nu))
    assert advice.formulation == formulation
    assert advice.stabilisation == stabilisation


def test_the_reason_holds_the_numbers_of_its_row(table: None) -> None:
    advice = recommend_supg(twisting_column(poisson_ratio=0.25))
    assert advice.evidence == Evidence(0.3, "{p,F}", "SUPG-H1", 1.08, 0.87, 0.9)
    assert advice.reason == (
        "{p,F} with SUPG-H1: in studies.pareto at nu = 0.3 (the next tried above 0.25) it has 1.08 "
        "times the smallest error at equal particles and takes 0.87 times the CPU time and 0.90 "
        "times the memory of the most accurate formulation"
    )
    above = recommend_supg(twisting_column(poisson_ratio=0.499)).reason
    assert "without stabilisation" in above
    assert "nu = 0.495 (the largest tried)" in above
    assert "has the smallest error" in above


def test_a_law_of_the_cofactor_gets_its_law_and_no_numbers(table: None) -> None:
    neo_hookean = twisting_column(poisson_ratio=0.495)
    material = sph.MooneyRivlin.from_young(
        young_modulus=17e6, poisson_ratio=0.495, density=1100.0, cofactor_share=0.3
    )
    assert material.depends_on_H
    advice = recommend_supg(replace(neo_hookean, material=material))
    assert advice.formulation == sph.PFHJ()
    assert advice.stabilisation == default_stabilisation(sph.PFHJ(), material)
    assert advice.evidence == NotMeasured()
    assert "no such material" in advice.reason


def test_the_restraint_is_recommended_with_numbers_where_there_are_any(
    tmp_path: Path, monkeypatch: Any
) -> None:
    scene = twisting_column(poisson_ratio=0.25)
    path = tmp_path / "recommendations.csv"
    monkeypatch.setattr(module, "RECOMMENDATIONS", path)
    # A table of SUPG methods alone, as it was made before there was a restraint.
    path.write_text(HEAD + 'all,0.3,"{p,F}",SUPG-H1,1.08,0.87,0.9,9,x\n')
    plain = recommend(scene)
    assert (plain.formulation, plain.stabilisation) == (sph.Displacement(), sph.Restraint())
    assert plain.evidence == NotMeasured()
    assert not any(letter.isdigit() for letter in plain.reason)
    path.write_text(
        f'family,{HEAD}supg,all,0.3,"{{p,F}}",SUPG-H1,1.08,0.87,0.9,9,x\n'
        "restraint,column,0.3,displacement,restraint,7,7,7,9,x\n"
        "restraint,all,0.3,displacement,restraint,1,0.45,0.2,9,x\n"
    )
    measured = recommend(scene)
    assert measured.evidence == Evidence(0.3, "displacement", "restraint", 1.0, 0.45, 0.2)
    assert measured.reason == plain.reason + (
        "; in studies.pareto at nu = 0.3 (the next tried above 0.25) it has the smallest error at "
        "equal particles and takes 0.45 times the CPU time and 0.20 times the memory of the most "
        "accurate formulation"
    )
    assert recommend_supg(scene).formulation == sph.PF()
    material = sph.MooneyRivlin.from_young(
        young_modulus=17e6, poisson_ratio=0.3, density=1100.0, cofactor_share=0.3
    )
    assert recommend(replace(scene, material=material)).evidence == NotMeasured()


def test_a_table_without_supg_rows_is_said(tmp_path: Path, monkeypatch: Any) -> None:
    path = tmp_path / "recommendations.csv"
    path.write_text(HEAD)
    monkeypatch.setattr(module, "RECOMMENDATIONS", path)
    with pytest.raises(InputError, match="no row of the family supg"):
        recommend_supg(twisting_column())


def test_what_is_shipped_can_be_run() -> None:
    for nu in (0.0, 0.3, 0.45, 0.495, 0.4999):
        scene = twisting_column(poisson_ratio=nu)
        advice = recommend_supg(scene)
        sim = sph.Simulation(
            scene, spacing=0.5, formulation=advice.formulation, stabilisation=advice.stabilisation
        )
        sim.advance(sim.stable_time_step())
        assert isinstance(advice.evidence, Evidence)
        assert advice.evidence.error_ratio >= 1.0


def test_the_recommendations_are_those_of_the_report() -> None:
    """Shipped with the package, measured by ``python -m studies.pareto``."""
    pd.testing.assert_frame_equal(pd.read_csv(module.RECOMMENDATIONS), pd.read_csv(REPORT))


def test_the_plan_names_the_stabilisation_that_is_active() -> None:
    """The table was made on lattices; tetrahedra have other secondary particles."""
    rubber = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)
    scene = Scene("s", TetBox(), rubber, 0.01)
    supg = default_supg(sph.PF(), rubber, secondary=default_secondary(scene.body.mesh(0.5)))
    tets = sph.Simulation(scene, spacing=0.5, stabilisation=supg)
    lattice = sph.Simulation(Scene("s", Box(), rubber, 0.01), spacing=0.5)
    assert recommend_supg(tets.scene).evidence.stabilisation == "SUPG-H1"  # type: ignore[union-attr]
    [said] = [line for line in tets.plan().splitlines() if line.startswith("formulation ")]
    assert said.endswith(f"; active here: {tets.stabilisation.name}")
    assert "SUPG-H1" not in tets.stabilisation.name
    assert "active here" not in lattice.plan()
