"""The studies from the command line to the report, on grids that take seconds."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import sphsolid as sph
from sphsolid.scenes import twisting_column
from studies.convergence import study as convergence
from studies.convergence.verdicts import verdict_table
from studies.harness.cases import ROOT
from studies.harness.front import main, parse
from studies.harness.results import read_results
from studies.operators import cases as operators_cases
from studies.report.readme_table import BEGIN, END, results_table, with_table


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The cross of the short form to h = 1/8."""
    folder = tmp_path_factory.mktemp("convergence")
    listed = [
        case
        for cells in (4, 8)
        for case in (
            *convergence._of_level(cells, quick=True),
            *convergence._nearly_incompressible(cells, ("H1",)),
        )
    ]
    study = dataclasses.replace(convergence.STUDY, cases=lambda options: listed)
    assert main(study, ["--out", str(folder)]) == 0
    return folder


def test_the_study_writes_what_it_promises(out: Path) -> None:
    for name in (
        "table.csv", "orders.csv", "summary.csv", "convergence.png", "convergence.pdf",
        "report.pdf", "run.json",
    ):  # fmt: skip
        assert (out / name).stat().st_size > 0, name
    run = json.loads((out / "run.json").read_text())
    assert run["cases_failed"] == 0
    assert run["version"]


def test_the_table_has_a_row_for_each_component_of_each_run(out: Path) -> None:
    table = pd.read_csv(out / "table.csv", keep_default_na=False)
    for column in (
        "scene", "family", "method", "formulation", "secondary", "operator", "field", "component",
        "h", "particles", "steps", "error", "wall_s",
    ):  # fmt: skip
        assert column in table
    assert set(table["component"]) == {
        *"xyz", *(a + b for a in "xyz" for b in "xyz")
    }  # fmt: skip
    assert (table.groupby([*convergence.SETTING, "h"]).size() == 12).all()
    assert (table["error"] > 0.0).all()
    assert set(table["particles"]) == {5**3, 9**3}


def test_orders_repeat_what_the_table_says(out: Path) -> None:
    results = read_results("convergence", out)
    table, orders = results.tables["table"], results.tables["orders"]
    one = orders.iloc[0]
    same = table[(table[convergence.FAMILY] == one[convergence.FAMILY]).all(axis=1)]
    errors = same.set_index("h")["error"]
    assert one["order_last"] == pytest.approx(math.log2(errors[0.25] / errors[0.125]), abs=1e-6)


def test_consistent_is_second_order_and_literal_is_not_already_on_coarse_grids(out: Path) -> None:
    summary = read_results("convergence", out).tables["summary"]
    linear = summary[(summary["scene"] == "linear") & (summary["nu"] == 0.3)]
    supg = linear[linear["method"] == "SUPG-SPH"]
    assert (supg[supg["operator"] == "Consistent"]["slope_p_last"] > 1.9).all()
    assert (supg[supg["operator"] == "Literal"]["slope_P_last"] < 1.2).all()


def test_verdicts_name_what_was_asked_and_measured(out: Path) -> None:
    frame = verdict_table(read_results("convergence", out)).frame
    assert {"met", "reported"} <= set(frame["verdict"]) <= {"met", "not met", "reported"}
    assert "momentum slope, Consistent" in set(frame["what"])


def test_the_readme_table_is_that_of_the_reports() -> None:
    summary = pd.read_csv(
        ROOT / "reports" / "convergence" / "summary.csv",
        keep_default_na=False,
        na_values=["", "nan"],
    )
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert with_table(readme, results_table(summary)) == readme
    assert readme.index(BEGIN) < readme.index(END)


def test_the_twist_of_the_top_is_measured_as_turned() -> None:
    sim = sph.Simulation(twisting_column(), spacing=0.5)
    X = sim.cloud.X
    angle = 0.7
    turned = X.copy()
    turned[:, 0] = np.cos(angle) * X[:, 0] - np.sin(angle) * X[:, 2]
    turned[:, 2] = np.sin(angle) * X[:, 0] + np.cos(angle) * X[:, 2]
    sim.state.x[:] = turned
    assert operators_cases.twist_of_top(sim.snapshot()) == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize(
    ("words", "finest"),
    [([], 32), (["--quick"], 16), (["--quick", "--finest", "8"], 8), (["--finest", "64"], 64),
     (["--quick", "--finest", "32"], 32)],
)  # fmt: skip
def test_the_finest_level_is_the_one_that_is_named(words: list[str], finest: int) -> None:
    listed = convergence.cases(parse(convergence.STUDY, words))
    levels = {case.arguments["cells"] for case in listed}
    assert levels == {cells for cells in (4, 8, 16, 32, 64) if cells <= finest}


def test_bad_command_lines_get_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(convergence.STUDY, ["--finest", "5"]) == 2
    assert capsys.readouterr().err.startswith("error: --finest 5")
