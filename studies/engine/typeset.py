"""Typesets a document with typst."""

from __future__ import annotations

import importlib.util
import shutil
import tempfile
from pathlib import Path

from sphsolid.errors import require
from studies.engine.document import (
    Bullets,
    Document,
    Figure,
    Heading,
    Paragraph,
    Table,
    pieces,
)

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
        typst.compile(str(source), output=str(made), root=folder, ignore_system_fonts=True)
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
