"""The words of a report: a Markdown template with holes, filled from the tables.

``{{ order | number(".2f") }}`` is a number, ``{{ table(frame, "caption") }}`` a table and
``{{ figure("name", "caption") }}`` a figure, each of the last two on a line of its own.  The first
heading is the title and what stands before the second is the abstract, and tables or figures that
belong to it.  What was found (the claims) follows on the first page; what was run and what failed
end the report.
"""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any

import pandas as pd

from sphsolid.errors import InputError, require
from sphsolid.record.display import duration
from studies.engine.claims import Claim, claims_table
from studies.engine.document import (
    Block,
    Bullets,
    Document,
    Figure,
    Heading,
    Paragraph,
    Table,
    format_cell,
)
from studies.engine.results import Results

#: What a report can hold of Markdown.
_HELD = ("heading", "paragraph", "bullet_list", "list_item")
#: Around the number of a block in the filled text: no author writes it.
_MARK = "\x02"


def document(
    template: Path,
    results: Results,
    *,
    claims: Sequence[Claim],
    words: Mapping[str, Any],
    draw: Callable[[str], Path],
) -> Document:
    """Fill ``template`` from ``results``; ``words`` are further holes, ``draw`` saves a figure.

    Raises ``InputError`` for a hole that nothing fills.
    """
    blocks: list[Block] = []
    text = _filled(template, results, claims, words, draw, blocks)
    title, abstract, first, body = _parts(template, list(_read(text, blocks)))
    return Document(
        title=title,
        subtitle=subtitle(results.run),
        abstract=abstract,
        blocks=[*first, *_found(claims), *body, *_run(results.run), *_failed(results.failures)],
    )


def subtitle(run: Mapping[str, Any]) -> str:
    """Version, form and date in one line."""
    commit = f", commit {run['commit'][:10]}" if run["commit"] else ""
    return f"sphsolid {run['version']}{commit} · {run['mode']} study · {run['date_utc']} UTC"


