"""Abaqus ``.inp`` files: nodes, elements and what gives facets a name.

Read here and not through meshio, which knows no ``*SURFACE``, refuses surface elements of second
order, loses sets that are given in parts, and gives some the elements of others.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.abaqus_cards import Card, read_cards
from sphsolid.geometry.abaqus_keywords import understood
from sphsolid.geometry.abaqus_model import Model, refuse_structures
from sphsolid.geometry.abaqus_scope import ElementTable, Scope
from sphsolid.geometry.abaqus_skipped import NOT_READ_BUT_SAID
from sphsolid.geometry.file_content import (
    BODY_CELLS,
    SURFACE_CORNERS,
    Block,
    FileContent,
    NamedSet,
)

Indices = NDArray[np.int64]
Rows = list[tuple[str, Indices]]


def read_abaqus(path: Path) -> FileContent:
    """Nodes, elements and names of an ``.inp`` file.

    Names: each element-based ``*SURFACE``, each ``*ELSET`` with surface elements (shells,
    membranes, plane elements), and, where neither names a surface element, the ``ELSET`` of its
    ``*ELEMENT`` line; ``*NSET`` and surfaces of nodes by their nodes.  Which of them become tags
    is settled in :mod:`~sphsolid.geometry.named_sets`.  Sets may be given in
    parts, by numbers, ``GENERATE`` or other sets, before or after those.  Names of a part are
    those of the file where it has one instance, else ``INSTANCE.NAME``.  What is read of each
    keyword stands in ``abaqus_keywords``.  Raises ``InputError``, with the line, for what is
    malformed, for keywords, parameters and element types that are not read and change the mesh,
    and for numbers given twice.
    """
    file = read_cards(path)
    require(len(file.cards) > 0, f"{path} is not an Abaqus input file: it has no *KEYWORD lines")
    model = Model(path)
    last: Card | None = None
    skipped: dict[str, str] = {}
    for card in file.cards:
        where = f"{path}, line {card.line}, *{card.keyword}"
        try:
            last = understood(where, card)
            if last is not None:
                model.take(where, last)
            elif card.keyword in NOT_READ_BUT_SAID:
                skipped[card.keyword] = NOT_READ_BUT_SAID[card.keyword]
        except InputError as error:
            if file.unended and card is file.cards[-1]:
                raise _cut(path, file.lines) from error
            raise
        except ValueError as error:
            raise InputError(
                f"{where}: its parameters or data cannot be read ({error}); numbers are wanted, "
                "with commas between them"
            ) from error
    scope, points, table = model.scopes()
    if file.unended and last is not None:
        _refuse_cut(path, file.lines, last, points, table)
    parts = [inner.part for inner in (*scope.instances.values(), scope)]
    refuse_structures(path, parts, table, len(points))
    notes = [f"*{keyword} is not read: {what}" for keyword, what in skipped.items()]
    left_out: dict[str, int] = {}
    for part in parts:
        for _, block in part.elements:
            if block.left_out:
                left_out[block.name] = left_out.get(block.name, 0) + len(block.ids)
    notes += [f"{n} elements {name} are not read" for name, n in left_out.items()]
    return FileContent(
        points,
        _blocks([row for row in zip(table.kinds, table.nodes, strict=True) if row[0] != "line"]),
        {},
        tuple(_sets(scope, table)),
        notes=tuple(f"{path}: {note}" for note in notes),
        way_out="mesh it in 3D with elements such as C3D8 or C3D4, and write them into this file",
    )


def _sets(root: Scope, table: ElementTable) -> list[NamedSet]:
    """Surfaces, sets with surface elements, and node sets, in the order that they are met in."""
    found: list[NamedSet] = []
    named = np.zeros(len(table.block), dtype=bool)
    surface = np.array([kind in SURFACE_CORNERS for kind in table.kinds], dtype=bool)
    flat = surface[table.block]
    scopes = (*root.instances.values(), root)
    for scope in scopes:
        for entry in scope.part.surfaces.values():
            facets = _blocks(scope.surface(entry, table))
            label = _label(root, scope, entry.name)
            found.append(NamedSet(label, "surface", facets, internal=entry.internal))
    for of_elements in (False, True):
        for scope in scopes:
            for key, entry in scope.part.elsets.items():
                if entry.of_elements != of_elements:
                    continue
                members = scope.members("ELSET", key, table)
                members = members[flat[members]]
                if of_elements:
                    members = members[~named[members]]
                else:
                    named[members] = True
                if len(members):
                    facets = _blocks([*table.blocks(members)])
                    label = _label(root, scope, entry.name)
                    found.append(NamedSet(label, "element set", facets, internal=entry.internal))
    return found + _node_sets(root, table)


def _node_sets(root: Scope, table: ElementTable) -> list[NamedSet]:
    found: list[NamedSet] = []
    for scope in (*root.instances.values(), root):
        sets = [
            (entry, "node set", scope.members("NSET", key, table))
            for key, entry in scope.part.nsets.items()
        ]
        sets += [
            (entry, "surface of nodes", scope.node_surface(entry, table))
            for entry in scope.part.node_surfaces.values()
        ]
        found += [
            NamedSet(_label(root, scope, entry.name), kind, (), points, entry.internal)
            for entry, kind, points in sets
        ]
    return found


def _label(root: Scope, scope: Scope, name: str) -> str:
    """The tag of a name: with that of its instance where a name alone could mean two things."""
    part = root.part
    kinds = (part.nsets, part.elsets, part.surfaces, part.node_surfaces)
    taken = any(name.upper() in names for names in kinds)
    alone = len(root.instances) == 1 and not taken
    return name if scope is root or alone else f"{scope.name}.{name}"


def _refuse_cut(
    path: Path, line: int, last: Card, points: NDArray[np.float64], table: ElementTable
) -> None:
    """Raises ``InputError`` where a file without a last line break may have been cut.

    The last of some elements is whole, and the file with it, where every node is used.  A number
    of a node or a set may have had more digits.
    """
    used = np.zeros(len(points), dtype=bool)
    for kind, nodes in zip(table.kinds, table.nodes, strict=True):
        used[nodes] = kind in BODY_CELLS or used[nodes]
    if last.keyword == "ELEMENT" and last.data and not used.all():
        raise _cut(path, line)
    if last.keyword in ("NODE", "NSET", "ELSET") or not (last.data or "END" in last.keyword):
        raise InputError(
            f"{path}: line {line}, the last one, has no line break, and a file that was cut there "
            "would look the same; end it with a line break if it is complete"
        )


def _cut(path: Path, line: int) -> InputError:
    return InputError(
        f"{path} is truncated: it ends in the middle of line {line}; copy or write it again, or "
        "end it with a line break if it is complete"
    )


def _blocks(rows: Rows) -> tuple[Block, ...]:
    return tuple(Block(kind, nodes) for kind, nodes in rows)
