"""A report is carried over to later sources only where cases that run again give its rows."""

from __future__ import annotations

import json
import math

import pandas as pd
import pytest

from sphsolid.errors import InputError
from studies.engine import carry as module
from studies.engine.carry import (
    carry,
    differences,
    keep_others,
    keep_sequences,
    kept_outcomes,
    sample,
    sequence_of,
    with_times_of,
)
from studies.engine.case import Case, Outcome, execute, load, partial_path, store
from studies.engine.results import read_table, write_table
from studies.engine.tabled import compared
from tests.unit.studies.fake_study import Law, power_law, study_of


def cases():
    return [
        Case(f"order 2, h {h:g}", power_law, {"h": h, "law": Law(2.0)}) for h in (0.5, 0.25, 0.125)
    ]


@pytest.fixture
def report(tmp_path, monkeypatch):
    """A study whose report and kept cases lie in a folder of its own, made by older sources."""
    study = study_of(cases(), tmp_path)
    monkeypatch.setattr(
        module, "parse", lambda study, given: type("Options", (), {"out": tmp_path})()
    )
    for case in study.cases(None):
        store(partial_path(tmp_path / "partial", case), execute(case))
    run = {"study": "fake", "study_hash": "older", "cases": 3}
    (tmp_path / "run.json").write_text(json.dumps(run))
    return study, tmp_path


def stamped(folder):
    return json.loads((folder / "run.json").read_text())


def test_the_same_rows_carry_a_report_over(report, capsys):
    study, folder = report
    assert carry(study, cases=2) == []
    run = stamped(folder)
    assert run["study_hash"] == study.sources
    assert run["carried"]["cases"] == 2
    assert capsys.readouterr().out.count("same") == 2


def test_one_other_value_leaves_it_older(report):
    study, folder = report
    [path] = (folder / "partial").glob("*0.25*")
    kept = json.loads(path.read_text())
    kept["rows"][1]["error"] *= 1.0 + 1e-7
    path.write_text(json.dumps(kept))
    assert any("row 2, error" in each for each in carry(study, cases=3))
    assert stamped(folder) == {"study": "fake", "study_hash": "older", "cases": 3}


def test_one_may_differ_by_what_the_stamp_says(report):
    study, folder = report
    [path] = (folder / "partial").glob("*0.25*")
    kept = json.loads(path.read_text())
    kept["rows"][1]["error"] *= 1.0 + 1e-7
    path.write_text(json.dumps(kept))
    assert carry(study, cases=3, within=1e-6) == []
    assert stamped(folder)["carried"]["within"] == 1e-6


@pytest.fixture
def clone(report):
    """The same without what was kept of its cases: the tables are all there is."""
    study, folder = report
    rows = [row for case in study.cases(None) for row in execute(case).rows]
    for path in (folder / "partial").glob("*.json"):
        path.unlink()
    for name, table in study.tables(rows).items():
        write_table(table, folder, name)
    write_table(pd.DataFrame(columns=["key"]), folder, "failures")
    run = {"study": "fake", "study_hash": "older", "cases": 3, "tables": [*study.tables(rows)]}
    (folder / "run.json").write_text(json.dumps(run))
    return study, folder


def test_in_a_clone_rows_are_looked_for_in_the_tables(clone):
    study, folder = clone
    assert carry(study, cases=3) == []
    assert stamped(folder)["study_hash"] == study.sources
    assert stamped(folder)["carried"]["cases"] == 3


def test_a_row_that_is_in_no_table_leaves_the_report_older(clone):
    study, folder = clone
    table = read_table(folder, "table")
    table.loc[3, "error"] *= 1.001
    write_table(table, folder, "table")
    [words] = carry(study, cases=3)
    assert "error: " in words
    assert "in the report" in words
    assert stamped(folder)["study_hash"] == "older"
    assert carry(study, cases=3, within=1e-2) == []


def test_without_tables_of_its_rows_nothing_is_said(clone):
    study, folder = clone
    write_table(pd.DataFrame({"other": [1.0]}), folder, "table")
    write_table(pd.DataFrame({"other": [1.0]}), folder, "orders")
    with pytest.raises(InputError, match="gives a row of its tables"):
        carry(study, cases=3)


def test_a_row_is_compared_with_the_table_that_shares_most_of_it():
    tables = {
        "table": pd.DataFrame({"name": ["a", "b"], "sound": [True, None], "x": [1.0, 2.0],
                               "y": [3.0, None]}),
        "fits": pd.DataFrame({"name": ["a"], "x": [7.0]}),
    }  # fmt: skip

    def of(**row):
        return compared([row], tables, lambda name: name == "wall_s")

    assert of(name="a", sound=True, x=1.0, y=3.0, wall_s=9.0, kind="run") == (1, [])
    # What the report does not have, or the row, is not compared.
    assert of(name="b", x=2.0, y=5.0) == (1, [])
    assert of(name="a", sound=True, x=1.0, y=math.nan) == (1, [])
    assert of(name="c", x=2.0, y=5.0) == (1, ["row 1, none with name = c"])
    assert of(name="a", x=1.0, y=3.1)[1][0].startswith("row 1, y: 3.1, in the report 3.0")
    assert of(name="a", x=1.0) == (0, [])