def _filled(
    template: Path,
    results: Results,
    claims: Sequence[Claim],
    words: Mapping[str, Any],
    draw: Callable[[str], Path],
    blocks: list[Block],
) -> str:
    try:
        import jinja2
    except ImportError as error:
        raise InputError(
            "reports are filled by jinja2, which is not installed: pip install 'sphsolid[report]'"
        ) from error

    def placed(block: Block) -> str:
        blocks.append(block)
        return f"{_MARK}{len(blocks) - 1}{_MARK}"

    def table(
        frame: pd.DataFrame,
        caption: str,
        columns: Sequence[str] | Mapping[str, str] = (),
        formats: Mapping[str, str] | None = None,
    ) -> str:
        shown = frame[list(columns)] if columns else frame
        headings = columns if isinstance(columns, Mapping) else {}
        return placed(Table(caption, shown, formats or {}, headings))

    def figure(name: str, caption: str, width: float = 1.0) -> str:
        return placed(Figure(caption, draw(name), width))

    environment = jinja2.Environment(
        undefined=jinja2.StrictUndefined, finalize=format_cell, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["number"] = format_cell
    environment.filters["percent"] = lambda value, digits=0: f"{value:.{digits}%}".replace(
        "%", " %"
    )
    environment.filters["duration"] = duration
    environment.filters["listed"] = lambda items: ", ".join(map(format_cell, items))
    holes = {"tables": results.tables, "run": results.run, "claims": claims} | dict(words)
    try:
        made = environment.from_string(template.read_text(encoding="utf-8"))
        return made.render(holes, table=table, figure=figure, isnan=math.isnan)
    except InputError:
        raise
    except Exception as error:
        lines = [getattr(error, "lineno", None)]
        frames = traceback.extract_tb(error.__traceback__)
        lines += [frame.lineno for frame in frames if frame.filename == "<template>"]
        where = template.name + "".join(f", line {line}" for line in lines[-1:] if line)
        raise InputError(f"{where}: {type(error).__name__}: {error}") from error


def _read(text: str, blocks: Sequence[Block]) -> Iterator[Block]:
    """Blocks of the filled Markdown, with ``blocks`` in the places of their marks."""
    from markdown_it import MarkdownIt

    tokens = MarkdownIt("commonmark").parse(text)
    items: list[str] = []
    for number, token in enumerate(tokens):
        require(
            token.type.rpartition("_")[0] in _HELD or token.type == "inline",
            f"the text of a report holds headings, paragraphs and bullets, not {token.type} "
            f"({token.content.strip()[:60]!r})",
        )
        if token.type == "bullet_list_close":
            yield Bullets(tuple(items))
            items = []
        if token.type != "inline":
            continue
        content = " ".join(token.content.split("\n"))
        inside = tokens[number - 1]
        if inside.type == "heading_open":
            yield Heading(content, int(inside.tag[1:]))
        elif tokens[number - 2].type == "list_item_open":
            items.append(content)
        elif _MARK in content:
            yield from _placed(content, blocks)
        elif content:
            yield Paragraph(content)


def _placed(content: str, blocks: Sequence[Block]) -> Iterator[Block]:
    for number, part in enumerate(content.split(_MARK)):
        if number % 2:
            yield blocks[int(part)]
        elif part.strip():
            yield Paragraph(part.strip())


def _parts(template: Path, found: list[Block]) -> tuple[str, str, list[Block], list[Block]]:
    """Title, abstract, what stands beside it, and the rest, whose headings go up by one level."""
    require(
        len(found) > 1 and isinstance(found[0], Heading) and found[0].level == 1,
        f"{template.name} must begin with its title: # Title",
    )
    rest = found[1:]
    abstract = [block.text for block in takewhile(lambda b: isinstance(b, Paragraph), rest)]  # type: ignore[union-attr]
    rest = rest[len(abstract) :]
    first = list(takewhile(lambda block: not isinstance(block, Heading), rest))
    body: list[Block] = [
        Heading(block.text, max(1, block.level - 1)) if isinstance(block, Heading) else block
        for block in rest[len(first) :]
    ]
    return found[0].text, " ".join(abstract), first, body  # type: ignore[union-attr]


def _found(claims: Sequence[Claim]) -> list[Block]:
    if not claims:
        return []
    frame = claims_table(claims)
    used = [name for name in frame if name != "source" and (frame[name] != "").any()]
    caption = (
        "What was claimed or asked, what was measured, and the verdict; what does not hold first."
    )
    return [Heading("What was found"), Table(caption, frame[used])]


def _run(run: Mapping[str, Any]) -> list[Block]:
    commit = run["commit"] or "not known (no checkout)"
    if run["sources_modified"]:
        commit += ", with changes not committed"
    cases = f"{run['cases']} ({run['cases_failed']} failed, {run['cases_resumed']} resumed)"
    if run.get("cases_sampled"):
        cases += (
            f"; {run['cases_sampled']} are of older sources, kept because another case of the same "
            "sequence gave the same rows"
        )
    if run.get("cases_with_older_times"):
        cases += (
            f"; {run['cases_with_older_times']} were run again and have the times of a step that "
            "were measured before, in one session with the others"
        )
    facts = {
        "command": run["command"],
        "date (UTC)": run["date_utc"],
        "wall time": duration(run["wall_s"]),
        "cases": cases,
        "version": run["version"],
        "commit": commit,
        "hash of the sources": run["source_hash"],
        "Python": run["python"],
        "packages": ", ".join(f"{name} {version}" for name, version in run["packages"].items()),
        "processor": f"{run['cpu']}, {run['cores']} cores, {run['system']}",
        "workers": f"{run['jobs']}{' of a Dask cluster' if run.get('cluster') else ''}, "
        f"each with {run['threads_per_job']} kernel thread(s)",
    }
    frame = pd.DataFrame({"what": list(facts), "value": list(facts.values())})
    return [Heading("What was run"), Table("How these results were made.", frame)]


def _failed(failures: pd.DataFrame) -> list[Block]:
    if len(failures) == 0:
        return [Heading("What failed"), Paragraph("No case failed.")]
    frame = failures[["key", "failure", "message"]]
    return [
        Heading("What failed"),
        Paragraph(
            f"{len(frame)} case(s) stopped before their end. They have no rows in the tables "
            "above, and orders are not computed from families that lack a level."
        ),
        Table("Cases that stopped, and why.", frame),
    ]
