"""The engine: cases run, stop, fail, resume; what a study leaves behind."""

from __future__ import annotations

import functools
import json
import os
import signal
import subprocess
import sys
import textwrap
import time
import types
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sphsolid.errors import InputError
from sphsolid.scenes import twisting_column
from studies.engine import case as case_module
from studies.engine import sources, study
from studies.engine.case import Case, Outcome, case_hash, execute, load, partial_path, store
from studies.engine.pool import Processes, longest_first
from studies.engine.progress import Estimate
from studies.engine.results import read_table, write_table
from studies.engine.sources import hash_of_sources
from studies.engine.study import main
from studies.methods import B_BAR, PACKAGE
from tests.unit.studies.fake_study import (
    TEXT,
    breaks,
    dies,
    diverges,
    forgets_the_list,
    power,
    power_law,
    sleeps,
    study_of,
)

ROOT = Path(__file__).resolve().parents[3]
SHORT = TEXT.split("{{ figure")[0]


def finished(log):
    return sorted(float(line) for line in log.read_text().split()) if log.exists() else []


def keep(cases, out):
    """What an earlier run of ``cases`` left."""
    for case in cases:
        store(partial_path(out / "partial", case), execute(case))


# --- what is left behind ------------------------------------------------------------------------


def test_a_study_leaves_tables_report_and_provenance(tmp_path, capsys):
    out = tmp_path / "out"
    fake = study_of([power(0.25), power(0.125)], tmp_path, warm_up=None)
    assert main(fake, ["--out", str(out), "--jobs", "1"]) == 0
    names = {"table.csv", "orders.csv", "claims.csv", "failures.csv", "run.json", "report.pdf"}
    made = {"convergence.png", "figures", "partial"}
    assert {path.name for path in out.iterdir()} == names | made
    assert [path.name for path in (out / "figures").iterdir()] == ["convergence.pdf"]
    assert list(pd.read_csv(out / "orders.csv")["order_last"]) == pytest.approx([2.0, 2.0])
    assert list(pd.read_csv(out / "claims.csv")["verdict"]) == ["met", "met"]
    run = json.loads((out / "run.json").read_text())
    assert (run["cases"], run["cases_failed"], run["jobs"]) == (2, 0, 1)
    assert run["command"] == "python -m tests.unit.studies.fake_study --out out --jobs 1"
    for name in ("version", "python", "cpu", "cores", "date_utc", "source_hash", "wall_s"):
        assert run[name]
    assert str(tmp_path) not in (out / "run.json").read_text()
    printed = capsys.readouterr().out
    assert "compiling kernels (first run only)" in printed
    assert "[1/2]" in printed
    assert "left" in printed

    before = (out / "report.pdf").read_bytes()
    (out / "report.pdf").unlink()
    assert main(fake, ["--out", str(out), "--report-only"]) == 0
    assert (out / "report.pdf").read_bytes() == before
    assert "compiling" not in capsys.readouterr().out


def test_quick_does_not_replace_the_whole_study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    main(study_of([power(0.25), power(0.125)], tmp_path, text=SHORT), ["--quick", "--jobs", "1"])
    assert (tmp_path / "out" / "fake-quick" / "report.pdf").exists()
    assert not (tmp_path / "reports").exists()


def test_wrong_input_is_one_line(tmp_path, capsys):
    one = [power(0.25)]
    for cases, text, given, said in (
        (one, TEXT, ["--report-only"], "run it without --report-only"),
        ([*one, *one], TEXT, [], "keys repeat"),
        ([], TEXT, [], "no cases"),
        ([Case("x", power_law, {"h": object()})], TEXT, ["--resume"], "no value that can be"),
        (one, "# T\n\n" + '{{ figure("none", "c") }}', [], "no figure 'none'"),
    ):
        fake = study_of(cases, tmp_path, text=text)
        assert main(fake, ["--out", str(tmp_path / "out"), "--jobs", "1", *given]) == 2
        [line] = capsys.readouterr().err.splitlines()
        assert line.startswith("error: ")
        assert said in line
    for bad in (["--jobs", "0"], ["--threads", "0"], ["--quick", "--full"]):
        with pytest.raises(SystemExit):
            main(study_of(one, tmp_path), bad)


