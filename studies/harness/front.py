"""The one command line that every study shares.

A study is a :class:`Study`: which cases there are, which tables their rows make, and how the
report is made *from the tables*.  Everything else (workers, progress, resuming, failures, files,
provenance) is here, so a study file holds nothing but its subject::

    STUDY = Study(name="convergence", cases=..., tables=..., report=...)

    if __name__ == "__main__":
        sys.exit(main(STUDY))
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path

import pandas as pd

from sphsolid.errors import InputError, require
from sphsolid.paths import path_of
from studies.harness.cases import Case, Outcome, Row, load, partial_path, write_atomically
from studies.harness.pool import longest_first, run_cases
from studies.harness.progress import Reporter, duration, reporter
from studies.harness.provenance import cores, describe_run
from studies.harness.results import Results, Tables, read_results, write_csv
from studies.harness.warm_up import warm_up
from studies.report.document import Document
from studies.report.document_pdf import write_pdf
from studies.report.plotting import style

__all__ = ["Case", "Results", "Study", "main", "parse", "read_results"]


@dataclass(frozen=True)
class Study:
    """A study, as the front needs it.

    ``cases(options)`` lists the runs, ``options`` being the parsed command line (``quick`` and
    whatever ``arguments(parser)`` added).  ``tables(rows)`` turns the rows of all finished cases
    into tables; ``table`` among them is the main one, and the order of rows is that of the
    cases, whatever finished first.  ``report(results)`` draws figures into ``results.out`` and
    returns the document.  ``summary(tables)`` is printed at the end.  ``warm_up(options)`` lists
    tiny cases that compile every kernel the study uses; the cheapest case if left out.
    """

    name: str
    cases: Callable[[argparse.Namespace], Sequence[Case]]
    tables: Callable[[list[Row]], Tables]
    report: Callable[[Results], Document]
    summary: Callable[[Tables], str] = lambda tables: tables["table"].to_string(index=False)
    arguments: Callable[[argparse.ArgumentParser], None] = lambda parser: None
    warm_up: Callable[[argparse.Namespace], Sequence[Case]] | None = None
    description: str = ""


def main(study: Study, argv: Sequence[str] | None = None) -> int:
    """Run a study from its command line; returns the exit status.

    0: done, perhaps with cases that failed (they are in the report); 1: no case finished;
    2: wrong input; 130: interrupted, what had finished is kept for ``--resume``.
    """
    given = sys.argv[1:] if argv is None else list(argv)
    options = parse(study, given)
    try:
        if not options.report_only:
            _run(study, options, given)
        results = read_results(study.name, options.out)
        with style():
            document = study.report(results)
        write_pdf(document, options.out / "report.pdf")
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\ninterrupted; go on with the same command and --resume", file=sys.stderr)
        return 130
    print(study.summary(results.tables))
    print(_closing_lines(results))
    return 0 if len(results.tables["table"]) else 1


def parse(study: Study, given: Sequence[str]) -> argparse.Namespace:
    """The command line of ``study``; wrong options end the process as ``argparse`` does."""
    parser = argparse.ArgumentParser(
        prog=f"python -m studies.{study.name}", description=study.description or None
    )
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help="the short form, about a minute")
    size.add_argument("--full", action="store_true", help="the whole study (default)")
    parser.add_argument(
        "--out",
        type=path_of,
        help=f"folder of the results (default reports/{study.name}, "
        f"or out/{study.name}-quick with --quick)",
    )
    parser.add_argument(
        "--jobs", type=int, default=cores(), help="cases at once (default: cores, %(default)s)"
    )
    parser.add_argument("--threads", type=int, default=1, help="kernel threads of each (default 1)")
    parser.add_argument("--resume", action="store_true", help="keep the cases that are done")
    parser.add_argument(
        "--report-only", action="store_true", help="remake figures and report from the tables"
    )
    study.arguments(parser)
    options = parser.parse_args(given)
    if options.jobs < 1 or options.threads < 1:
        parser.error("--jobs and --threads must be at least 1")
    if options.out is None:
        # A quick look must not replace the results of the whole study.
        options.out = Path("out", f"{study.name}-quick")
        if not options.quick:
            options.out = Path("reports", study.name)
    return options


def _run(study: Study, options: argparse.Namespace, given: Sequence[str]) -> None:
    start = time.perf_counter()
    cases = list(study.cases(options))
    keys = [case.key for case in cases]
    require(len(cases) > 0, f"studies.{study.name}: there are no cases to run")
    require(len(set(keys)) == len(keys), f"studies.{study.name}: case keys repeat")
    folder = options.out / "partial"
    outcomes = _kept(cases, folder) if options.resume else {}
    if not options.resume:
        for stale in folder.glob("*.json"):
            stale.unlink()
    resumed = len(outcomes)
    todo = [case for case in cases if case.key not in outcomes]
    if todo:
        tiny = study.warm_up(options) if study.warm_up else [min(cases, key=lambda c: c.cost)]
        warm_up(tiny, threads=options.threads, say=lambda text: print(text, flush=True))
        show = reporter(todo, options.jobs)
        try:
            if resumed:
                show.say(f"{resumed} of {len(cases)} cases were done before")
            outcomes |= _work(todo, options, folder, show)
        finally:
            show.close()
    _write(study, options, given, [outcomes[key] for key in keys], resumed, start)


def _kept(cases: Sequence[Case], folder: Path) -> dict[str, Outcome]:
    """Outcomes that need no second try: rows, or a solution that was lost."""
    found = {case.key: load(partial_path(folder, case)) for case in cases}
    return {
        key: outcome
        for key, outcome in found.items()
        if outcome is not None and (outcome.lost or not outcome.failed)
    }


def _work(
    todo: Sequence[Case], options: argparse.Namespace, folder: Path, show: Reporter
) -> dict[str, Outcome]:
    ordered = list(todo) if options.quick else longest_first(todo)
    outcomes = {}
    running = run_cases(
        ordered,
        folder=folder,
        jobs=options.jobs,
        threads=options.threads,
        started=show.started,
        tick=show.tick,
    )
    with closing(running):
        for case, outcome in running:
            outcomes[case.key] = outcome
            show.finished(case, outcome)
    return outcomes


def _write(
    study: Study,
    options: argparse.Namespace,
    given: Sequence[str],
    outcomes: Sequence[Outcome],
    resumed: int,
    start: float,
) -> None:
    failed = [outcome for outcome in outcomes if outcome.failed]
    tables = study.tables([row for outcome in outcomes for row in outcome.rows])
    require("table" in tables, f"studies.{study.name}: tables() must return one named 'table'")
    for name, table in tables.items():
        write_csv(table, options.out / f"{name}.csv")
    columns = ["key", "failure", "message", "wall_s"]
    failures = pd.DataFrame([asdict(outcome) for outcome in failed], columns=columns)
    write_csv(failures, options.out / "failures.csv")
    run = describe_run(
        study=study.name,
        argv=given,
        mode="quick" if options.quick else "full",
        jobs=options.jobs,
        threads=options.threads,
        wall_s=time.perf_counter() - start,
        cases=len(outcomes),
        failed=len(failed),
        resumed=resumed,
    ) | {"tables": list(tables)}
    write_atomically(options.out / "run.json", json.dumps(run, indent=2) + "\n")


def _closing_lines(results: Results) -> str:
    run = results.run
    lines = [
        f"{run['cases'] - run['cases_failed']} of {run['cases']} cases finished, "
        f"{duration(run['wall_s'])}; report: {results.out / 'report.pdf'}"
    ]
    for row in results.failures.itertuples():
        lines.append(f"failed: {row.key}: {row.failure}: {row.message}")
    return "\n".join(lines)
