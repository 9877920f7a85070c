"""Everything that is wrong with a case file, said at once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from sphsolid.errors import InputError, nearest
from sphsolid.shell.lines import Place, line_of, spelled


class Missing:
    """In the place of what could not be read: a problem says why."""


MISSING = Missing()


@dataclass
class Problems:
    """What is wrong in ``file``: ``lines`` of its keys, and places ``changed`` by --set."""

    file: str
    lines: dict[Place, int]
    changed: frozenset[Place] = frozenset()
    found: list[tuple[int, str]] = field(default_factory=list)

    def add(self, place: Place, text: str) -> None:
        """Say that ``text`` is wrong at ``place``."""
        if any(place[: len(each)] == each for each in self.changed):
            where, line = f"--set {spelled(place)}", 10**9
        else:
            at = line_of(place, self.lines)
            line = at or 0
            names = [f"line {at}"] if at else []
            where = ", ".join([*names, *([spelled(place)] if place else [])])
        said = (line, f"{where}: {text}" if where else text)
        if said not in self.found:
            self.found.append(said)

    def unknown(self, place: Place, key: str, known: Iterable[str]) -> None:
        """``key`` of the table ``place`` is none of the ``known`` ones."""
        names = list(known)
        self.add(
            (*place, key),
            f"unknown key {key!r}{nearest(key, names)}; known here: {', '.join(names)}",
        )

    def raise_if_any(self) -> None:
        """One ``InputError`` with all of them, in the order of the file."""
        if not self.found:
            return
        texts = [text for _, text in sorted(self.found, key=lambda each: each[0])]
        if len(texts) == 1:
            raise InputError(f"{self.file}, {texts[0]}")
        raise InputError(
            f"{self.file} has {len(texts)} mistakes:\n" + "\n".join(f"  {each}" for each in texts)
        )