# --- identity and resuming ----------------------------------------------------------------------


def test_a_case_is_known_by_the_values_of_its_objects_and_by_sources(monkeypatch):
    before = case_hash(power(0.25))
    assert before == case_hash(power(0.25, order=2)), "equal values are the same"
    assert before == case_hash(power(0.25, cost=7.0)), "an estimate is no part of the result"
    assert before != case_hash(power(0.25, order=1.0)), "an option of an object is"
    assert before != case_hash(Case("h = 0.25", sleeps, power(0.25).arguments))
    with pytest.raises(InputError, match="argument law = <object object at"):
        case_hash(Case("x", power_law, {"h": 1.0, "law": object()}))
    monkeypatch.setattr(case_module, "hash_of_sources", lambda *_: "another")
    assert before != case_hash(power(0.25))


def nested():
    def inner():
        return []

    return inner


@pytest.mark.parametrize(
    "bad",
    [{"run": nested()}, {"run": lambda: []}, {"run": functools.partial(power_law, h=1.0)},
     {"cost": 0.0}, {"cost": float("inf")}],
)  # fmt: skip
def test_a_case_that_no_worker_could_run_is_refused(bad):
    with pytest.raises(InputError):
        Case(**({"key": "k", "run": power_law} | bad))


def test_resume_runs_only_what_is_missing(tmp_path):
    log, out = tmp_path / "log", tmp_path / "out"
    cases = [power(h, log=log) for h in (0.25, 0.125, 0.5)]
    keep(cases, out)
    missing, torn = (partial_path(out / "partial", case) for case in cases[1:])
    missing.unlink()
    # What a killed writer leaves is not a result.
    missing.with_name(f".{missing.name}.1234.part").write_text('{"key": "h = 0.1')
    torn.write_text('{"key": "h = 0.5", "wall_s": 1.0, "ro')
    log.unlink()
    arguments = ["--out", str(out), "--jobs", "1", "--resume"]
    assert main(study_of(cases, tmp_path, text=SHORT), arguments) == 0
    assert finished(log) == [0.125, 0.5]
    table = pd.read_csv(out / "table.csv")
    assert list(table["h"]) == [0.25, 0.25, 0.125, 0.125, 0.5, 0.5], "the order is of the cases"
    assert json.loads((out / "run.json").read_text())["cases_resumed"] == 1


def test_resume_runs_again_what_a_change_made_stale(tmp_path, monkeypatch):
    log, out = tmp_path / "log", tmp_path / "out"
    cases = [power(0.25, log=log), power(0.125, log=log)]
    fake, arguments = study_of(cases, tmp_path, text=SHORT), ["--out", str(out), "--jobs", "1"]
    keep(cases, out)
    log.unlink()
    main(fake, [*arguments, "--resume"])
    assert finished(log) == []
    monkeypatch.setattr(case_module, "hash_of_sources", lambda *_: "another")
    main(fake, [*arguments, "--resume"])
    assert finished(log) == [0.125, 0.25]
    main(fake, arguments)
    assert finished(log) == [0.125, 0.125, 0.25, 0.25], "without --resume everything runs"
    assert len(list((out / "partial").iterdir())) == 2, "and nothing stale stays"


def test_outcomes_survive_the_disk(tmp_path):
    case = power(1.0 / 3.0)
    outcome = execute(case)
    assert outcome.rows[0]["error"] == (1.0 / 3.0) ** 2
    for kept in (outcome, Outcome("k", 1.0, failure="Diverged", message="gone", diverged=True)):
        store(tmp_path / "kept.json", kept)
        assert load(tmp_path / "kept.json") == kept
    assert load(tmp_path / "none.json") is None


