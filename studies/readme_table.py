"""What README.md and the pages of ``docs/`` quote of reports.

``python -m studies.readme_table`` rewrites what stands between markers in README, and every page
that has a template in ``studies/pages``.  In README's table each row is a method and each column
what a study found of it; a dash where its report lacks the method.  A test fails where they say
something else than the reports.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from sphsolid.errors import InputError, require
from studies import convergence
from studies.engine.case import write_atomically
from studies.engine.document import format_cell
from studies.engine.sources import ROOT
from studies.measures.swinging_cube import SCENES
from studies.measures.tables import select
from studies.methods import B_BAR, DISPLACEMENT, PACKAGE, SUPG, TAYLOR_HOOD
from studies.pages import filled, markdown_table, pages
from studies.pages.reports import Reports
from studies.pareto.iso_error import COARSEST, NEVER
from studies.pareto.methods import MIXED, PF, papers
from studies.pareto.problems import CUBE, FAIR
from studies.stability.hard_cases import PAPER_COLUMN
from studies.stability.judgement import ABSENT, SOUND

#: Blocks of README that are made, each between ``<!-- NAME: begin -->`` and ``<!-- NAME: end -->``.
RESULTS, FAILS = "results", "fails"
#: Hard cases that README lists; the report has all.
MOST_FAILS = 4
NU, ASKED = convergence.NU, 0.01


@dataclass(frozen=True)
class Line:
    """A row: what it is called, and the method's name in each study; none where it is not run."""

    label: str
    convergence: str = ""
    pareto: str = ""
    stability: str = ""


LINES = (
    Line(f"**{PACKAGE.name}**", PACKAGE.name, PACKAGE.name, PACKAGE.name),
    Line(SUPG.name, SUPG.name, MIXED[PF].name, SUPG.name),
    Line("paper", convergence.PAPER.name, papers(NU)[0].name, PAPER_COLUMN.name),
    Line("paper, operator as printed", convergence.LITERAL.name),
    Line(
        "displacement SPH (slopes: TVD-RK2)",
        convergence.CLASSICAL.name, DISPLACEMENT.name, DISPLACEMENT.name,
    ),
    Line(B_BAR.name, B_BAR.name, B_BAR.name, B_BAR.name),
    Line(TAYLOR_HOOD.name, "", TAYLOR_HOOD.name),
)  # fmt: skip


def results_table(reports: Reports) -> str:
    """Markdown: one row a method; raises ``InputError`` where a report is missing."""
    summary = with_present_names(_needed(reports, "convergence", "summary"))
    costs, hard = _needed(reports, "pareto", "iso_error"), _needed(reports, "stability", "table")
    side = f"{1.0 / summary[summary['nu'] == NU]['h_finest'].min() + 1.0:.0f}³"
    rows = []
    for line in LINES:
        found = slopes(summary, line.convergence)
        counts = judged(hard, line.stability)
        rows.append(
            {
                "method": line.label,
                "slope momentum": format_cell(found["slope_p"], ".2f"),
                "slope stress": format_cell(found["slope_P"], ".2f"),
                f"momentum error, {side}": format_cell(found["error_p"], ".1e"),
                f"stress error, {side}": format_cell(found["error_P"], ".1e"),
                "cost at 1 %": cost(costs, line.pareto),
                "hard cases sound": _of(counts["sound"], counts["cases"]),
                "folded": _of(counts["folded"], counts["cases"]),
            }
        )
    return markdown_table(pd.DataFrame(rows))


def _needed(reports: Reports, study: str, name: str) -> pd.DataFrame:
    found = reports[study].table(name)
    if found is None:
        raise InputError(f"reports/{study} has no table {name}: run python -m studies.{study}")
    return found


def with_present_names(summary: pd.DataFrame) -> pd.DataFrame:
    """A report without the registered SUPG was made when that was the package default."""
    if SUPG.name in set(summary["method"]):
        return summary
    return summary.replace({"method": {PACKAGE.name: SUPG.name}})