def test_times_are_not_compared_and_missing_values_are_equal():
    old = [{"wall_s": 1.0, "cpu_s": 2.0, "error": math.nan, "name": "a", "list": [1.0, 2.0]}]
    new = [{"wall_s": 3.0, "cpu_s": 4.0, "error": math.nan, "name": "a", "list": [1.0, 2.0]}]
    assert list(differences(old, new)) == []
    assert list(differences(old, [new[0] | {"name": "b"}])) == ["row 1, name: 'b', before 'a'"]
    assert list(differences(old, [new[0] | {"list": [1.0]}])) != []
    assert list(differences(old, [])) == ["0 rows, 1 before"]
    assert list(differences(old, [new[0] | {"more": 1.0}])) == ["row 1, more: 1.0, before None"]


def test_a_sample_is_of_the_whole_list_without_the_long_ones(tmp_path):
    listed = cases()
    for case, wall in zip(listed, (1.0, 100.0, 2.0), strict=True):
        store(partial_path(tmp_path, case), Outcome(case.key, wall, [{"x": 1.0}]))
    chosen = sample(listed, kept_outcomes(tmp_path), 5)
    assert [case.key for case, _ in chosen] == [listed[0].key, listed[2].key]


def by_older_sources(folder, change):
    """Give the kept cases the names that other sources would have given, and change some rows."""
    for path in folder.glob("*.json"):
        kept = json.loads(path.read_text())
        change(kept)
        path.with_name(f"{path.stem.rpartition('-')[0]}-0123456789abcdef.json").write_text(
            json.dumps(kept)
        )
        path.unlink()


def two_sequences(tmp_path, monkeypatch):
    """A study of two sequences of three cases each, all of them run and kept in a folder."""
    listed = [
        Case(f"order {order:g} 1/{n}", power_law, {"h": 1.0 / n, "law": Law(order)})
        for order in (1.0, 2.0)
        for n in (2, 4, 8)
    ]
    study = study_of(listed, tmp_path)
    monkeypatch.setattr(
        module, "parse", lambda study, given: type("Options", (), {"out": tmp_path})()
    )
    folder = tmp_path / "partial"
    for case in listed:
        store(partial_path(folder, case), execute(case))
    return study, listed, folder


def test_one_case_of_a_sequence_keeps_it_for_resume(tmp_path, monkeypatch):
    study, listed, folder = two_sequences(tmp_path, monkeypatch)

    def change(kept):
        if kept["key"].startswith("order 2"):
            kept["rows"][0]["error"] *= 1.0 + 1e-7

    by_older_sources(folder, change)
    count, differ = keep_sequences(study)
    assert count == 3
    assert [each.split(",")[0].split(" 1/")[0] for each in differ] == ["order 2"]
    found = [load(partial_path(folder, case)) for case in listed]
    assert [outcome is not None for outcome in found[:3]] == [True] * 3
    assert sum(outcome.sampled for outcome in found[:3]) == 2
    # The other sequence is left for --resume.
    assert found[3:] == [None] * 3
    # Or it runs again at once, and has the times that were measured before.
    keep_sequences(study, keep_times=True)
    found = [load(partial_path(folder, case)) for case in listed[3:]]
    assert all(outcome.older_times for outcome in found)


def test_what_a_change_touches_runs_again_and_of_the_others_a_sample(tmp_path, monkeypatch):
    study, listed, folder = two_sequences(tmp_path, monkeypatch)

    def change(kept):
        if kept["key"] in ("order 2 1/2", "order 1 1/8"):
            kept["rows"][0]["error"] *= 1.0 + 1e-7

    by_older_sources(folder, change)
    # One of the others differs: none is kept.
    count, differ = keep_others(study, again="order 2", cases=3)
    assert count == 0
    assert [each.split(":")[0] for each in differ] == ["order 1 1/8"]
    assert not any(partial_path(folder, case).exists() for case in listed)
    # None of these does.
    assert keep_others(study, again="order 2|1/8", cases=1, keep_times=True) == (2, [])
    found = [load(partial_path(folder, case)) for case in listed]
    assert sum(outcome.sampled for outcome in found[:2]) == 1
    assert all(outcome.older_times for outcome in found[2:])
    assert found[3].rows == execute(listed[3]).rows


def test_times_of_before_stay_with_the_rows_of_now():
    old = [{"step_cpu_s": 1.0, "window_steps": 3, "steps": 10, "error": 0.1}]
    new = [{"step_cpu_s": 2.0, "window_steps": 4, "steps": 11, "error": 0.2}]
    [row] = with_times_of(old, new)
    assert row == {"step_cpu_s": 1.0, "window_steps": 3, "steps": 11, "error": 0.2}
    assert with_times_of([], new) == new


def test_a_sequence_is_the_key_without_the_spacing():
    assert sequence_of(Case("column nu 0.3 B-bar 1/16 reference", power_law)) == (
        "column nu 0.3 B-bar reference"
    )
    assert sequence_of(Case("CalculiX, column, nu 0.3, 4", power_law)) == "CalculiX, column, nu 0.3"
