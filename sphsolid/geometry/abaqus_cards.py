"""The keyword lines of an Abaqus input file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Card:
    """A keyword line with its parameters (upper-case keys) and its lines of data."""

    keyword: str
    given: dict[str, str]
    line: int
    data: list[str]

    def words(self) -> list[str]:
        """All data that are not blank."""
        return [word for word in (w.strip() for w in ",".join(self.data).split(",")) if word]


def cards(path: Path) -> Iterator[Card]:
    """The keyword lines of a file; comments and blank lines are skipped."""
    card = Card("", {}, 0, [])
    continued = False
    with path.open(encoding="utf-8", errors="replace") as lines:
        for number, text in enumerate(lines, start=1):
            line = text.strip()
            if not line or line.startswith("**"):
                continue
            if not line.startswith("*") and not continued:
                card.data.append(line)
                continue
            words = [word.strip() for word in line.lstrip("*").split(",")]
            if not continued:
                if card.keyword:
                    yield card
                card = Card(words.pop(0).upper(), {}, number, [])
            for word in filter(None, words):
                key, _, value = word.partition("=")
                key, value = key.strip().upper(), value.strip().strip('"')
                card.given[key] = value.upper() if key == "TYPE" else value
            continued = line.endswith(",")
    if card.keyword:
        yield card
