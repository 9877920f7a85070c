"""A small model of a report, and the PDF that typst makes of it.

A report is a title, an abstract and blocks: headings, paragraphs, bullet lists, tables, figures.
Texts are plain; `` `code` ``, ``*emphasis*`` and ``**bold**`` are the only markup.
"""

from __future__ import annotations

import importlib.util
import re
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sphsolid.errors import require


@dataclass(frozen=True)
class Heading:
    """A numbered heading; ``level`` 1 is the highest."""

    text: str
    level: int = 1


@dataclass(frozen=True)
class Paragraph:
    """Running text."""

    text: str


@dataclass(frozen=True)
class Bullets:
    """A list of short texts."""

    items: Sequence[str]


@dataclass(frozen=True)
class Table:
    """A data frame with a caption; long ones go over pages with their heading repeated.

    ``formats`` maps a column to a format such as ``".2e"`` (floats otherwise ``".3g"``),
    ``headings`` to what stands above it (otherwise its name).  Numbers are set right, texts left.
    """

    caption: str
    frame: pd.DataFrame
    formats: Mapping[str, str] = field(default_factory=dict)
    headings: Mapping[str, str] = field(default_factory=dict)

    def head(self) -> list[str]:
        """Headings in order."""
        return [self.headings.get(str(c), str(c)) for c in self.frame.columns]

    def body(self) -> list[list[str]]:
        """Formatted cells, row by row."""
        names = [str(c) for c in self.frame.columns]
        return [
            [format_cell(v, self.formats.get(n, "")) for n, v in zip(names, row, strict=True)]
            for row in self.frame.itertuples(index=False, name=None)
        ]

    def numeric(self) -> list[bool]:
        """Which columns hold numbers."""
        return [
            pd.api.types.is_numeric_dtype(kind) and not pd.api.types.is_bool_dtype(kind)
            for kind in self.frame.dtypes
        ]


@dataclass(frozen=True)
class Figure:
    """A drawing in a file (PDF or PNG); ``width`` is a fraction of the text's."""

    caption: str
    path: Path
    width: float = 1.0


Block = Heading | Paragraph | Bullets | Table | Figure


@dataclass(frozen=True)
class Document:
    """The whole report; ``subtitle`` is a line under the title (say, version and date)."""

    title: str
    abstract: str
    blocks: Sequence[Block]
    subtitle: str = ""


def format_cell(value: Any, pattern: str = "") -> str:
    """A cell as text: missing values as a dash, floats with three digits unless told."""
    if value is None or (isinstance(value, float | np.floating) and np.isnan(value)):
        return "–"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return format(int(value), pattern or "d")
    if isinstance(value, float | np.floating):
        return format(float(value), pattern or ".3g")
    return str(value)


def pieces(text: str) -> list[tuple[str, str]]:
    """Split a text into ``(kind, text)``: ``plain``, ``code``, ``bold`` or ``emph``."""
    found = []
    for part in re.split(r"(`[^`]+`|\*\*[^*]+\*\*|(?<!\w)\*[^*\s][^*]*\*(?!\w))", text):
        if len(part) > 2 and part[0] == part[-1] == "`":
            found.append(("code", part[1:-1]))
        elif len(part) > 4 and part[:2] == part[-2:] == "**":
            found.append(("bold", part[2:-2]))
        elif len(part) > 2 and part[0] == part[-1] == "*":
            found.append(("emph", part[1:-1]))
        elif part:
            found.append(("plain", part))
    return found


# --- the same as a PDF, by typst ------------------------------------------------------------------

_PREAMBLE = """
#set page(paper: "a4", margin: (x: 20mm, top: 22mm, bottom: 22mm), numbering: "1 / 1")
#set text(font: ("Libertinus Serif", "New Computer Modern"), size: 10.5pt, lang: "en")
#set par(justify: true)
#set heading(numbering: "1.1")
#set list(indent: 3mm)
#show heading: set block(above: 1.4em, below: 0.8em)
#show raw: set text(size: 0.92em)
#show figure: set block(above: 1.3em, below: 1.3em)
#show figure.where(kind: table): set block(breakable: true)
#show figure.where(kind: table): set figure.caption(position: top)
#show figure.caption: it => block(sticky: true, align(left, text(size: 0.9em, it)))
#set table(stroke: none, inset: (x: 3.5pt, y: 2.6pt))
#show table.cell.where(y: 0): strong
// As wide as asked, unless a heading above and a caption below would then leave the page.
#let drawing(name, width) = layout(room => {
  let wide = image(name, width: width * room.width)
  if measure(wide).height > 205mm { image(name, height: 205mm) } else { wide }
})
"""

