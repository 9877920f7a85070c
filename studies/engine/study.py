"""A study, and the one command line that all of them share.

A study is a file with its cases, tables, claims and figures, and a Markdown file with its words.
Workers, progress, resuming, failures, files and provenance are here::

    STUDY = Study(name="convergence", cases=..., tables=..., claims=..., figures=..., text=...)

    if __name__ == "__main__":
        run_study(STUDY)
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure as Drawing

from sphsolid.errors import InputError, require
from sphsolid.paths import path_of
from sphsolid.record.display import duration
from studies.engine.case import Case, Outcome, Row, load, partial_path, store, write_atomically
from studies.engine.claims import Claim, claims_table
from studies.engine.document import write_pdf
from studies.engine.plotting import for_a_report, save_figure, style
from studies.engine.pool import Processes, Workers, longest_first, warm_up
from studies.engine.progress import Reporter, reporter
from studies.engine.provenance import cores, describe_run
from studies.engine.results import Results, Tables, read_results, write_table
from studies.engine.scheduler import on_cluster
from studies.engine.sources import command_of, hash_of_sources
from studies.engine.text import document

__all__ = ["Case", "Claim", "Results", "Row", "Study", "Tables", "main", "parse", "run_study"]


@dataclass(frozen=True)
class Study:
    """What one study is about.

    ``cases(options)`` lists the runs; ``options`` is the parsed command line (``quick`` and
    whatever ``arguments(parser)`` added).  ``tables(rows)`` turns the rows of all finished cases
    into tables; ``table`` is the main one, and rows are in the order of the cases.
    ``claims(tables)`` judges them.  ``figures`` are functions of the results by name; those in
    ``shown`` are kept as PNG beside the tables, for README and docs.  ``text`` is the Markdown file
    of the report, and ``words(tables)`` are further holes in it.  ``keep(out, tables)`` is called
    at the end of a run and keeps what figures need beside the tables.  ``warm_up(options)`` lists
    tiny cases that compile every kernel of the study; the cheapest case if left out.
    """

    name: str
    cases: Callable[[argparse.Namespace], Sequence[Case]]
    tables: Callable[[list[Row]], Tables]
    text: Path
    claims: Callable[[Tables], Sequence[Claim]] = lambda tables: ()
    figures: Mapping[str, Callable[[Results], Drawing]] = field(default_factory=dict)
    shown: Sequence[str] = ()
    words: Callable[[Tables], Mapping[str, Any]] = lambda tables: {}
    summary: Callable[[Tables], str] | None = None
    arguments: Callable[[argparse.ArgumentParser], None] = lambda parser: None
    keep: Callable[[Path, Tables], None] = lambda out, tables: None
    warm_up: Callable[[argparse.Namespace], Sequence[Case]] | None = None
    description: str = ""

    @property
    def module(self) -> str:
        """Where its cases are listed."""
        return self.cases.__module__

    @property
    def sources(self) -> str:
        """Hash of what its tables are made by."""
        return hash_of_sources(self.cases, self.tables)

    @property
    def command(self) -> str:
        """How it is started."""
        return command_of(self.module)


def run_study(study: Study) -> None:
    """Run a study from its command line and end the process with its status.

    Nothing happens in a worker that imports the script again to find its cases.
    """
    if not getattr(multiprocessing.current_process(), "_inheriting", False):
        sys.exit(main(study))


def main(study: Study, argv: Sequence[str] | None = None) -> int:
    """Run a study from its command line; returns the exit status.

    0: done, perhaps with cases that failed (they are in the report); 1: no row, and so no report;
    2: wrong input; 130: interrupted, what had finished is kept for ``--resume``.
    """
    given = sys.argv[1:] if argv is None else list(argv)
    options = parse(study, given)
    try:
        if not options.report_only:
            _run(study, options, given)
        results = read_results(study.command, options.out)
        if len(results.tables["table"]) == 0:
            print(_closing_lines(results), file=sys.stderr)
            return 1
        claims = _judged(study, results)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\ninterrupted; go on with the same command and --resume", file=sys.stderr)
        return 130
    print(_summary(study, results.tables, claims))
    print(_closing_lines(results))
    print(f"report: {results.out / 'report.pdf'}")
    return 0


def parse(study: Study, given: Sequence[str]) -> argparse.Namespace:
    """The command line of ``study``; wrong options end the process as ``argparse`` does."""
    parser = argparse.ArgumentParser(
        prog=study.command, description=study.description or None
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
        "--jobs", type=int, help=f"cases at once (default: cores, {cores()}, or the whole cluster)"
    )
    parser.add_argument("--threads", type=int, default=1, help="kernel threads of each (default 1)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="run on this Dask cluster")
    parser.add_argument("--resume", action="store_true", help="keep the cases that are done")
    parser.add_argument(
        "--report-only", action="store_true", help="remake figures and report from the tables"
    )
    study.arguments(parser)
    options = parser.parse_args(given)
    if (options.jobs is not None and options.jobs < 1) or options.threads < 1:
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
    require(len(cases) > 0, f"study {study.name}: there are no cases to run")
    require(len(set(keys)) == len(keys), f"study {study.name}: case keys repeat")
    folder = options.out / "partial"
    outcomes = _kept(cases, folder) if options.resume else {}
    if not options.resume:
        for stale in folder.glob("*.json"):
            stale.unlink()
    resumed = len(outcomes)
    todo = [case for case in cases if case.key not in outcomes]
    jobs = options.jobs or cores()
    if todo:
        with _workers(options) as workers:
            jobs = workers.at_once
            if options.scheduler is None:
                tiny = study.warm_up(options) if study.warm_up else [min(cases, key=_cost)]
                warm_up(tiny, threads=options.threads, say=lambda text: print(text, flush=True))
            show = reporter(todo, jobs)
            try:
                if resumed:
                    show.say(f"{resumed} of {len(cases)} cases were done before")
                outcomes |= _work(todo, workers, options.quick, folder, show)
            finally:
                show.close()
    ordered = [outcomes[key] for key in keys]
    tables = _write(study, options.out, ordered)
    run = describe_run(
        study=study.name,
        command=study.command,
        sources=study.sources,
        argv=given,
        mode="quick" if options.quick else "full",
        jobs=jobs,
        threads=options.threads,
        cluster=options.scheduler is not None,
        wall_s=time.perf_counter() - start,
        cases=len(cases),
        failed=sum(outcome.failed for outcome in ordered),
        resumed=resumed,
        sampled=sum(outcome.sampled for outcome in ordered),
        older_times=sum(outcome.older_times for outcome in ordered),
    ) | {"tables": tables}
    write_atomically(options.out / "run.json", json.dumps(run, indent=2) + "\n")


def _cost(case: Case) -> float:
    return case.cost


@contextmanager
def _workers(options: argparse.Namespace) -> Iterator[Workers]:
    if options.scheduler is None:
        yield Processes(options.jobs or cores(), options.threads)
    else:
        with on_cluster(
            options.scheduler, jobs=options.jobs, threads=options.threads
        ) as workers:
            yield workers


def _kept(cases: Sequence[Case], folder: Path) -> dict[str, Outcome]:
    """Outcomes that need no second try: rows, or a solution that diverged."""
    found = {case.key: load(partial_path(folder, case)) for case in cases}
    return {
        key: outcome
        for key, outcome in found.items()
        if outcome is not None and (outcome.diverged or not outcome.failed)
    }


def _work(
    todo: Sequence[Case], workers: Workers, quick: bool, folder: Path, show: Reporter
) -> dict[str, Outcome]:
    ordered = list(todo) if quick else longest_first(todo)
    outcomes = {}
    with closing(workers.run(ordered, show)) as running:
        for case, outcome in running:
            store(partial_path(folder, case), outcome)
            outcomes[case.key] = outcome
            show.finished(case, outcome)
    return outcomes


def _write(study: Study, out: Path, outcomes: Sequence[Outcome]) -> list[str]:
    """The tables as files; their names."""
    tables = study.tables([row for outcome in outcomes for row in outcome.rows])
    require("table" in tables, f"study {study.name}: tables() must return one named 'table'")
    for name, table in tables.items():
        write_table(table, out, name)
    columns = ["key", "failure", "message", "wall_s"]
    failed = [asdict(outcome) for outcome in outcomes if outcome.failed]
    write_table(pd.DataFrame(failed, columns=columns), out, "failures")
    study.keep(out, tables)
    return list(tables)


def _judged(study: Study, results: Results) -> list[Claim]:
    """The claims, once they and the report are made; a column that older tables lack is said."""
    try:
        claims = list(study.claims(results.tables))
        _report(study, results, claims)
    except (LookupError, AttributeError) as error:
        if results.run["study_hash"] == study.sources:
            raise
        raise InputError(
            f"the tables in {results.out} were made by other sources of the study and lack "
            f"{error}; run `{study.command}` without --report-only"
        ) from error
    return claims


def _report(study: Study, results: Results, claims: Sequence[Claim]) -> None:
    """``claims.csv``, the shown PNGs and ``report.pdf``, from the tables alone."""
    if claims:
        write_table(claims_table(claims, worst_first=False), results.out, "claims")
    made = results.out / "figures"

    def draw(name: str) -> Path:
        require(
            name in study.figures,
            f"{study.text.name}: no figure {name!r}; there are {', '.join(study.figures)}",
        )
        drawing = study.figures[name](results)
        if name in study.shown:
            save_figure(drawing, results.out / f"{name}.png")
        return for_a_report(drawing, made / name)

    with style():
        report = document(
            study.text, results, claims=claims, words=study.words(results.tables), draw=draw
        )
        write_pdf(report, results.out / "report.pdf")


def _summary(study: Study, tables: Tables, claims: Sequence[Claim]) -> str:
    if study.summary is not None:
        return study.summary(tables)
    if claims:
        shown = claims_table(claims)[["claim", "measured", "asked", "verdict"]]
        return str(shown.to_string(index=False, max_colwidth=60))
    return str(tables["table"].to_string(index=False))


def _closing_lines(results: Results) -> str:
    run = results.run
    lines = [
        f"{run['cases'] - run['cases_failed']} of {run['cases']} cases finished, "
        f"{duration(run['wall_s'])}"
    ]
    for row in results.failures.itertuples():
        lines.append(f"failed: {row.key}: {row.failure}: {row.message}")
    return "\n".join(lines)
