"""The results table of README.md, made from the reports and put in its place.

``python -m studies.readme_table`` rewrites the lines between the two markers; a test fails when
README says something else than the reports.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pandas as pd

from sphsolid.errors import InputError, require
from studies.engine.case import ROOT, write_atomically

BEGIN, END = "<!-- results: begin -->", "<!-- results: end -->"
_ROWS = [
    ("SUPG-SPH {p,F} H1, equations as printed", "SUPG-SPH", "Literal"),
    ("**SUPG-SPH {p,F} H1, consistent (default)**", "SUPG-SPH", "Consistent"),
    ("SUPG-SPH {p,F} H1, consistent in the force only", "SUPG-SPH", "Consistent(force)"),
    ("displacement SPH, equations as printed", "displacement SPH", "Literal"),
    ("displacement SPH, consistent", "displacement SPH", "Consistent"),
    ("B-bar FEM", "B-bar FEM", "-"),
]


def results_table(summary: pd.DataFrame) -> str:
    """Markdown: worst slopes over all scenes and families, errors of two scenes at the finest h."""
    finest = summary[summary["nu"] == 0.3]["h_finest"].min()
    side = f"{1.0 / finest + 1.0:.0f}³"
    lines = [
        f"| method | slope momentum | slope stress | momentum, linear, {side} | stress, linear, "
        f"{side} | momentum, large strain, {side} | stress, large strain, {side} |",
        "|---|---|---|---|---|---|---|",
    ]
    for label, method, operator in _ROWS:
        rows = summary[
            (summary["method"] == method)
            & (summary["operator"] == operator)
            & (summary["nu"] == 0.3)
            & summary["formulation"].isin(["{p,F}", "displacement", "-"])
            & summary["secondary"].isin(["H1", "-"])
            & ((summary["projection"] == "local") | (method != "SUPG-SPH"))
            & (summary["xi_F"] == 0.0)
        ]
        cells = [f"{rows['slope_p_last'].min():.2f}", f"{rows['slope_P_last'].min():.2f}"]
        for scene in ("linear", "manufactured"):
            row = rows[(rows["scene"] == scene) & (rows["family"] == "A+B+C=0")]
            cells += [f"{row[f'error_{field}_finest'].item():.1e}" for field in ("p", "P")]
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
