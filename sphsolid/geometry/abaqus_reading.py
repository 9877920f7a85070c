"""Abaqus ``.inp`` files: nodes, elements and what gives facets a name.

Read here and not through meshio, which knows no ``*SURFACE``, refuses surface elements of second
order, loses sets that are given in parts, and gives some the elements of others.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.abaqus_cards import Card, cards
from sphsolid.geometry.abaqus_elements import Elements, elements_of
from sphsolid.geometry.file_content import SURFACE_CORNERS, Block, FileContent

Indices = NDArray[np.int64]

#: Keywords that make, move or fetch nodes and elements, which is not followed here.
_GENERATORS = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "INCLUDE")


@dataclass
class _Input:
    """All that has been read: sets and names are found whatever their case."""

    ids: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    points: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    elements: list[Elements] = field(default_factory=list)
    nsets: dict[str, Indices] = field(default_factory=dict)
    elsets: dict[str, Indices] = field(default_factory=dict)
    #: Names of the element sets of ``*ELSET``, not of ``*ELEMENT`` lines.
    explicit: list[str] = field(default_factory=list)
    surfaces: dict[str, list[tuple[str, Indices]]] = field(default_factory=dict)


def read_abaqus(path: Path) -> FileContent:
    """Nodes, elements and names of an ``.inp`` file.

    Tags: each element-based ``*SURFACE``, each ``*ELSET`` with surface elements (shells,
    membranes, plane elements), and, where neither names a surface element, the ``ELSET`` of its
    ``*ELEMENT`` line.  ``*NSET`` become node sets.  Sets may be given in parts, by numbers,
    ``GENERATE`` or other sets.  Raises ``InputError``, with the line, for what is malformed,
    for unknown element types, numbers given twice and for input that generates or moves nodes.
    """
    lines = list(cards(path))
    text = path.read_bytes()
    last = 1 + text.count(b"\n")
    require(
        text.endswith(b"\n"),
        f"{path} is truncated: it ends in the middle of line {last}; copy or write it again, or "
        "end it with a line break if it is complete",
    )
    require(len(lines) > 0, f"{path} is not an Abaqus input file: it has no *KEYWORD lines")
    found = _Input()
    for card in lines:
        where = f"{path}, line {card.line}, *{card.keyword}"
        try:
            _take(where, card, found)
        except InputError:
            raise
        except (ValueError, IndexError, KeyError) as error:
            raise InputError(
                f"{where}: its parameters or data cannot be read ({type(error).__name__}: "
                f"{error}); the file is truncated or damaged"
            ) from error
    tags = dict(found.surfaces)
    named = np.zeros(0, np.int64)
    for name in found.explicit:
        if not (rows := _surface_elements(found, found.elsets[name])):
            continue
        named = np.union1d(named, found.elsets[name])
        tags.setdefault(name, rows)
    for name in found.elsets:
        rest = np.setdiff1d(found.elsets[name], named)
        if name not in found.explicit and (rows := _surface_elements(found, rest)):
            tags.setdefault(name, rows)
    return FileContent(
        found.points,
        _blocks(path, found.ids, [(e.kind, e.nodes) for e in found.elements if e.kind != "line"]),
        {name: _blocks(path, found.ids, rows) for name, rows in tags.items()},
        {name: _place(path, found.ids, nodes) for name, nodes in found.nsets.items()},
    )


def _take(where: str, card: Card, found: _Input) -> None:
    """Add what a card says."""
    if card.keyword in _GENERATORS or (card.keyword == "INSTANCE" and card.data):
        raise InputError(
            f"{where}: it makes, moves or fetches nodes, which is not followed here; write the "
            "mesh as one flat file"
        )
    if card.keyword == "NODE":
        rows = [row.split(",")[:4] for row in card.data]
        if any(len([w for w in row if w.strip()]) != 4 for row in rows):
            raise InputError(f"{where}: a node needs a number and three coordinates")
        ids = np.array([int(row[0]) for row in rows], dtype=np.int64)
        _refuse_twice(where, "node", np.concatenate([found.ids, ids]))
        found.ids = np.concatenate([found.ids, ids])
        points = np.array([[float(w) for w in row[1:]] for row in rows]).reshape(-1, 3)
        found.points = np.concatenate([found.points, points])
        if "NSET" in card.given:
            _extend(found.nsets, card.given["NSET"], ids)
    elif card.keyword == "ELEMENT":
        block = elements_of(where, card)
        _refuse_twice(where, "element", np.concatenate([e.ids for e in (*found.elements, block)]))
        found.elements.append(block)
        if "ELSET" in card.given:
            _extend(found.elsets, card.given["ELSET"], block.ids)
    elif card.keyword == "NSET":
        members = _members(where, card, found.nsets, found.ids)
        if "ELSET" in card.given:
            ids = found.elsets[_known(found.elsets, card.given["ELSET"])]
            members = np.concatenate(
                [members, *(e.nodes[np.isin(e.ids, ids)].ravel() for e in found.elements)]
            )
        _extend(found.nsets, card.given["NSET"], members)
    elif card.keyword == "ELSET":
        known = np.concatenate([np.zeros(0, np.int64), *(e.ids for e in found.elements)])
        members = _members(where, card, found.elsets, known)
        name = _extend(found.elsets, card.given["ELSET"], members)
        if name not in found.explicit:
            found.explicit.append(name)
    elif card.keyword == "SURFACE" and card.given.get("TYPE", "ELEMENT") == "ELEMENT":
        found.surfaces.setdefault(card.given["NAME"], []).extend(_surface(where, card, found))


def _members(where: str, card: Card, sets: dict[str, Indices], known: Indices) -> Indices:
    """Numbers of a set: numbers, ranges, or other sets."""
    if "GENERATE" in card.given:
        ranges = [[int(w) for w in row.split(",") if w.strip()] for row in card.data]
        parts = [np.arange(low, high + 1, *step) for low, high, *step in ranges]
    else:
        words = card.words()
        numbers = [int(word) for word in words if word.isdigit()]
        others = [word for word in words if not word.isdigit()]
        parts = [np.array(numbers), *(sets[_known(sets, word)] for word in others)]
    members = np.concatenate([np.zeros(0, np.int64), *parts]).astype(np.int64)
    missing = np.setdiff1d(members, known)
    if len(missing) and "GENERATE" not in card.given:
        raise InputError(
            f"{where}: the set has {len(missing)} members that the file does not define before "
            f"it, the first of them number {missing[0]}; the file is truncated or damaged"
        )
    return members[np.isin(members, known)]


def _surface(where: str, card: Card, found: _Input) -> list[tuple[str, Indices]]:
    """Facets of a ``*SURFACE``: kinds and nodes."""
    facets: list[tuple[str, Indices]] = []
    for row in card.data:
        region, label, *_ = [*(word.strip() for word in row.split(",")), ""]
        ids = (
            np.array([int(region)])
            if region.isdigit()
            else found.elsets[_known(found.elsets, region)]
        )
        for block in found.elements:
            facets += block.facets(where, ids, label)
    return facets


def _surface_elements(found: _Input, ids: Indices) -> list[tuple[str, Indices]]:
    rows = [
        (block.kind, block.nodes[np.isin(block.ids, ids)])
        for block in found.elements
        if block.kind in SURFACE_CORNERS
    ]
    return [(kind, nodes) for kind, nodes in rows if len(nodes)]


def _known(sets: dict[str, Indices], name: str) -> str:
    """The name as it was first written; names differ by more than their case."""
    for known in sets:
        if known.upper() == name.upper():
            return known
    raise KeyError(f"set {name!r} is not defined before it is used; the sets are {sorted(sets)}")


def _extend(sets: dict[str, Indices], name: str, members: Indices) -> str:
    known = next((other for other in sets if other.upper() == name.upper()), name)
    sets[known] = np.union1d(sets.get(known, np.zeros(0, np.int64)), members)
    return known


def _refuse_twice(where: str, what: str, ids: Indices) -> None:
    ordered = np.sort(ids)
    again = ordered[1:][np.diff(ordered) == 0]
    if len(again):
        raise InputError(
            f"{where}: {what} {again[0]} is defined twice (several parts in one file?); give "
            "one part, with its own numbers"
        )


def _blocks(
    path: Path, ids: Indices, rows: list[tuple[str, Indices]]
) -> tuple[Block, ...]:
    return tuple(Block(kind, _place(path, ids, nodes)) for kind, nodes in rows)


def _place(path: Path, ids: Indices, nodes: Indices) -> Indices:
    """Where nodes stand in the list of points."""
    order = np.argsort(ids)
    at = np.minimum(np.searchsorted(ids[order], nodes), len(ids) - 1)
    missing = ids[order[at]] != nodes if len(ids) else np.ones(nodes.shape, dtype=bool)
    if missing.any():
        raise InputError(
            f"{path}: elements use vertices that the file does not define, the first of them "
            f"node {nodes[missing].min()}; the file is truncated or damaged"
        )
    return np.asarray(order[at])
