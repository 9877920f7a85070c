"""Does the code still give a report's rows?  A sample of its cases is run again and compared.

``python -m studies.engine.carry stability --cases 30`` takes cases over the whole list of the
study, runs them, and compares every value with what is kept in ``reports/stability/partial``, but
for times.  Where all agree, ``run.json`` says that the report holds for the sources as they are,
and by how many cases.  A change of the solvers that alters no row, a clearer message or a refusal,
so needs no run of hours.  One value that differs leaves the report as it is: older than the code.
A sample is evidence, no proof, and a small one is little evidence.  ``--within 1e-4`` lets smaller
differences pass than the report's figures show, and the stamp says so.  Where nothing is kept, as
in a clone, the rows are looked for in the tables of the report.

With ``--sequences`` one case of every sequence is run; its cases differ in the spacing alone.
Where it agrees, the sequence is kept for ``--resume``; the others run again there, or at once with
``--keep-times``.  These get the times that were measured before.  So ratios of times stay those of
one session, which is right where a change made no step dearer.  ``run.json`` counts both.

With ``--again PATTERN`` the change is known to touch the cases whose key matches: they run again,
with ``--resume`` or at once with ``--keep-times``.  Of all others a sample of ``--cases`` is run,
and where all of it agrees, the others are kept.
"""

from __future__ import annotations

import argparse
import datetime
import importlib
import json
import math
import re
import statistics
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sphsolid.errors import InputError, require
from studies.engine.case import (
    Case,
    Outcome,
    Row,
    execute,
    load,
    partial_path,
    store,
    write_atomically,
)
from studies.engine.provenance import commit
from studies.engine.results import read_results
from studies.engine.study import Study, parse
from studies.engine.tabled import compared

#: Values that agree to this share are the same: tables have ten digits.
SAME = 1.0e-9
#: Columns that are of this machine: times, what it can do, and bytes held, among them scratch of
#: each thread.
_TIMES = re.compile(
    r"(^|_)(wall|cpu|seconds|ns)(_|$)|step_s$|evaluation_s$|set_?up_s$|_ms$|^window_steps$|^repeats$|^(step|terms)_ratio$|^bytes$|^bandwidth$|^flops$"
)
#: Cases that took longer are left out [s].
LONGEST = 60.0


def kept_outcomes(folder: Path) -> dict[str, Outcome]:
    """What is kept of earlier runs, by the key of the case; the newest counts."""
    found: dict[str, Outcome] = {}
    for path in sorted(folder.glob("*.json"), key=lambda each: each.stat().st_mtime):
        outcome = load(path)
        if outcome is not None:
            found[outcome.key] = outcome
    return found


def sample(
    cases: Sequence[Case], kept: dict[str, Outcome], count: int, longest: float = LONGEST
) -> list[tuple[Case, Outcome]]:
    """``count`` of the cases that are kept and short, evenly over the list."""
    known = []
    for case in cases:
        outcome = kept.get(case.key)
        if outcome is not None and not outcome.failed and outcome.wall_s <= longest:
            known.append((case, outcome))
    step = max(1.0, len(known) / count)
    return [known[int(k * step)] for k in range(min(count, len(known)))]


def sequence_of(case: Case) -> str:
    """The key without the spacing, or the number at its end: what it is a refinement of."""
    return re.sub(r"\s*\b1/\d+\b|, \d+$", "", case.key)


