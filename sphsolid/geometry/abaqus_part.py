"""What stands in one part of an Abaqus input file, by the numbers and names of that part."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.abaqus_cards import Card
from sphsolid.geometry.abaqus_elements import Elements, elements_of, numbers
from sphsolid.geometry.numbering import Numbering

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass
class Named:
    """A set or surface under the name that it was first given: cards, and numbers as such.

    ``of_elements``: only ``*ELEMENT`` lines have named it.
    """

    name: str
    cards: list[tuple[str, Card]] = field(default_factory=list)
    numbers: list[Indices] = field(default_factory=list)
    of_elements: bool = True

    @property
    def internal(self) -> bool:
        """Whether a program made it for itself, and says so."""
        return any("INTERNAL" in card.given for _, card in self.cards)


Names = dict[str, Named]
_FORTRAN = re.compile(r"([-+0-9.]+)[dD]([-+]?\d+)")


@dataclass
class Part:
    """Nodes, elements and names of a part, an instance, the assembly or a file without parts.

    Every block comes with the line that it begins in.  Names are found whatever their case.
    """

    nodes: list[tuple[str, Indices]] = field(default_factory=list)
    points: list[Array] = field(default_factory=list)
    elements: list[tuple[str, Elements]] = field(default_factory=list)
    nsets: Names = field(default_factory=dict)
    elsets: Names = field(default_factory=dict)
    surfaces: Names = field(default_factory=dict)
    node_surfaces: Names = field(default_factory=dict)

    def take(self, where: str, card: Card) -> None:
        """Add what a card says; sets are only noted, since they may name what comes later."""
        given = card.given
        if card.keyword == "NODE":
            ids, points = _nodes(where, card)
            self.nodes.append((where, ids))
            self.points.append(points)
            if given.get("NSET"):
                named(self.nsets, given["NSET"]).numbers.append(ids)
        elif card.keyword == "ELEMENT":
            block = elements_of(where, card)
            self.elements.append((where, block))
            if given.get("ELSET"):
                named(self.elsets, given["ELSET"]).numbers.append(block.ids)
        elif card.keyword == "SURFACE":
            by_nodes = given.get("TYPE", "").upper() == "NODE"
            kind = self.node_surfaces if by_nodes else self.surfaces
            named(kind, given["NAME"]).cards.append((where, card))
        else:
            sets = self.nsets if card.keyword == "NSET" else self.elsets
            entry = named(sets, given[card.keyword])
            entry.cards.append((where, card))
            entry.of_elements = False

    def joined(self, other: Part) -> Part:
        """The part and what one of its instances adds."""
        result = Part()
        for part in (self, other):
            result.nodes += part.nodes
            result.points += part.points
            result.elements += part.elements
            for name in ("nsets", "elsets", "surfaces", "node_surfaces"):
                for entry in getattr(part, name).values():
                    into = named(getattr(result, name), entry.name)
                    into.cards += entry.cards
                    into.numbers += entry.numbers
                    into.of_elements &= entry.of_elements
        return result

    def coordinates(self) -> Array:
        """Its points ``(n, 3)``."""
        return np.concatenate([np.zeros((0, 3)), *self.points])

    def numbered(self, what: str, first: int) -> Numbering:
        """Its nodes or elements by number; raises ``InputError`` for one given twice."""
        blocks = (
            self.nodes
            if what == "node"
            else [(where, block.ids) for where, block in self.elements]
        )
        ids = np.concatenate([np.zeros(0, np.int64), *(ids for _, ids in blocks)])
        found = Numbering(ids, first)
        if len(twice := found.twice()):
            ends = np.cumsum([len(ids) for _, ids in blocks])
            where = blocks[int(np.searchsorted(ends, twice[0], side="right"))][0]
            raise InputError(
                f"{where}: {what} {found.ids[twice[0]]} is defined twice; give each its own "
                "number, or write parts with *PART, *ASSEMBLY and *INSTANCE"
            )
        return found


def named(names: Names, name: str) -> Named:
    """The entry of a name, made if need be."""
    return names.setdefault(name.upper(), Named(name))


def number(word: str) -> float:
    """A number as Fortran writes it, too (1.5D+00); nothing at all is zero."""
    if not word.strip():
        return 0.0
    if "_" in word:
        raise ValueError(f"not a number: {word!r}")
    fortran = _FORTRAN.fullmatch(word.strip())
    return float(f"{fortran.group(1)}e{fortran.group(2)}" if fortran else word)


def _nodes(where: str, card: Card) -> tuple[Indices, Array]:
    rows = []
    for row in card.data:
        words = row.split(",")
        # A normal of three components may follow the coordinates; it is not read.
        require(
            not "".join(words[7:]).strip(),
            f"{where}: the line {row[:60]!r} has more than a node; write one node a line",
        )
        rows.append(words[:4])
    require(
        all(len(row) == 4 for row in rows),
        f"{where}: a node needs a number and three coordinates; of a blank one, which is zero, the "
        "comma must be there",
    )
    ids = numbers([row[0] for row in rows])
    try:
        points = [[float(word) for word in row[1:]] for row in rows]
    except ValueError:  # a blank, or an exponent of Fortran
        points = [[number(word) for word in row[1:]] for row in rows]
    X = np.array(points, dtype=np.float64).reshape(-1, 3)
    return ids, _cartesian(X, card.given.get("SYSTEM", "R").upper()[:1])


def _cartesian(given: Array, system: str) -> Array:
    """From radius, angle, Z, or radius, longitude, latitude, in degrees.

    ``X = r cos(phi) cos(theta), Y = r cos(phi) sin(theta), Z = r sin(phi)``.
    """
    if system == "R":
        return given
    r, theta, last = given.T
    theta = np.radians(theta)
    if system == "C":
        return np.stack([r * np.cos(theta), r * np.sin(theta), last], axis=1)
    phi = np.radians(last)
    flat = r * np.cos(phi)
    return np.stack([flat * np.cos(theta), flat * np.sin(theta), r * np.sin(phi)], axis=1)
