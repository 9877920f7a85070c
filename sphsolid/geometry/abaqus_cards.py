"""The keyword lines of an Abaqus input file."""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from pathlib import Path

from sphsolid.errors import require

#: A comma that is not inside quotes.
_COMMA = re.compile(r',(?=(?:[^"]*"[^"]*")*[^"]*$)')


@dataclass(frozen=True)
class Card:
    """A keyword line with its parameters (upper-case keys) and its lines of data."""

    keyword: str
    given: dict[str, str]
    line: int
    data: list[str]

    def words(self) -> list[str]:
        """All data that are not blank, without the quotes around a name."""
        return [word for line in self.data for word in fields(line) if word]


@dataclass(frozen=True)
class Cards:
    """All cards of a file; ``unended``: its last line has data or a keyword and no line break."""

    cards: list[Card]
    lines: int
    unended: bool


def fields(line: str) -> list[str]:
    """What stands between the commas of a line, without blanks and quotes around it."""
    parts = _COMMA.split(line) if '"' in line else line.split(",")
    return [part.strip().strip('"').strip() for part in parts]


def read_cards(path: Path) -> Cards:
    """The keyword lines of a file; comments and blank lines are skipped.

    A keyword line that ends with a comma goes on in the next one.  Line ends may be those of any
    system.  Raises ``InputError`` for a file that is no text.
    """
    lines = _text(path).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    found: list[Card] = []
    continued = False
    for number, text in enumerate(lines, start=1):
        line = text.strip()
        if not line or line.startswith("**"):
            continue
        keyword = line.startswith("*")
        if not keyword and not continued:
            require(
                len(found) > 0,
                f"{path} is not an Abaqus input file: line {number} stands before the first "
                "*KEYWORD line",
            )
            found[-1].data.append(line)
            continue
        words = [word.strip() for word in _COMMA.split(line)]
        if keyword:
            name = " ".join(words.pop(0).lstrip("*").upper().split())
            found.append(Card(name, {}, number, []))
        for word in filter(None, words):
            key, _, value = word.partition("=")
            found[-1].given[" ".join(key.upper().split())] = value.strip().strip('"').strip()
        continued = line.endswith(",")
    last = lines[-1].strip()
    return Cards(found, len(lines), bool(last) and not last.startswith("**"))


def _text(path: Path) -> str:
    """Unicode, with or without its mark, or else one byte a letter: only names can differ."""
    data = path.read_bytes()
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    require(
        b"\0" not in data,
        f"{path} is not an Abaqus input file: it is no text; give the .inp file",
    )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")