def keep_sequences(
    study: Study, *, longest: float = LONGEST, keep_times: bool = False
) -> tuple[int, list[str]]:
    """Keep every sequence of which the finest case of at most ``longest`` s gives the same rows.

    Returns how many cases are kept, and in words what differs.  A sequence that differs runs again
    where ``keep_times``.  Else it is left for ``--resume``, as one without a short case is.
    """
    options = parse(study, [])
    folder = options.out / "partial"
    kept = kept_outcomes(folder)
    sequences: dict[str, list[Case]] = {}
    for case in study.cases(options):
        if case.key in kept and not partial_path(folder, case).exists():
            sequences.setdefault(sequence_of(case), []).append(case)
    count, differ = 0, []
    for name, cases in sequences.items():
        short = [each for each in cases if 0.0 < kept[each.key].wall_s <= longest]
        if not short:
            continue
        chosen = max(short, key=lambda each: kept[each.key].wall_s)
        before, now = kept[chosen.key], execute(chosen)
        words = list(differences(before.rows, now.rows))
        if (before.failed, before.message) != (now.failed, now.message):
            words.append(now.message or "ends now")
        print(f"{'differs' if words else 'same':8} {name}: {len(cases)} cases", flush=True)
        differ += [f"{chosen.key}: {each}" for each in words]
        for each in cases:
            old = kept[each.key]
            if not words:
                store(partial_path(folder, each), replace(old, sampled=each is not chosen))
                count += 1
            elif keep_times:
                again = now if each is chosen else execute(each)
                rows = with_times_of(old.rows, again.rows)
                store(partial_path(folder, each), replace(again, rows=rows, older_times=True))
    return count, differ


def keep_others(
    study: Study, *, again: str, cases: int, longest: float = LONGEST, keep_times: bool = False,
    within: float = SAME,
) -> tuple[int, list[str]]:  # fmt: skip
    """Keep all cases whose key ``again`` does not match, where a sample of ``cases`` agrees.

    Values that differ by a share of at most ``within`` agree.  Returns how many cases are kept, and
    in words what differs.  Those that match run at once where ``keep_times``, else they are left
    for ``--resume``.
    """
    options = parse(study, [])
    folder = options.out / "partial"
    kept = kept_outcomes(folder)
    known = [
        case for case in study.cases(options)
        if case.key in kept and not partial_path(folder, case).exists()
    ]  # fmt: skip
    others = [case for case in known if not re.search(again, case.key)]
    now, differ = {}, []
    for case, before in sample(others, kept, cases, longest):
        outcome = now[case.key] = execute(case)
        words = list(differences(before.rows, outcome.rows, within))
        words = [outcome.message] if outcome.failed else words
        print(f"{'differs' if words else 'same':8} {case.key}", flush=True)
        differ += [f"{case.key}: {each}" for each in words]
    if not differ:
        for case in others:
            old = kept[case.key]
            store(partial_path(folder, case), replace(old, sampled=case.key not in now))
    for case in known:
        if keep_times and re.search(again, case.key):
            outcome = execute(case)
            rows = with_times_of(kept[case.key].rows, outcome.rows)
            store(partial_path(folder, case), replace(outcome, rows=rows, older_times=True))
    return 0 if differ else len(others), differ


def with_times_of(before: Sequence[Row], now: Sequence[Row]) -> list[Row]:
    """The rows ``now`` with the times of ``before``; as they are where their number differs."""
    if len(before) != len(now):
        return list(now)
    return [
        new | {name: old[name] for name in new if name in old and _TIMES.search(name)}
        for old, new in zip(before, now, strict=True)
    ]


def differences(
    before: Sequence[Row], now: Sequence[Row], within: float = SAME
) -> Iterator[str]:
    """Where rows differ by more than the share ``within``, in words; times are not compared."""
    if len(before) != len(now):
        yield f"{len(now)} rows, {len(before)} before"
        return
    for k, (old, new) in enumerate(zip(before, now, strict=True)):
        for name in sorted(old.keys() | new.keys()):
            if not _TIMES.search(name) and not _same(old.get(name), new.get(name), within):
                yield f"row {k + 1}, {name}: {new.get(name)!r}, before {old.get(name)!r}"


def _same(a: Any, b: Any, within: float) -> bool:
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(_same(*each, within) for each in zip(a, b, strict=True))
    if isinstance(a, float | int) and isinstance(b, float | int):
        both_nan = math.isnan(a) and math.isnan(b)
        return both_nan or math.isclose(a, b, rel_tol=within, abs_tol=1.0e-12)
    return bool(a == b)