SOURCES = {
    "my_package/__init__.py": "",
    "my_package/study.py": "import numpy\nfrom studies.methods import PACKAGE\nfrom . import far\n"
    "from .near import x as y\n\ndef cases():\n    \"\"\"Words.\"\"\"\n    other = 1\n"
    "    return y, far.reached(other), PACKAGE\n\ndef figure():\n    return other, cases()\n\n"
    "other = 3\n",
    "my_package/near.py": "hidden = 1\nx = hidden\nunused = 2\n",
    "my_package/far.py": "def reached(x):\n    return x + 1\n\ndef not_reached():\n    return 2\n",
    "my_script.py": "from my_beside import step\nimport my_package.near\n\n"
    "def cases():\n    return step(), my_package.near.unused\n",
    "my_beside.py": "def step():\n    return 5\n",
}


@pytest.mark.parametrize(
    ("file", "old", "new", "module"),
    [
        ("my_package/study.py", "return y,", "return y, y,", "my_package.study"),
        ("my_package/near.py", "hidden = 1", "hidden = 7", "my_package.study"),
        ("my_package/far.py", "x + 1", "x + 2", "my_package.study"),
        ("my_beside.py", "5", "6", "my_script"),
        ("my_package/study.py", "Words", "Other words", ""),
        ("my_package/study.py", "return other, cases()", "return 0", ""),
        # A name of the function itself is not that of the module.
        ("my_package/study.py", "other = 3", "other = 4", ""),
        ("my_package/near.py", "unused = 2", "unused = 3", "my_script"),
        ("my_package/near.py", "x = hidden", "x = hidden\nz = 4", ""),
        ("my_package/far.py", "return 2", "return 3", ""),
        ("my_package/far.py", "def reached", "\n# comment\n\ndef reached", ""),
    ],
)
def test_sources_are_what_a_function_reaches(tmp_path, monkeypatch, file, old, new, module):
    """In its package or beside its script, whatever figures and words change there."""
    (tmp_path / "my_package").mkdir()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "my_package", raising=False)
    found = []
    for text in (SOURCES[file], SOURCES[file].replace(old, new)):
        for name, usual in SOURCES.items():
            (tmp_path / name).write_text(text if name == file else usual)
        hashes = {}
        for name in ("my_package.study", "my_script"):
            sources._hash.cache_clear()
            sources._read.cache_clear()
            function = types.FunctionType((lambda: None).__code__, {"__name__": name}, "cases")
            function.__qualname__ = "cases"
            hashes[name] = hash_of_sources(function)
        found.append(hashes)
    sources._hash.cache_clear()
    sources._read.cache_clear()
    assert {name for name in found[0] if found[0][name] != found[1][name]} == {module} - {""}


def test_a_method_is_part_of_what_uses_it(monkeypatch):
    before = hash_of_sources(PACKAGE.but), case_hash(power(0.25))
    read = Path.read_text
    monkeypatch.setattr(
        Path, "read_text", lambda path, **more: read(path, **more).replace("made = name or", "m =")
    )
    sources._hash.cache_clear()
    sources._read.cache_clear()
    after = hash_of_sources(PACKAGE.but), case_hash(power(0.25))
    sources._hash.cache_clear()
    sources._read.cache_clear()
    assert (before[0] != after[0], before[1] == after[1]) == (True, True)


def elements_of(spacing):
    return B_BAR.simulation(twisting_column(), spacing=spacing)


