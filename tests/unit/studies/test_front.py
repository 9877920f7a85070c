"""The front: cases run, stop, fail, resume; what a study leaves behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import textwrap
import time

import pandas as pd
import pytest

from studies.harness import cases as cases_module
from studies.harness import front
from studies.harness.cases import Case, Outcome, case_hash, execute, load, partial_path, store
from studies.harness.front import main
from studies.harness.pool import longest_first, run_cases
from studies.harness.progress import Estimate, duration


def power(h, *, log="", cost=1.0, order=2.0):
    arguments = {"h": h, "order": order, "log": str(log)}
    return Case(f"h = {h:g}", "fake_cases:power_law", arguments, cost)


def finished(log):
    return sorted(float(line) for line in log.read_text().split()) if log.exists() else []


def test_a_study_leaves_tables_report_and_provenance(fake_study, tmp_path, capsys):
    out = tmp_path / "out"
    study = fake_study([power(0.25), power(0.125)], full=True)
    assert main(study, ["--out", str(out), "--jobs", "1"]) == 0
    names = {"table.csv", "orders.csv", "failures.csv", "run.json", "report.pdf"}
    names |= {"convergence.pdf", "convergence.png", "partial"}
    assert {path.name for path in out.iterdir()} == names
    orders = pd.read_csv(out / "orders.csv")
    assert list(orders["order_last"]) == pytest.approx([2.0, 2.0])
    run = json.loads((out / "run.json").read_text())
    assert run["cases"] == 2
    assert run["cases_failed"] == 0
    assert run["command"] == "python -m studies.fake --out out --jobs 1"
    for name in ("version", "python", "cpu", "cores", "date_utc", "source_hash", "wall_s"):
        assert run[name]
    assert str(tmp_path) not in (out / "run.json").read_text()
    printed = capsys.readouterr().out
    assert "compiling kernels (first run only)" in printed
    assert "[1/2]" in printed
    assert "left" in printed

    before = (out / "report.pdf").read_bytes()
    (out / "report.pdf").unlink()
    assert main(study, ["--out", str(out), "--report-only"]) == 0
    assert (out / "report.pdf").read_bytes() == before
    assert "compiling" not in capsys.readouterr().out


def test_resume_runs_only_what_is_missing(fake_study, tmp_path):
    log, out = tmp_path / "log", tmp_path / "out"
    study = fake_study([power(0.25, log=log), power(0.125, log=log), power(0.5, log=log)])
    for case in study.cases(None):
        execute(case, partial_path(out / "partial", case))
    partial = sorted((out / "partial").glob("*.json"))
    assert len(partial) == 3
    kept = next(path for path in partial if "0.125" in path.name)
    kept.unlink()
    # What a killed writer leaves is not a result.
    (out / "partial" / f".{kept.name}.1234.part").write_text('{"key": "h = 0.1')
    (out / "partial" / partial[-1].name).write_text('{"key": "h = 0.5", "wall_s": 1.0, "ro')
    log.unlink()
    assert main(study, ["--out", str(out), "--jobs", "1", "--resume"]) == 0
    assert finished(log) == [0.125, 0.5]
    table = pd.read_csv(out / "table.csv")
    assert list(table["h"]) == [0.25, 0.25, 0.125, 0.125, 0.5, 0.5], "the order is of the cases"
    assert json.loads((out / "run.json").read_text())["cases_resumed"] == 1


def test_changed_source_or_argument_runs_again(monkeypatch):
    case = power(0.25)
    before = case_hash(case)
    assert before == case_hash(power(0.25))
    assert before != case_hash(power(0.25, order=1.0))
    assert before == case_hash(power(0.25, cost=7.0)), "an estimate is not part of the result"
    monkeypatch.setattr(cases_module, "source_hash", lambda: "another")
    assert before != case_hash(case)


def test_resume_runs_again_what_a_change_made_stale(fake_study, tmp_path, monkeypatch):
    log, out = tmp_path / "log", tmp_path / "out"
    study = fake_study([power(0.25, log=log), power(0.125, log=log)])
    arguments = ["--out", str(out), "--jobs", "1"]
    for case in study.cases(None):
        execute(case, partial_path(out / "partial", case))
    log.unlink()
    main(study, [*arguments, "--resume"])
    assert finished(log) == []
    monkeypatch.setattr(cases_module, "source_hash", lambda: "another")
    main(study, [*arguments, "--resume"])
    assert finished(log) == [0.125, 0.25]
    main(study, arguments)
    assert finished(log) == [0.125, 0.125, 0.25, 0.25], "without --resume everything runs"
    assert len(list((out / "partial").iterdir())) == 2, "and nothing stale stays"


def test_failures_become_rows_and_hurt_nobody(fake_study, tmp_path, capsys):
    out = tmp_path / "out"
    study = fake_study(
        [
            power(0.25, cost=9.0),
            Case("lost", "fake_cases:diverges", {"h": 0.5}, 5.0),
            Case("mistake", "fake_cases:breaks", {}, 4.0),
            Case("killed", "fake_cases:dies", {}, 3.0),
            power(0.125, cost=2.0),
        ]
    )
    assert main(study, ["--out", str(out), "--jobs", "2"]) == 0
    failures = pd.read_csv(out / "failures.csv").set_index("key")
    assert list(failures["failure"]) == ["Diverged", "ZeroDivisionError", "WorkerDied"]
    assert "step 12, point 3" in failures.loc["lost", "message"]
    assert "breaks" in failures.loc["mistake", "message"]
    assert os.sep not in failures.loc["mistake", "message"]
    assert sorted(set(pd.read_csv(out / "table.csv")["h"])) == [0.125, 0.25]
    assert "failed: killed" in capsys.readouterr().out
    # A lost solution is a result; anything else is tried again.
    kept = front._kept(study.cases(None), out / "partial")
    assert sorted(kept) == ["h = 0.125", "h = 0.25", "lost"]


def test_wrong_input_is_one_line(fake_study, tmp_path, capsys):
    nothing_there = ["--out", str(tmp_path / "none"), "--report-only"]
    assert main(fake_study([power(0.25)]), nothing_there) == 2
    assert "run it without --report-only" in capsys.readouterr().err
    twice = fake_study([power(0.25), power(0.25)])
    assert main(twice, ["--out", str(tmp_path)]) == 2
    assert "keys repeat" in capsys.readouterr().err
    unstorable = fake_study([Case("x", "fake_cases:power_law", {"h": object()})])
    assert main(unstorable, ["--out", str(tmp_path), "--resume"]) == 2
    assert "arguments must be" in capsys.readouterr().err
    for bad in (["--jobs", "0"], ["--quick", "--full"]):
        with pytest.raises(SystemExit):
            main(twice, bad)


def test_quick_does_not_replace_the_whole_study(fake_study, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    main(fake_study([power(0.25), power(0.125)]), ["--quick", "--jobs", "1"])
    assert (tmp_path / "out" / "fake-quick" / "report.pdf").exists()
    assert not (tmp_path / "reports").exists()


def test_workers_have_one_thread_and_leave_the_environment(tmp_path, monkeypatch):
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    case = Case("s", "fake_cases:sleeps", {"seconds": 0.0})
    [(_, outcome)] = run_cases([case], folder=tmp_path, jobs=1)
    assert outcome.rows[0]["threads"] == "1"
    assert "NUMBA_NUM_THREADS" not in os.environ


def test_outcomes_survive_the_disk(tmp_path):
    case = power(1.0 / 3.0)
    outcome = execute(case, partial_path(tmp_path, case))
    assert load(partial_path(tmp_path, case)) == outcome
    assert outcome.rows[0]["error"] == (1.0 / 3.0) ** 2
    failed = Outcome("k", 1.0, failure="Diverged", message="gone", lost=True)
    store(tmp_path / "f.json", failed)
    assert load(tmp_path / "f.json") == failed
    assert load(tmp_path / "none.json") is None


def test_ctrl_c_keeps_what_is_done(tmp_path):
    """The whole process, as a person would stop it."""
    script = tmp_path / "study.py"
    script.write_text(
        textwrap.dedent("""
            import sys
            from conftest import report, tables
            from studies.harness.cases import Case
            from studies.harness.front import Study, main

            def cases(options):
                law = {"h": 0.25, "order": 2.0}
                return [
                    Case("short", "fake_cases:power_law", law, 2.0),
                    Case("long", "fake_cases:sleeps", {"seconds": 60.0}, 1.0),
                ]

            def warm_up(options):
                return []

            STUDY = Study(name="fake", cases=cases, tables=tables, report=report, warm_up=warm_up)
            if __name__ == "__main__":
                sys.exit(main(STUDY))
        """)
    )
    out = tmp_path / "out"
    environment = os.environ | {"SPHSOLID_CACHE": str(tmp_path / "kernels")}
    command = [sys.executable, str(script), "--out", str(out), "--jobs", "1"]
    process = subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        # A shell's background jobs ignore Ctrl-C and hand that on to their children.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    deadline = time.monotonic() + 120.0
    while not list(out.glob("partial/short*.json")):
        assert time.monotonic() < deadline
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "--resume" in errors
    assert [path.name[:5] for path in (out / "partial").iterdir()] == ["short"]


def test_order_of_work_and_estimate():
    work = [power(0.5, cost=1.0), power(0.25, cost=8.0), power(0.125, cost=3.0)]
    assert [case.cost for case in longest_first(work)] == [8.0, 3.0, 1.0]
    estimate = Estimate(work, jobs=2)
    assert estimate.seconds_left() is None
    assert estimate.percent == 0.0
    estimate.started(work[1])
    estimate.finished(work[1], Outcome(work[1].key, 80.0))
    # 10 s a unit: 30 s and 10 s are left, on two workers.
    assert estimate.seconds_left() == pytest.approx(30.0)
    assert estimate.percent == pytest.approx(100.0 * 8.0 / 12.0)
    for case in (work[0], work[2]):
        estimate.finished(case, Outcome(case.key, 1.0))
    assert estimate.percent == 100.0


def test_the_start_of_a_worker_is_not_taken_for_its_pace():
    """Two workers, five seconds to start each, then one second a unit of cost."""
    work = [power(1.0 / n, cost=1.0) for n in range(1, 13)]
    estimate = Estimate(work, jobs=2)
    for case in work[:2]:
        estimate.started(case)
    estimate.finished(work[0], Outcome(work[0].key, 6.0))
    estimate.started(work[2])
    # All that is known is a bound: 11 units left at six seconds on two workers.
    assert estimate.text() == "at most 33 s left"
    estimate.finished(work[1], Outcome(work[1].key, 6.0))
    estimate.finished(work[2], Outcome(work[2].key, 1.0))
    assert estimate.seconds_left() == pytest.approx(4.5)
    assert estimate.text() == "4.5 s left"


def test_a_study_of_as_many_cases_as_workers_ends_with_done():
    work = [power(0.5), power(0.25)]
    estimate = Estimate(work, jobs=2)
    for case in work:
        estimate.started(case)
    for case in work:
        estimate.finished(case, Outcome(case.key, 6.0))
    assert estimate.text() == "done"


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (None, "?"),
        (float("nan"), "?"),
        (4.12, "4.1 s"),
        (42.0, "42 s"),
        (125.0, "2 min 05 s"),
        (4210.0, "1 h 10 min"),
    ],
)
def test_durations(seconds, text):
    assert duration(seconds) == text


@pytest.mark.parametrize("bad", [{"run": "no_function"}, {"cost": 0.0}, {"cost": float("inf")}])
def test_a_case_is_checked(bad):
    from sphsolid.errors import InputError

    with pytest.raises(InputError):
        Case(**({"key": "k", "run": "fake_cases:power_law"} | bad))
