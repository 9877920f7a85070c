"""A report is carried over to later sources only where cases that run again give its rows."""

from __future__ import annotations

import json
import math

import pytest

from sphsolid.errors import InputError
from studies.engine import carry as module
from studies.engine.carry import carry, differences, kept_outcomes, sample
from studies.engine.case import Case, Outcome, execute, partial_path, store
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


def test_without_kept_cases_nothing_is_said(report):
    study, folder = report
    for path in (folder / "partial").glob("*.json"):
        path.unlink()
    with pytest.raises(InputError, match="no case of the report is kept"):
        carry(study, cases=3)


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
