"""``--set place=value``: what is put in the place of what a case file says."""

from __future__ import annotations

import itertools
import re
import tomllib
from collections.abc import Sequence
from typing import Any

from sphsolid.errors import InputError, require
from sphsolid.shell.case import Setting
from sphsolid.shell.lines import Place

_PART = re.compile(r"[A-Za-z0-9_-]+(?:\[\d+\])?$")


def parse(text: str) -> list[Setting]:
    """``a.b=1,2`` as one setting for each value; commas within brackets and quotes are no ends."""
    name, equals, values = text.partition("=")
    require(
        bool(equals) and bool(name.strip()),
        f"--set {text}: write a key of the case file and its value: --set spacing=1/6",
    )
    place = _place(name.strip(), text)
    found = [Setting(place, _value(each.strip())) for each in _split(values)]
    require(
        all(each.value != "" for each in found), f"--set {text}: a value is missing"
    )
    return found


def one(text: str) -> Setting:
    """A setting with one value."""
    found = parse(text)
    require(
        len(found) == 1,
        f"--set {text} has {len(found)} values; one run takes one: use sphsolid sweep",
    )
    return found[0]


def product(texts: Sequence[str]) -> list[tuple[Setting, ...]]:
    """All combinations of the values of several ``--set``, the last one changing fastest."""
    choices = [parse(text) for text in texts]
    places = [each[0].place for each in choices]
    for place in places:
        if places.count(place) > 1:
            raise InputError(f"--set {'.'.join(map(str, place))} is given twice")
    return list(itertools.product(*choices))


def shown(value: Any) -> str:
    """A value as it was written."""
    return value if isinstance(value, str) else repr(value)


def _place(name: str, text: str) -> Place:
    place: list[str | int] = []
    for part in name.split("."):
        require(
            _PART.match(part) is not None,
            f"--set {text}: {name!r} is no key; write material.poisson_ratio, or "
            "constraints[1].direction for a member of a list, counted from 1",
        )
        key, _, number = part.partition("[")
        place.append(key)
        if number:
            index = int(number[:-1])
            require(index >= 1, f"--set {text}: members of lists are counted from 1")
            place.append(index - 1)
    return tuple(place)


def _split(values: str) -> list[str]:
    """At commas that are in no bracket and no quotes."""
    parts, depth, quote = [""], 0, ""
    for letter in values:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter in "([{":
            depth += 1
        elif letter in ")]}":
            depth -= 1
        elif letter == "," and depth == 0:
            parts.append("")
            continue
        parts[-1] += letter
    return parts


def _value(text: str) -> Any:
    """As TOML reads it where it does, else a text: ``1/6`` and ``SUPG(xi_F=0)`` need no quotes."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
