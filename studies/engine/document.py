"""A small model of a report, which ``typeset`` makes a PDF of.

A report is a title, an abstract and blocks: headings, paragraphs, bullet lists, tables, figures.
Texts are plain; `` `code` ``, ``*emphasis*`` and ``**bold**`` are the only markup.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd


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
