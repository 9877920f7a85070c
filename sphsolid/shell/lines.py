"""On which line of a TOML text a key stands: what its reader does not say."""

from __future__ import annotations

import re

#: A key by the tables and lists that it is in: ``("constraints", 1, "face")``.
Place = tuple[str | int, ...]
_NAME = r"(?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')"
_KEY = re.compile(rf"^\s*({_NAME}(?:\s*\.\s*{_NAME})*)\s*=")
_TABLE = re.compile(rf"^\s*(\[\[?)\s*({_NAME}(?:\s*\.\s*{_NAME})*)\s*\]")
_STRING = re.compile(r'"(?:[^"\\]|\\.)*"|\'[^\']*\'')


def key_lines(text: str) -> dict[Place, int]:
    """Line numbers, from 1, of tables and keys; of what an inline table holds, that of its key."""
    found: dict[Place, int] = {(): 1}
    inside: Place = ()
    counts: dict[Place, int] = {}
    depth, quote = 0, ""
    for number, line in enumerate(text.splitlines(), start=1):
        if quote:
            if quote in line:
                quote = ""
            continue
        if depth == 0:
            if table := _TABLE.match(line):
                inside = _table(table, counts)
                found.setdefault(inside, number)
                continue
            if key := _KEY.match(line):
                found.setdefault((*inside, *_parts(key[1])), number)
                line = line[key.end() :]
        for marks in ('"""', "'''"):
            if line.count(marks) % 2:
                quote = marks
        bare = _STRING.sub("", line).split("#")[0]
        depth = max(0, depth + sum(bare.count(c) for c in "[{") - sum(bare.count(c) for c in "]}"))
    return found


def line_of(place: Place, lines: dict[Place, int]) -> int | None:
    """The line of a key, or of the nearest thing that it is in; None where even that is unknown."""
    for length in range(len(place), 0, -1):
        # A table that should not be a list stands in its first member.
        for known in (place[:length], (*place[:length], 0)):
            if known in lines:
                return lines[known]
    return None


def spelled(place: Place) -> str:
    """``constraints[1].face``, counted from one as a reader does."""
    text = ""
    for part in place:
        text += f"[{part + 1}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def _table(found: re.Match[str], counts: dict[Place, int]) -> Place:
    place = _indexed(_parts(found[2]), counts, is_new=found[1] == "[[")
    return place


def _indexed(parts: Place, counts: dict[Place, int], *, is_new: bool) -> Place:
    """``parts`` with the number of the member where a list of tables is passed."""
    place: Place = ()
    for k, part in enumerate(parts):
        place = (*place, part)
        if k == len(parts) - 1 and is_new:
            counts[place] = counts.get(place, -1) + 1
        if place in counts:
            place = (*place, counts[place])
    return place


def _parts(text: str) -> Place:
    return tuple(part.strip("\"'") for part in re.findall(_NAME, text))
