"""The results table of README.md, made from the report of ``studies.convergence``.

``python -m studies.readme_table`` rewrites the lines between the two markers; a test fails when
README says something else than the report.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pandas as pd

from sphsolid.errors import InputError, require
from studies.convergence import headline
from studies.engine.case import write_atomically
from studies.engine.sources import ROOT
from studies.methods import PACKAGE

BEGIN, END = "<!-- results: begin -->", "<!-- results: end -->"
_FORMATS = [".2f"] * 2 + [".1e"] * 4


def results_table(summary: pd.DataFrame) -> str:
    """Markdown: worst slopes over all scenes and families, errors of two scenes at the finest h."""
    finest = summary[summary["nu"] == 0.3]["h_finest"].min()
    side = f"{1.0 / finest + 1.0:.0f}³"
    lines = [
        f"| method | slope momentum | slope stress | momentum, linear, {side} | stress, linear, "
        f"{side} | momentum, large strain, {side} | stress, large strain, {side} |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, *numbers in headline(summary).itertuples(index=False):
        label = f"**{name}**" if name == PACKAGE.name else name
        cells = [f"{number:{form}}" for number, form in zip(numbers, _FORMATS, strict=True)]
        lines.append("| " + " | ".join([label, *cells]) + " |")
    return "\n".join(lines)


def with_table(readme: str, table: str) -> str:
    """README text with ``table`` between the markers; ``InputError`` when they are missing."""
    pattern = re.compile(f"{re.escape(BEGIN)}.*{re.escape(END)}", re.DOTALL)
    require(
        len(pattern.findall(readme)) == 1, f"README.md must hold one block {BEGIN} ... {END}"
    )
    return pattern.sub(lambda _: f"{BEGIN}\n{table}\n{END}", readme)


def main(root: Path = ROOT) -> int:
    """Rewrite README.md in place."""
    try:
        path = root / "reports" / "convergence" / "summary.csv"
        require(path.exists(), f"{path.name} is missing; run python -m studies.convergence first")
        readme = root / "README.md"
        summary = pd.read_csv(path, keep_default_na=False, na_values=["", "nan"])
        text = with_table(readme.read_text(encoding="utf-8"), results_table(summary))
        write_atomically(readme, text)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