@pytest.mark.parametrize(
    ("file", "counts"),
    [
        # What its solver imports, however deep, kernels and laws too.
        ("fem_reference/b_bar_kernels.py", True),
        ("sphsolid/continuum/neo_hookean.py", True),
        ("sphsolid/scenes/twisting_column.py", True),
        # Another scene, another method, another law.
        ("sphsolid/scenes/cable.py", False),
        ("fem_reference/pg_fem.py", False),
        ("sphsolid/scheme/jst.py", False),
        ("sphsolid/continuum/saint_venant_kirchhoff.py", False),
    ],
)
def test_of_the_solvers_the_modules_that_are_reached_count(monkeypatch, file, counts):
    before = hash_of_sources(elements_of)
    read = Path.read_text
    monkeypatch.setattr(
        Path, "read_text",
        lambda path, **more: read(path, **more)
        + ("\nchanged = 1\n" if path.as_posix().endswith(file) else ""),
    )  # fmt: skip
    sources._hash.cache_clear()
    sources._read.cache_clear()
    after = hash_of_sources(elements_of)
    sources._hash.cache_clear()
    sources._read.cache_clear()
    assert (before != after) == counts


# --- failures -----------------------------------------------------------------------------------


def test_failures_become_rows_and_hurt_nobody(tmp_path, capsys):
    out = tmp_path / "out"
    cases = [
        power(0.25, cost=9.0),
        Case("diverged", diverges, {"h": 0.5}, 5.0),
        Case("mistake", breaks, {}, 4.0),
        Case("killed", dies, {}, 3.0),
        Case("no list", forgets_the_list, {}, 2.5),
        Case("cannot travel", power_law, {"h": 0.5, "law": Unpicklable()}, 2.4),
        power(0.125, cost=2.0),
    ]
    assert main(study_of(cases, tmp_path, text=SHORT), ["--out", str(out), "--jobs", "2"]) == 0
    failures = pd.read_csv(out / "failures.csv").set_index("key")
    assert failures["failure"].to_dict() == {
        "diverged": "Diverged", "mistake": "ZeroDivisionError", "killed": "WorkerDied",
        "no list": "InputError", "cannot travel": "TypeError",
    }  # fmt: skip
    assert "step 12, point 3" in failures.loc["diverged", "message"]
    assert "in breaks" in failures.loc["mistake", "message"]
    assert os.sep not in failures.loc["mistake", "message"]
    assert "list of rows" in failures.loc["no list", "message"]
    assert sorted(set(pd.read_csv(out / "table.csv")["h"])) == [0.125, 0.25]
    assert "failed: killed" in capsys.readouterr().out
    # A solution that diverged is a result; anything else is tried again.
    kept = study._kept(cases, out / "partial")
    assert sorted(kept) == ["diverged", "h = 0.125", "h = 0.25"]


class Unpicklable:
    """An option object with a value, which no pickle can carry."""

    def __repr__(self):
        return "Unpicklable()"

    def __reduce__(self):
        raise TypeError("it stays here")


def test_where_nothing_finished_no_report_is_made(tmp_path, capsys):
    fake, out = study_of([Case("mistake", breaks)], tmp_path), tmp_path / "out"
    assert main(fake, ["--out", str(out), "--jobs", "1"]) == 1
    assert "failed: mistake: ZeroDivisionError" in capsys.readouterr().err
    assert not (out / "report.pdf").exists()


def test_workers_have_one_thread_and_leave_the_environment(monkeypatch):
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    [(_, outcome)] = Processes(1).run([Case("s", sleeps, {"seconds": 0.0})])
    assert outcome.rows[0]["threads"] == "1"
    assert "NUMBA_NUM_THREADS" not in os.environ


