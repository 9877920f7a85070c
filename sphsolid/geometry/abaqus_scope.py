"""Sets and surfaces of a part by the places of their members in the whole model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.abaqus_cards import Card, fields
from sphsolid.geometry.abaqus_elements import facets_of, numbers
from sphsolid.geometry.abaqus_part import Named, Part, number
from sphsolid.geometry.facets import cell_facets, same_vertices
from sphsolid.geometry.file_content import BODY_CELLS, SURFACE_CORNERS
from sphsolid.geometry.numbering import Numbering

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class ElementTable:
    """All elements of a model: ``kinds`` and ``nodes`` of each block of them.

    ``block (e,)`` and ``row (e,)``: where an element stands.
    """

    kinds: list[str]
    nodes: list[Indices]
    block: Indices
    row: Indices

    def blocks(self, elements: Indices) -> Iterator[tuple[str, Indices]]:
        """Kind and nodes ``(n, k)`` of some elements, block by block."""
        order = np.argsort(self.block[elements], kind="stable")
        elements = elements[order]
        starts = np.flatnonzero(np.diff(self.block[elements], prepend=-1))
        for part in np.split(elements, starts[1:]) if len(elements) else []:
            block = int(self.block[part[0]])
            yield self.kinds[block], self.nodes[block][self.row[part]]

    def exposed(self, elements: list[Indices]) -> list[tuple[str, Indices]]:
        """Kind and nodes ``(n, k)`` of facets that no second element of the model has.

        Surface elements are facets themselves, whatever lies behind them.
        """
        if not elements:
            return []
        members = np.unique(np.concatenate(elements))
        found = [
            (kind, nodes) for kind, nodes in self.blocks(members) if kind in SURFACE_CORNERS
        ]
        for kind in ("triangle", "quad"):
            loops, owner = self._facets(SURFACE_CORNERS[kind])
            number = same_vertices(loops)
            free = (np.bincount(number)[number] == 1) & np.isin(owner, members)
            if free.any():
                found.append((kind, loops[free]))
        return found

    def _facets(self, corners: int) -> tuple[Indices, Indices]:
        """Facets ``(n, corners)`` of all elements of a volume, and whose they are ``(n,)``."""
        loops, owner = [np.zeros((0, corners), np.int64)], [np.zeros(0, np.int64)]
        first = 0
        for kind, nodes in zip(self.kinds, self.nodes, strict=True):
            shape = BODY_CELLS.get(kind)
            if shape is not None and shape.facets.shape[1] == corners:
                loops.append(cell_facets(nodes[:, : shape.corners], shape))
                places = np.arange(first, first + len(nodes))
                owner.append(np.repeat(places, len(shape.facets)))
            first += len(nodes)
        return np.concatenate(loops), np.concatenate(owner)


@dataclass
class Scope:
    """A part at its place in the model, or the assembly with its ``instances``.

    ``name`` is that of the instance.  A set is resolved when it is first asked for, so it may
    be used before it is defined.  Places count the nodes and elements of the whole model.
    """

    name: str
    part: Part
    nodes: Numbering
    elements: Numbering
    instances: Mapping[str, Scope] = field(default_factory=dict)
    assembly: str = ""
    _sets: dict[tuple[str, str], Indices] = field(default_factory=dict)
    _open: list[tuple[str, str]] = field(default_factory=list)

    def members(self, kind: str, name: str, table: ElementTable) -> Indices:
        """Places ``(k,)``, each once, of the set ``name`` of ``kind`` NSET or ELSET.

        Raises ``InputError`` for sets and members that are not defined, and for one that contains
        itself.
        """
        key = (kind, name.upper())
        if key not in self._sets:
            entry = self._names(kind)[key[1]]
            require(
                key not in self._open,
                f"{entry.cards[0][0] if entry.cards else kind}: the set {name!r} contains itself",
            )
            self._open.append(key)
            numbering = self._numbering(kind)
            parts = [numbering.find(ids) for ids in entry.numbers]
            parts += [self._said(kind, where, card, table) for where, card in entry.cards]
            self._open.remove(key)
            self._sets[key] = np.unique(np.concatenate([np.zeros(0, np.int64), *parts]))
        return self._sets[key]

    def surface(self, entry: Named, table: ElementTable) -> list[tuple[str, Indices]]:
        """Kinds and nodes of the facets of a surface of elements.

        A line without a face means the exposed faces of its elements.
        """
        facets: list[tuple[str, Indices]] = []
        exposed: list[Indices] = []
        for where, card in entry.cards:
            for row in card.data:
                region, label, *more = [*fields(row), ""]
                _refuse_more(where, row, more, "an element set and a face")
                elements = self._find(self, "ELSET", where, [region], table)
                if label:
                    facets += [facets_of(where, *block, label) for block in table.blocks(elements)]
                else:
                    exposed.append(elements)
        return facets + table.exposed(exposed)

    def node_surface(self, entry: Named, table: ElementTable) -> Indices:
        """Nodes of a surface of nodes; each line names a set or a node first."""
        parts = []
        for where, card in entry.cards:
            for row in card.data:
                region, area, *more = [*fields(row), ""]
                try:
                    number(area)
                except ValueError:
                    more = [area]
                _refuse_more(where, row, more, "a node set and an area")
                parts.append(self._find(self, "NSET", where, [region], table))
        return np.unique(np.concatenate([np.zeros(0, np.int64), *parts]))

    def _names(self, kind: str) -> dict[str, Named]:
        return self.part.nsets if kind == "NSET" else self.part.elsets

    def _numbering(self, kind: str) -> Numbering:
        return self.nodes if kind == "NSET" else self.elements

    def _said(self, kind: str, where: str, card: Card, table: ElementTable) -> Indices:
        """What one card puts into a set."""
        scope = self
        if name := card.given.get("INSTANCE"):
            require(
                name.upper() in self.instances,
                f"{where}: there is no instance {name!r}; the instances are "
                f"{sorted(other.name for other in self.instances.values())}",
            )
            scope = self.instances[name.upper()]
        if "GENERATE" in card.given:
            parts = [scope._numbering(kind).between(*_range(where, row)) for row in card.data]
        else:
            parts = [self._find(scope, kind, where, card.words(), table)]
        if "ELSET" in card.given and kind == "NSET":
            elements = self._find(scope, "ELSET", where, [card.given["ELSET"]], table)
            parts += [nodes.ravel() for _, nodes in table.blocks(elements)]
        return np.concatenate([np.zeros(0, np.int64), *parts])

    def _find(
        self, scope: Scope, kind: str, where: str, words: list[str], table: ElementTable
    ) -> Indices:
        """Places of numbers, and of the members of sets."""
        plain = [word for word in words if _is_number(word)]
        parts = []
        if plain:
            wanted = _whole(where, plain)
            found = scope._numbering(kind).find(wanted)
            if np.any(found < 0):
                what = "nodes" if kind == "NSET" else "elements"
                raise InputError(
                    f"{where}: the set has {np.sum(found < 0)} members that are no {what} of "
                    f"{scope._called()}, the first of them number {wanted[found < 0][0]}"
                    + ("; say which INSTANCE= they are of" if scope.instances else "")
                )
            parts.append(found)
        for word in words:
            if not _is_number(word):
                owner, name = self._owner(scope, kind, where, word)
                parts.append(
                    owner._find(owner, kind, where, [name], table)
                    if _is_number(name)
                    else owner.members(kind, name, table)
                )
        return np.concatenate([np.zeros(0, np.int64), *parts])

    def _owner(self, scope: Scope, kind: str, where: str, word: str) -> tuple[Scope, str]:
        """The scope of ``P-1.top`` and the name or number in it."""
        if word.upper() in scope._names(kind):
            return scope, word
        for k, letter in enumerate(word):
            prefix, name = word[:k].strip().upper(), word[k + 1 :].strip()
            if letter != ".":
                continue
            if prefix == self.assembly.upper() != "":
                return self._owner(self, kind, where, name)
            inner = self.instances.get(prefix)
            if inner is not None and (_is_number(name) or name.upper() in inner._names(kind)):
                return inner, name
        names = sorted(entry.name for entry in scope._names(kind).values())
        names += sorted(
            f"{inner.name}.{entry.name}"
            for inner in scope.instances.values()
            for entry in inner._names(kind).values()
        )
        raise InputError(
            f"{where}: set {word!r} is not defined; the sets of {scope._called()} are {names}"
        )

    def _called(self) -> str:
        if self.name:
            return f"instance {self.name!r}"
        return "the assembly" if self.instances else "the file"


def _is_number(word: str) -> bool:
    """Digits of ASCII: there are others, which are no numbers, such as a superscript."""
    return word.isascii() and word.isdigit()


def _whole(where: str, words: list[str]) -> Indices:
    try:
        return numbers(words)
    except ValueError as error:
        raise InputError(f"{where}: {error}") from error


def _refuse_more(where: str, row: str, more: list[str], wanted: str) -> None:
    """Raises ``InputError`` where a line of a surface goes on: what follows is not read."""
    require(
        not any(more),
        f"{where}: the line {row[:60]!r} has more than {wanted}; write one such pair a line",
    )


def _range(where: str, row: str) -> tuple[int, int, int]:
    words = [word for word in fields(row) if word]
    require(
        len(words) in (2, 3) and all(map(_is_number, words)),
        f"{where}: GENERATE needs first, last, step, got {row[:60]!r}",
    )
    low, high, step = (*_whole(where, words).tolist(), 1)[:3]
    require(
        step > 0 and high >= low, f"{where}: GENERATE from {low} to {high} by {step} gives nothing"
    )
    return low, high, step
