"""Lays a document out with matplotlib, for machines without typst: plain, but complete."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure as Page
from matplotlib.image import imread
from PIL import Image

from studies.report.document import Bullets, Document, Figure, Paragraph, Table, pieces

#: A4 [inch] and its margin.
_WIDTH, _HEIGHT, _MARGIN = 8.27, 11.69, 0.8
_TEXT_WIDTH = _WIDTH - 2 * _MARGIN
#: Width of a monospaced letter as a share of the font size (DejaVu Sans Mono).
_LETTER = 0.602
#: Mean width of a proportional letter as a share of the font size (DejaVu Sans).
_MEAN_LETTER = 0.52
_LEADING = 1.35
#: Tallest drawing: a heading above and a caption below stay on its page.
_TALLEST, _CAPTION, _HEADING = 8.07, 0.8, 0.4
#: A text longer than this is broken into lines inside its column.
_LONG_TEXT = 60


def render(document: Document, path: Path) -> None:
    """Write the PDF."""
    writer = _Writer()
    writer.text(document.title, size=16, weight="bold")
    if document.subtitle:
        writer.text(document.subtitle, size=9, color="0.35")
    writer.gap(6)
    if document.abstract:
        writer.text(f"Abstract. {document.abstract}")
    tables = figures = 0
    for number, section in enumerate(document.sections, start=1):
        writer.gap(8)
        if section.blocks and isinstance(section.blocks[0], Figure):
            writer.need(_HEADING + _drawn_size(section.blocks[0])[1] + _CAPTION)
        writer.text(f"{number}  {section.title}", size=12.5, weight="bold", keep=5)
        for block in section.blocks:
            match block:
                case Paragraph(text):
                    writer.text(text)
                case Bullets(items):
                    for item in items:
                        writer.text(item, bullet=True)
                case Table():
                    tables += 1
                    writer.table(block, tables)
                case Figure():
                    figures += 1
                    writer.figure(block, figures)
    part = path.with_name(f".{path.name}.part")
    with mpl.rc_context({"pdf.fonttype": 42}):
        nothing = {"CreationDate": None, "Creator": None, "Producer": None}
        with PdfPages(part, metadata=nothing | {"Title": document.title}) as pdf:
            for number, page in enumerate(writer.pages, start=1):
                label = f"{number} / {len(writer.pages)}"
                page.text(0.5, 0.4 / _HEIGHT, label, ha="center", size=8)
                pdf.savefig(page)
    part.replace(path)


class _Writer:
    """A cursor that goes down pages; ``y`` is in inches from the top."""

    def __init__(self) -> None:
        self.pages: list[Page] = []
        self._new_page()

    def _new_page(self) -> None:
        page = Page(figsize=(_WIDTH, _HEIGHT))
        FigureCanvasAgg(page)
        self.pages.append(page)
        self.y = _MARGIN

    def need(self, height: float) -> None:
        """Go to the next page unless so many inches are left on this one."""
        if self.y + height > _HEIGHT - _MARGIN and self.y > _MARGIN:
            self._new_page()

    def gap(self, points: float) -> None:
        """Leave space."""
        self.y += points / 72.0

    def line(self, text: str, *, size: float, indent: float = 0.0, **style: Any) -> None:
        """One line of text, on the next page if this one is full."""
        height = _LEADING * size / 72.0
        self.need(height)
        self.pages[-1].text(
            (_MARGIN + indent) / _WIDTH,
            1.0 - self.y / _HEIGHT,
            # A dollar sign would begin mathematics.
            text.replace("$", r"\$"),
            size=size,
            va="top",
            **style,
        )
        self.y += height

    def text(
        self, text: str, *, size: float = 10.0, bullet: bool = False, keep: int = 1, **style: Any
    ) -> None:
        """A paragraph broken into lines; ``keep`` asks for that many lines on this page."""
        indent = 0.2 if bullet else 0.0
        plain = "".join(part for _, part in pieces(text))
        self.need(keep * _LEADING * size / 72.0)
        wide = style.get("weight") == "bold"
        letters = int((_TEXT_WIDTH - indent) * 72.0 / (size * _MEAN_LETTER * (1.12 if wide else 1)))
        lines = textwrap.wrap(plain, letters) or [""]
        for number, line in enumerate(lines):
            mark = ("• " if number == 0 else "   ") if bullet else ""
            self.line(mark + line, size=size, indent=indent / 2, **style)
        self.gap(0.4 * size)

    def table(self, table: Table, number: int) -> None:
        """Rows of monospaced text, the heading again on every page."""
        self.gap(4)
        self.text(f"Table {number}: {table.caption}", size=9, keep=6)
        if not len(table.frame):
            return
        head, *rows = _aligned(table)
        size = min(8.0, _TEXT_WIDTH * 72.0 / (_LETTER * len(head)))
        style: dict[str, Any] = {"size": size, "family": "monospace"}
        headed = None
        for row in rows:
            self.need(_LEADING * size / 72.0)
            if headed is not self.pages[-1]:
                self.line(head, weight="bold", **style)
                self.line("─" * len(head), **style)
                headed = self.pages[-1]
            self.line(row, **style)
        self.gap(8)

    def figure(self, figure: Figure, number: int) -> None:
        """The PNG at its width, with its caption."""
        image = imread(figure.file("png"))
        width, height = _drawn_size(figure)
        self.need(height + _CAPTION)
        left = (_WIDTH - width) / 2
        axes = self.pages[-1].add_axes(
            (left / _WIDTH, 1.0 - (self.y + height) / _HEIGHT, width / _WIDTH, height / _HEIGHT)
        )
        axes.imshow(image, aspect="auto", interpolation="none")
        axes.set_axis_off()
        self.y += height + 0.1
        self.text(f"Figure {number}: {figure.caption}", size=9)
        self.gap(6)


def _drawn_size(figure: Figure) -> tuple[float, float]:
    """Width and height in inches: the width that was asked for, or less where it is too tall."""
    with Image.open(figure.file("png")) as image:
        columns, rows = image.size
    height = min(_TEXT_WIDTH * figure.width * rows / columns, _TALLEST)
    return height * columns / rows, height


def _aligned(table: Table) -> Iterator[str]:
    """Heading and rows, padded so that numbers end and texts begin in one column.

    A long text is broken into lines, so a row may take several.
    """
    head, body, numeric = table.head(), table.body(), table.numeric()
    widths = [max(map(len, column)) for column in zip(head, *body, strict=True)]
    widths = [min(width, _LONG_TEXT) for width in widths]
    for row in [head, *body]:
        columns = [
            [cell.rjust(width)] if is_number else textwrap.wrap(cell, width) or [""]
            for cell, width, is_number in zip(row, widths, numeric, strict=True)
        ]
        for cells in zip_longest(*columns, fillvalue=""):
            yield "  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True))