def test_ctrl_c_keeps_what_is_done(tmp_path):
    """The whole process of a person's own script, which lacks the usual guard."""
    script = tmp_path / "own.py"
    script.write_text(
        textwrap.dedent("""
            import time
            from pathlib import Path
            from studies.engine.study import Case, Study, run_study
            from tests.unit.studies.fake_study import Law, power_law, tables

            def waits(*, seconds):
                time.sleep(seconds)
                return []

            def cases(options):
                short = {"h": 0.25, "law": Law(2.0)}
                return [
                    Case("short", power_law, short, 2.0), Case("long", waits, {"seconds": 60.0})
                ]

            def warm_up(options):
                return []

            run_study(Study(name="own", cases=cases, tables=tables, text=Path("own.md"),
                            warm_up=warm_up))
        """)
    )
    out = tmp_path / "out"
    environment = os.environ | {"PYTHONPATH": str(ROOT), "SPHSOLID_CACHE": str(tmp_path / "k")}
    process = subprocess.Popen(
        [sys.executable, str(script), "--out", str(out), "--jobs", "1"],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
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
    assert process.returncode == 130, errors
    assert "--resume" in errors
    assert [path.name[:5] for path in (out / "partial").iterdir()] == ["short"]


# --- order of work and time left ----------------------------------------------------------------


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
    assert estimate.text() == "done"


def test_the_start_of_a_worker_is_not_taken_for_its_pace():
    """Two workers, five seconds to start each, then one second a unit of cost."""
    work = [power(1.0 / n, cost=1.0) for n in range(1, 13)]
    estimate = Estimate(work, jobs=2)
    for case in work[:2]:
        estimate.started(case)
    estimate.finished(work[0], Outcome(work[0].key, 6.0))
    estimate.started(work[2])
    # All that is known is a bound: 11 units left at six seconds on two workers.
    assert estimate.text() == "at most 33.0 s left"
    estimate.finished(work[1], Outcome(work[1].key, 6.0))
    estimate.finished(work[2], Outcome(work[2].key, 1.0))
    assert estimate.seconds_left() == pytest.approx(4.5)
    assert estimate.text() == "4.5 s left"


def test_a_long_table_is_compressed_and_read_back_the_same(tmp_path):
    long = pd.DataFrame({"x": np.linspace(0.0, 1.0, 30_000), "name": "a"})
    path = write_table(long, tmp_path, "history")
    assert path.name == "history.csv.xz"
    first = path.read_bytes()
    assert len(first) < 150_000
    write_table(long, tmp_path, "history")
    assert path.read_bytes() == first
    # Drawn, not judged to the last digit: those of a float of 32 bits.
    pd.testing.assert_frame_equal(read_table(tmp_path, "history"), long, rtol=1e-6)
    # The other form of an earlier run does not stay beside it.
    assert write_table(long[:10], tmp_path, "history").name == "history.csv"
    assert [each.name for each in tmp_path.iterdir()] == ["history.csv"]
    with pytest.raises(InputError, match=r"no table spectrum\.csv"):
        read_table(tmp_path, "spectrum")
    path.write_bytes(first)
    with pytest.raises(InputError, match=r"history\.csv and history\.csv\.xz, one of them"):
        read_table(tmp_path, "history")


def test_no_report_has_a_table_in_two_forms():
    packed = sorted((ROOT / "reports").glob("*/*.csv.xz"))
    assert packed
    assert [each for each in packed if each.with_suffix("").exists()] == []


def test_tables_of_an_earlier_form_are_refused_in_one_line(tmp_path, capsys):
    fake = study_of([power(h) for h in (0.5, 0.25)], tmp_path, text=SHORT)
    out = ["--out", str(tmp_path / "out")]
    assert main(fake, [*out, "--jobs", "1"]) == 0
    run = tmp_path / "out" / "run.json"
    known = json.loads(run.read_text())
    # Made by other sources of the study, whose tables lack what the text asks for.
    (tmp_path / "out" / "orders.csv").write_text("slope\n1.0\n")
    run.write_text(json.dumps(known | {"study_hash": "another"}))
    capsys.readouterr()
    assert main(fake, [*out, "--report-only"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert "without --report-only" in said or "order_last" in said
    # Made before there was an engine.
    run.write_text(json.dumps({name: known[name] for name in known if name != "study_hash"}))
    assert main(fake, [*out, "--report-only"]) == 2
    assert "earlier form of the study" in capsys.readouterr().err