def carry(
    study: Study, *, cases: int, longest: float = LONGEST, within: float = SAME
) -> list[str]:
    """Run a sample of a full report's cases; stamp the report, or say what differs.

    ``within``: relative difference of values that are the same; the stamp says it.

    Raises ``InputError`` where there is nothing of the report to compare with.
    """
    options = parse(study, [])
    kept = kept_outcomes(options.out / "partial")
    chosen = sample(study.cases(options), kept, cases, longest)
    count, differ = len(chosen), list[str]()
    for case, before in chosen:
        now = execute(case)
        words = [now.message] if now.failed else list(differences(before.rows, now.rows, within))
        print(f"{'differs' if words else 'same':8} {case.key}", flush=True)
        differ += [f"{case.key}: {each}" for each in words]
    if not chosen:
        count, differ = _looked_up(study, cases, longest, within)
        require(count > 0, f"{options.out}: no case that was run gives a row of its tables")
    if not differ:
        path = options.out / "run.json"
        run = json.loads(path.read_text(encoding="utf-8"))
        run["study_hash"] = study.sources
        run["carried"] = {
            "cases": count,
            "within": within,
            "commit": commit(),
            "date_utc": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M:%S"),
        }
        write_atomically(path, json.dumps(run, indent=2) + "\n")
    return differ


def _looked_up(
    study: Study, count: int, longest: float, within: float
) -> tuple[int, list[str]]:
    """Run ``count`` cases, evenly over the list, and look for their rows in the report's tables.

    Of a case only the cost is known, in a unit of its study: one that would take more than
    ``longest`` s, by the median of the cases so far, is left out.  Returns how many could be
    compared.
    """
    options = parse(study, [])
    results = read_results(study.command, options.out)
    listed = list(study.cases(options))
    chosen = listed[:: max(1, len(listed) // count)]
    done, differ, seconds = 0, list[str](), list[float]()
    for case in sorted(chosen, key=lambda each: each.cost):
        # The first ones compile: what they took says little.
        if len(seconds) > count // 3 and statistics.median(seconds) * case.cost > longest:
            break
        now = execute(case)
        seconds.append(now.wall_s / case.cost)
        known, words = compared(now.rows, results.tables, _TIMES.search, within)
        if now.failed or not known:
            print(f"{'other':8} {case.key}: {now.message or 'no row of a table'}", flush=True)
            continue
        done += 1
        print(f"{'differs' if words else 'same':8} {case.key}", flush=True)
        differ += [f"{case.key}: {each}" for each in words]
    return done, differ


def main(argv: Sequence[str] | None = None) -> int:
    """The command line: 0 where all rows are the same, 1 where not, 2 for wrong input."""
    parser = argparse.ArgumentParser(prog="python -m studies.engine.carry", description=__doc__)
    parser.add_argument("study", nargs="+")
    parser.add_argument("--cases", type=int, default=30, help="how many (default %(default)s)")
    parser.add_argument("--sequences", action="store_true", help="one case of every sequence")
    parser.add_argument("--again", metavar="PATTERN", help="cases that run again, not a sample")
    parser.add_argument("--keep-times", action="store_true", help="run those that differ at once")
    parser.add_argument("--longest", type=float, default=LONGEST, help="seconds of a case at most")
    parser.add_argument("--within", type=float, default=SAME, help="share that is no difference")
    given = parser.parse_args(argv)
    code = 0
    for name in given.study:
        try:
            require(given.cases >= 1, f"--cases {given.cases} must be 1 or more")
            study = importlib.import_module(f"studies.{name}").STUDY
            if given.again is not None:
                count, differ = keep_others(
                    study, again=given.again, cases=given.cases, longest=given.longest,
                    keep_times=given.keep_times, within=given.within,
                )  # fmt: skip
                print(f"{name}: {count} cases are kept; the rest runs with --resume")
            elif given.sequences:
                count, differ = keep_sequences(
                    study, longest=given.longest, keep_times=given.keep_times
                )
                print(f"{name}: {count} cases are kept; the rest runs with --resume")
            else:
                differ = carry(
                    study, cases=given.cases, longest=given.longest, within=given.within
                )
        except InputError as wrong:
            print(f"error: {name}: {wrong}", file=sys.stderr)
            return 2
        for each in differ[:10]:
            print(each)
        print(f"{name}: " + (f"{len(differ)} values differ" if differ else "all the same"))
        code = max(code, 1 if differ else 0)
    return code


if __name__ == "__main__":
    sys.exit(main())
