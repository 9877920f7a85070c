"""The convergence study from the command line to the report, on grids that take seconds."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import pandas as pd
import pytest

from sphsolid.errors import InputError
from studies import convergence
from studies.engine.results import Results, read_results
from studies.engine.study import main, parse
from studies.measures.tables import select
from studies.readme_table import slopes


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The cross of the short form to h = 1/8."""
    folder = tmp_path_factory.mktemp("convergence")
    listed = [
        case
        for cells in (4, 8)
        for case in (
            *convergence.of_level(cells, quick=True),
            *convergence.nearly_incompressible(cells, convergence.NEAR[::2]),
        )
    ]
    study = dataclasses.replace(convergence.STUDY, cases=lambda options: listed)
    assert main(study, ["--out", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def results(out: Path) -> Results:
    return read_results("convergence", out)


def test_the_study_writes_what_it_promises(out: Path) -> None:
    for name in (
        "table.csv.xz", "orders.csv", "summary.csv", "claims.csv", "convergence.png",
        "figures/convergence.pdf", "figures/incompressible.pdf", "report.pdf", "run.json",
    ):  # fmt: skip
        assert (out / name).stat().st_size > 0, name
    assert json.loads((out / "run.json").read_text())["cases_failed"] == 0


def test_the_table_has_a_row_for_each_component_of_each_run(results: Results) -> None:
    table = results.tables["table"]
    assert set(table["component"]) == {*"xyz", *(a + b for a in "xyz" for b in "xyz")}
    assert (table.groupby([*convergence.SETTING, "h"]).size() == 12).all()
    assert (table["error"] > 0.0).all()
    assert set(table["particles"]) == {5**3, 9**3}


def test_orders_repeat_what_the_table_says(results: Results) -> None:
    table, orders = results.tables["table"], results.tables["orders"]
    one = orders.iloc[0]
    same = table[(table[convergence.FAMILY] == one[convergence.FAMILY]).all(axis=1)]
    errors = same.set_index("h")["error"]
    assert one["order_last"] == pytest.approx(math.log2(errors[0.25] / errors[0.125]), abs=1e-6)


def test_consistent_is_second_order_and_literal_is_not_already_on_coarse_grids(
    results: Results,
) -> None:
    slope = select(results.tables["summary"], scene="linear", nu=0.3).set_index("method")
    own = (convergence.PACKAGE, convergence.SUPG, *convergence.BY_OPERATOR["paper"])
    for method in own:
        assert (slope.loc[[method.name], "slope_p_last"] > 1.9).all(), method.name
    assert (slope.loc[["paper, Literal"], "slope_P_last"] < 1.2).all()


def test_the_first_table_has_the_methods_in_the_order_of_their_meaning(results: Results) -> None:
    first = convergence.headline(results.tables["summary"])
    assert first["method"].tolist()[:2] == ["package default", "self-adjoint SUPG"]
    assert first["method"].iloc[-1] == "B-bar FEM"
    assert first.notna().all(axis=None)
    summary = results.tables["summary"]
    found = slopes(summary, "package default")
    worst = select(summary, nu=0.3, method="package default")["slope_P_last"].min()
    assert found["slope_P"] == worst
    assert all(math.isnan(number) for number in slopes(summary, "of no registry").values())
    with pytest.raises(InputError, match="has not all of paper: run"):
        slopes(summary[(summary["method"] != "paper") | (summary["scene"] == "linear")], "paper")


def test_claims_are_of_the_worst_run_and_fall_with_the_numbers(results: Results) -> None:
    def verdicts(summary: pd.DataFrame, table: pd.DataFrame) -> dict[tuple[str, str], str]:
        found = convergence.claims({"summary": summary, "table": table})
        return {(claim.what, claim.where): claim.verdict for claim in found}

    summary, table = results.tables["summary"].copy(), results.tables["table"]
    assert {"met", "reported"} <= set(verdicts(summary, table).values()) <= {
        "met", "not met", "reported",
    }  # fmt: skip
    variant = (summary["method"] == "paper, {p,F,J}, H6") & (summary["family"] == "A=B=C")
    worst = ("momentum slope, paper", "linear, A=B=C, paper, {p,F,J}, H6")
    for slope, verdict in ((1.0, "not met"), (1.951, "met")):
        summary.loc[variant, "slope_p_last"] = slope
        summary.loc[~variant, "slope_p_last"] = 2.0
        assert verdicts(summary, table)[worst] == verdict
    summary.loc[variant, "folded"] = True
    assert verdicts(summary, table)[worst] == "not met"
    at_17 = table[table["h"] == 0.125].assign(h=1.0 / 16.0, error=2.61e-3)
    errors = verdicts(summary, at_17)
    for name in ("package default", "self-adjoint SUPG"):
        assert errors["p_x at 17^3, nu 0.3", name] == "not met"
        assert errors["P_xx at 17^3, nu 0.3", name] == "met"
    assert errors["p_x at 17^3, nu 0.499", "paper, tau_p = 0.1 dt, {p,F,J}"] == "met"


@pytest.mark.parametrize(
    ("nu", "changes", "verdicts"),
    [
        (0.3, {}, ["met"] * 4),
        (0.3, {"slope_P_last": 1.89}, ["met", "not met", "met", "met"]),
        (0.3, {"error_P_h16": 1.2e-2}, ["met", "met", "met", "not met"]),
        (0.495, {"error_P_h16": 1.2e-2}, ["met"] * 4),
        (0.495, {"error_p_h16": 4.6e-3}, ["met", "met", "not met", "met"]),
        (0.495, {"slope_p_last": 1.94}, ["not met", "met", "met", "met"]),
        (0.3, {"folded": True}, ["not met"] * 4),
    ],
)  # fmt: skip
def test_the_default_is_asked_for_slopes_and_largest_errors(
    nu: float, changes: dict[str, float], verdicts: list[str]
) -> None:
    good = {
        "scene": "linear, moving start", "family": "A+B+C=0", "folded": False, "slope_p_last": 2.0,
        "slope_P_last": 1.95, "error_p_h16": 4.4e-3, "error_P_h16": 1.0e-2,
    }  # fmt: skip
    # One level of the wave that begins displaced: no slopes.
    displaced = {"scene": "linear", "slope_p_last": math.nan, "slope_P_last": math.nan}
    rows = [
        good | {"nu": nu, "method": name} | (changes if name == "package default" else {}) | start
        for name in ("package default", "B-bar FEM")
        for start in ({}, displaced)
    ]
    summary = pd.DataFrame(rows, columns=convergence.SUMMARY)
    table = pd.DataFrame(columns=convergence.COLUMNS)
    found = convergence.claims({"summary": summary, "table": table})
    own = [claim for claim in found if "package default" in claim.what + claim.where]
    judged = [claim for claim in own if claim.comparison != "reported"]
    assert [claim.verdict for claim in judged] == verdicts
    (over,) = [claim for claim in own if claim.comparison == "reported"]
    assert over.what == f"error of stress at 17^3 over that of elements, nu {nu:g}"
    assert over.measured == pytest.approx(changes.get("error_P_h16", 1.0e-2) / 1.0e-2)


@pytest.mark.parametrize(
    ("words", "finest"),
    [([], 32), (["--quick"], 16), (["--quick", "--finest", "8"], 8), (["--finest", "64"], 64),
     (["--quick", "--finest", "32"], 32)],
)  # fmt: skip
def test_the_finest_level_is_the_one_that_is_named(words: list[str], finest: int) -> None:
    listed = convergence.cases(parse(convergence.STUDY, words))
    levels = {case.arguments["cells"] for case in listed}
    assert levels == {cells for cells in (4, 8, 16, 32, 64) if cells <= finest}
    assert len({case.key for case in listed}) == len(listed)


def test_bad_command_lines_get_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(convergence.STUDY, ["--finest", "5"]) == 2
    assert capsys.readouterr().err.startswith("error: --finest 5")
