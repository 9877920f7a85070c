"""Pages of ``docs/`` whose numbers come from reports: Markdown with holes, filled by a command.

``python -m studies.readme_table`` fills every template beside this file, and README's table.  A
page is committed, so that it can be read without a build; a test fails where it is not what the
reports say.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from sphsolid.errors import InputError
from studies.engine.document import format_cell
from studies.engine.sources import ROOT
from studies.pages.reports import Reports

TEMPLATES = Path(__file__).parent
#: First line of every page that is made.
NOTE = "<!-- Made by `python -m studies.readme_table` from studies/pages/{}: edit that. -->\n"


def pages() -> dict[str, Path]:
    """Name of a page in ``docs/`` -> its template."""
    return {path.name: path for path in sorted(TEMPLATES.glob("*.md"))}


def filled(template: Path, root: Path = ROOT) -> str:
    """The text of a page; raises ``InputError`` for a hole that nothing fills."""
    try:
        import jinja2
    except ImportError as error:
        raise InputError(
            "pages are filled by jinja2, which is not installed: pip install 'sphsolid[report]'"
        ) from error

    environment = jinja2.Environment(
        undefined=jinja2.StrictUndefined, finalize=format_cell, trim_blocks=True,
        lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    environment.filters["number"] = format_cell
    environment.filters["percent"] = lambda value, digits=0: f"{value:.{digits}%}".replace(
        "%", " %"
    )
    try:
        made = environment.from_string(template.read_text(encoding="utf-8"))
        text = made.render(reports=Reports(root), table=markdown_table, isnan=math.isnan)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{template.name}: {type(error).__name__}: {error}") from error
    return NOTE.format(template.name) + text


def markdown_table(
    frame: pd.DataFrame,
    columns: Sequence[str] | Mapping[str, str] = (),
    formats: Mapping[str, str] | None = None,
) -> str:
    """A table in Markdown; ``columns`` chooses, orders and renames, ``formats`` are by column."""
    shown = frame[list(columns)] if columns else frame
    headings = columns if isinstance(columns, Mapping) else {}
    known = formats or {}
    lines = [
        [headings.get(name, name) for name in shown],
        ["---"] * shown.shape[1],
        *(
            [_cell(value, known.get(name, "")) for name, value in zip(shown, row, strict=True)]
            for row in shown.itertuples(index=False)
        ),
    ]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _cell(value: Any, form: str) -> str:
    text = format_cell(value, form if isinstance(value, float) else "")
    return text.replace("|", "\\|").replace("\n", " ").strip()