def slopes(summary: pd.DataFrame, method: str) -> dict[str, float]:
    """Worst slopes over scenes and families; largest component errors at large strain.

    nan of a method that was not run; raises ``InputError`` where some of its runs are missing.
    """
    runs = select(summary[summary["scene"].isin(SCENES)], nu=NU, method=method)
    found = {f"slope_{field}": runs[f"slope_{field}_last"].min() for field in "pP"}
    large = select(runs, scene="manufactured", family="A+B+C=0")
    found |= {f"error_{field}": large[f"error_{field}_finest"].max() for field in "pP"}
    require(
        len(runs) == 0 or not any(math.isnan(number) for number in found.values()),
        f"summary.csv has not all of {method}: run python -m studies.convergence",
    )
    return found


def cost(costs: pd.DataFrame, method: str) -> str:
    """CPU time at 1 % error of the stress of the cube over that of B-bar elements."""
    wanted = {"nu": NU, "measure": "stress", "asked": ASKED}
    scene = FAIR if FAIR in set(costs["scene"]) else CUBE
    rows = select(costs, scene=scene, **wanted).set_index("method")
    if method not in rows.index or B_BAR.name not in rows.index:
        return "–"
    own, other = rows.loc[method], rows.loc[B_BAR.name]
    if own["how"] == NEVER:
        return "not reached"
    ratio = own["cpu_s_per_s"] / other["cpu_s_per_s"]
    bound = "at most " if own["how"] == COARSEST and method != B_BAR.name else ""
    return f"{bound}{ratio:.2g}" if math.isfinite(ratio) else "–"


def judged(hard: pd.DataFrame, method: str) -> dict[str, int]:
    """``cases`` that a method was put to, how many of them are ``sound`` and ``folded``."""
    runs = select(hard, method=method)
    runs = runs[runs["verdict"] != ABSENT]
    # Where a report has no column for it, the reason of the verdict says it.
    told = runs["why"].fillna("").str.contains("folded")
    folded = told | runs["folded"].astype(bool) if "folded" in runs else told
    return {
        "cases": len(runs), "sound": int((runs["verdict"] == SOUND).sum()),
        "folded": int(folded.sum()),
    }  # fmt: skip


def _of(number: int, of: int) -> str:
    return f"{number} of {of}" if of else "–"


def failures(reports: Reports) -> str:
    """Markdown: the hard cases in which the package default is not sound, as their report says."""
    hard = _needed(reports, "stability", "table")
    runs = select(hard, method=PACKAGE.name)
    runs = runs[runs["verdict"] != ABSENT]
    if len(runs) == 0:
        return "- The reports are older than the present default: no hard case was run with it."
    bad = runs[runs["verdict"] != SOUND]
    lines = [f"- It is sound in {len(runs) - len(bad)} of {len(runs)} hard cases."]
    lines += [f"- {row.case}: {row.why}." for row in bad.head(MOST_FAILS).itertuples()]
    more = len(bad) - MOST_FAILS
    return "\n".join(lines + ([f"- and {more} more."] if more > 0 else []))


def with_block(readme: str, name: str, text: str) -> str:
    """README with ``text`` between the markers of ``name``; ``InputError`` where they are not."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    pattern = re.compile(f"{re.escape(begin)}.*{re.escape(end)}", re.DOTALL)
    require(
        len(pattern.findall(readme)) == 1, f"README.md must hold one block {begin} ... {end}"
    )
    return pattern.sub(lambda _: f"{begin}\n{text}\n{end}", readme)


def made(root: Path = ROOT) -> dict[Path, str]:
    """Every file that this command writes, with its text."""
    readme = root / "README.md"
    reports, text = Reports(root), readme.read_text(encoding="utf-8")
    text = with_block(text, RESULTS, results_table(reports))
    text = with_block(text, FAILS, failures(reports))
    return {readme: text} | {
        root / "docs" / name: filled(template, root) for name, template in pages().items()
    }


def main(argv: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """Rewrite them in place."""
    parser = argparse.ArgumentParser(prog="python -m studies.readme_table", description=__doc__)
    parser.parse_args(argv)
    try:
        texts: dict[Path, Any] = made(root)
        for path, text in texts.items():
            write_atomically(path, text)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