#: Characters that fit into the width of the text at 9 pt, columns and gaps together.
_WIDTH_AT_9PT = 104
#: A text longer than this is broken into lines rather than shrinking the whole table.
_LONG_TEXT = 46


def write_pdf(document: Document, path: Path) -> None:
    """Write the PDF with typst; equal documents give equal bytes.

    Raises ``InputError`` where typst is not installed.
    """
    require(
        importlib.util.find_spec("typst") is not None,
        "reports are typeset by typst, which is not installed: pip install 'sphsolid[report]'",
    )
    import typst

    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "document.typ"
        source.write_text(to_typst(document, Path(folder)), encoding="utf-8")
        made = Path(folder) / "document.pdf"
        # Tags of every cell of every table would be four fifths of the file.
        typst.compile(
            str(source), output=str(made), root=folder, ignore_system_fonts=True, pdf_tags=False
        )
        part = path.with_name(f".{path.name}.part")
        shutil.copyfile(made, part)
        part.replace(path)


def to_typst(document: Document, folder: Path) -> str:
    """The typst source; figures are copied into ``folder``, so no other folder enters the file."""
    parts = [
        f"#set document(title: {quote(document.title)}, author: (), date: none)",
        _PREAMBLE,
        f'#align(center)[#text(size: 17pt, weight: "bold")[{markup(document.title)}]]',
    ]
    if document.subtitle:
        parts.append(f"#align(center)[#text(fill: luma(90))[{markup(document.subtitle)}]]")
    if document.abstract:
        abstract = markup(document.abstract)
        parts.append(f"#pad(x: 8mm, y: 3mm)[#text(size: 0.95em)[{abstract}]]")
    for number, block in enumerate(document.blocks, start=1):
        match block:
            case Heading(text, level):
                parts.append(f"{'=' * level} {markup(text)}")
            case Paragraph(text):
                parts.append(markup(text))
            case Bullets(items):
                parts.append("\n".join(f"- {markup(item)}" for item in items))
            case Table():
                parts.append(_table(block))
            case Figure():
                name = f"figure-{number}{block.path.suffix}"
                shutil.copyfile(block.path, folder / name)
                parts.append(
                    f"#figure(drawing({quote(name)}, {block.width:.4g}), "
                    f"caption: [{markup(block.caption)}])"
                )
    return "\n\n".join(parts) + "\n"


def _table(table: Table) -> str:
    head, body, numeric = table.head(), table.body(), table.numeric()
    if not body:
        return markup(f"{table.caption} (no rows)")
    longest = [max(map(len, column)) for column in zip(head, *body, strict=True)]
    needed = sum(min(_LONG_TEXT, letters) for letters in longest) + 2 * len(longest)
    size = min(9.0, max(5.0, 9.0 * _WIDTH_AT_9PT / needed))
    align = ", ".join("right" if is_number else "left" for is_number in numeric)
    rows = ["".join(f"[{markup(cell)}], " for cell in row) for row in body]
    return "\n".join(
        [
            "#figure(kind: table, caption: [" + markup(table.caption) + "])[",
            f'#set text(size: {size:.3g}pt, number-width: "tabular")',
            "#set par(justify: false)",
            f"#table(columns: {len(head)}, align: ({align},),",
            "table.hline(stroke: 0.7pt),",
            "table.header(" + "".join(f"[{markup(cell)}], " for cell in head) + "),",
            "table.hline(stroke: 0.4pt),",
            *rows,
            "table.hline(stroke: 0.7pt),",
            ")]",
        ]
    )


_WRAP = {"plain": "{}", "code": "raw({})", "bold": "strong({})", "emph": "emph({})"}


def markup(text: str) -> str:
    """Typst markup in which every character of ``text`` is literal."""
    made = []
    for kind, part in pieces(text):
        literal = quote(part)
        made.append(f"#{_WRAP[kind].format(literal)};")
    return "".join(made)


def quote(text: str) -> str:
    """A typst string literal."""
    flat = " ".join(text.split("\n")).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{flat}"'
