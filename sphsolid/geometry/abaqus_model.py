"""An Abaqus input file taken apart: its parts, its assembly, and the model they make."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.abaqus_cards import Card
from sphsolid.geometry.abaqus_elements import Elements
from sphsolid.geometry.abaqus_instances import moved
from sphsolid.geometry.abaqus_part import Part
from sphsolid.geometry.abaqus_scope import ElementTable, Scope
from sphsolid.geometry.file_content import SURFACE_CORNERS

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
_ENDS = {"PART": "END PART", "ASSEMBLY": "END ASSEMBLY", "INSTANCE": "END INSTANCE"}


@dataclass
class Instance:
    """A part put into the assembly, and what the instance adds to it."""

    where: str
    card: Card
    own: Part = field(default_factory=Part)


@dataclass
class Model:
    """Parts, instances by name, and the assembly, which is also a file that has no parts."""

    path: Path
    parts: dict[str, tuple[str, Part]] = field(default_factory=dict)
    instances: dict[str, Instance] = field(default_factory=dict)
    assembly: Part = field(default_factory=Part)
    assembly_name: str = ""
    #: Scopes that are open, by the keyword that began each.
    _open: list[tuple[str, Part]] = field(default_factory=list)

    def take(self, where: str, card: Card) -> None:
        """Add what a card says to the scope that it stands in."""
        name = card.given.get("NAME", "")
        if card.keyword == "PART":
            self._begin(where, card, Part(), within="")
            require(
                name.upper() not in self.parts, f"{where}: there is a part {name!r} before it"
            )
            self.parts[name.upper()] = (name, self._open[-1][1])
        elif card.keyword == "ASSEMBLY":
            self._begin(where, card, self.assembly, within="")
            self.assembly_name = name
        elif card.keyword == "INSTANCE":
            instance = Instance(where, card)
            self._begin(where, card, instance.own, within="ASSEMBLY")
            require(
                name.upper() not in self.instances,
                f"{where}: there is an instance {name!r} before it",
            )
            self.instances[name.upper()] = instance
        elif card.keyword in _ENDS.values():
            require(
                bool(self._open) and _ENDS[self._open[-1][0]] == card.keyword,
                f"{where}: there is nothing open that it ends",
            )
            self._open.pop()
        else:
            (self._open[-1][1] if self._open else self.assembly).take(where, card)

    def _begin(self, where: str, card: Card, part: Part, within: str) -> None:
        around = self._open[-1][0] if self._open else ""
        require(
            around == within,
            f"{where}: it stands in {f'*{around}' if around else 'no *ASSEMBLY'}; wanted: "
            f"{'within *ASSEMBLY' if within else 'outside of any part or assembly'}",
        )
        self._open.append((card.keyword, part))

    def scopes(self) -> tuple[Scope, Array, ElementTable]:
        """The assembly with its instances, all points, and all elements.

        Raises ``InputError`` for parts or an assembly without their end, parts without a place,
        numbers given twice and elements of nodes that there are not.
        """
        if self._open:
            raise InputError(
                f"{self.path} is truncated: *{self._open[-1][0]} has no *{_ENDS[self._open[-1][0]]}"
                "; copy or write it again"
            )
        placed: list[tuple[str, Part, Array]] = []
        for instance in self.instances.values():
            placed.append(self._placed(instance))
        if self.parts and not self.instances:
            require(
                len(self.parts) == 1,
                f"{self.path} has {len(self.parts)} parts and no *INSTANCE that says where they "
                "stand; write it with its assembly",
            )
            placed = [(name, part, part.coordinates()) for name, part in self.parts.values()]
        placed.append(("", self.assembly, self.assembly.coordinates()))
        inner: dict[str, Scope] = {}
        table = ElementTable([], [], np.zeros(0, np.int64), np.zeros(0, np.int64))
        nodes = elements = 0
        for name, part, points in placed:
            scope = Scope(
                name,
                part,
                part.numbered("node", nodes),
                part.numbered("element", elements),
                {} if name else inner,
                "" if name else self.assembly_name,
            )
            nodes, elements = nodes + len(points), elements + len(scope.elements)
            for where, block in part.elements:
                table.kinds.append(block.kind)
                table.nodes.append(_places(where, scope, block))
            if name:
                inner[name.upper()] = scope
        sizes = [len(block) for block in table.nodes]
        zero = [np.zeros(0, np.int64)]
        table = ElementTable(
            table.kinds,
            table.nodes,
            np.repeat(np.arange(len(sizes)), sizes),
            np.concatenate([*zero, *(np.arange(size) for size in sizes)]),
        )
        return scope, np.concatenate([points for _, _, points in placed]), table

    def _placed(self, instance: Instance) -> tuple[str, Part, Array]:
        given = instance.card.given
        require(
            given["PART"].upper() in self.parts,
            f"{instance.where}: there is no part {given['PART']!r}; the parts are "
            f"{sorted(name for name, _ in self.parts.values())}",
        )
        require(
            not (instance.card.data and instance.own.elements),
            f"{instance.where}: it has elements of its own and is moved, too, which is not read: "
            "put its mesh into the part (in Abaqus/CAE: make the instance dependent)",
        )
        part = self.parts[given["PART"].upper()][1].joined(instance.own)
        points = moved(instance.where, instance.card, part.coordinates())
        return given["NAME"], part, points


def refuse_structures(path: Path, model: list[Part], table: ElementTable, points: int) -> None:
    """Raises ``InputError`` for surface elements with corners that no cell of the body has.

    Surface elements name parts of the boundary; others are shells, membranes or rigid tools.
    """
    names = [block.name for part in model for _, block in part.elements]
    blocks = list(zip(names, table.kinds, table.nodes, strict=True))
    body = np.zeros(points, dtype=bool)
    for _, kind, nodes in blocks:
        if kind not in SURFACE_CORNERS:
            body[nodes] = True
    if not body.any():
        return
    apart: dict[str, int] = {}
    for name, kind, nodes in blocks:
        if kind in SURFACE_CORNERS:
            count = int((~body[nodes[:, : SURFACE_CORNERS[kind]]]).any(axis=1).sum())
            if count:
                apart[name] = apart.get(name, 0) + count
    require(
        not apart,
        f"{path}: {', '.join(f'{n} elements {name}' for name, n in apart.items())} are no facets "
        "of the solid body: shells, membranes and rigid surfaces of their own are not read; "
        "remove them from the file, or their part",
    )


def _places(where: str, scope: Scope, block: Elements) -> Indices:
    """Where the nodes of elements stand in the list of points."""
    found = scope.nodes.find(block.nodes)
    lost = found < 0
    if np.any(lost):
        first = int(np.argmax(lost.any(axis=1)))
        of = f" of instance {scope.name!r}" if scope.name else ""
        raise InputError(
            f"{where}: elements use {len(np.unique(block.nodes[lost]))} nodes that are not "
            f"defined; the first is node {block.nodes[first][lost[first]][0]} of element "
            f"{block.ids[first]}{of}: add it to the *NODE lines, or take the element out"
        )
    return found
