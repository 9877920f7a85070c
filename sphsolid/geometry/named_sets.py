"""Which sets of a file become tags, where sets may overlap and tags may not.

A tag is all facets that its name stands for, or it is no tag: one that has lost some would hold
or load less than its name says.  So a set that shares facets with a tag is left out whole, and
refused by its name when it is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.file_content import NamedSet
from sphsolid.geometry.mesh_defects import place
from sphsolid.geometry.node_set_faces import NodeSetFaces

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: A note names so many, and says how many more there are.
NAMED_AT_MOST = 6


class Owners:
    """The tag of each facet ``boundary (f, m)``: ``of (f,)`` counts ``names``, -1 for none."""

    def __init__(self, file: str, vertices: Array, boundary: Indices) -> None:
        self.file = file
        self.vertices = vertices
        self.boundary = boundary
        self.of = np.full(len(boundary), -1)
        self.names: list[str] = []
        self.unusable: dict[str, str] = {}
        self._given: list[Indices] = []
        self._kinds: list[str] = []
        self._notes: dict[str, list[str]] = {}

    def give(self, name: str, rows: Indices, kind: str = "tag") -> None:
        """Make a tag of some facets ``rows (k,)`` that are free."""
        self.of[rows] = len(self.names)
        self.names.append(name)
        self._given.append(rows)
        self._kinds.append(kind)

    def shared_with(self, rows: Indices) -> Indices:
        """Those of the facets that the first tag among their owners has."""
        taken = rows[self.of[rows] >= 0]
        return taken[self.of[taken] == self.of[taken[0]]] if len(taken) else taken

    def faces(self) -> dict[str, Indices]:
        """Tag -> facets ``(k, m)``."""
        order = np.argsort(self.of, kind="stable")
        starts = np.searchsorted(self.of[order], np.arange(len(self.names) + 1))
        return {
            name: self.boundary[order[starts[k] : starts[k + 1]]]
            for k, name in enumerate(self.names)
        }

    def settle(self, sets: Sequence[NamedSet], facets: Mapping[int, Indices]) -> None:
        """Make tags of sets: surfaces first, then sets of nodes, internal ones last of all.

        ``facets``: of each set of facets, by its ``id``, their rows.  A set of nodes stands for
        the facets of :class:`~sphsolid.geometry.node_set_faces.NodeSetFaces`.  Within a rank
        that which comes first in the file is a tag.  A name of two sets that differ is no tag.
        """
        meanings: dict[str, list[tuple[NamedSet, Indices]]] = {}
        for each, rows in self._rows(sets, facets):
            meanings.setdefault(each.name, []).append((each, rows))
        ranked = sorted(
            meanings,
            key=lambda name: min(
                (each.internal, each.points is not None) for each, _ in meanings[name]
            ),
        )
        for name in ranked:
            (one, rows), *others = meanings[name]
            differ = [
                (each, its) for each, its in others if not self._same(one, rows, each, its)
            ]
            if differ:
                other, its = differ[0]
                self._leave_out(
                    name,
                    f"{name!r} names two things of different facets, {one.kind} ({len(rows)} "
                    f"facets) and {other.kind} ({len(its)}); give each a name of its own",
                    "names of two things of different facets, which cannot be used",
                    f"{name!r} ({one.kind}, {other.kind})",
                )
            else:
                self._settle(one, rows)

    def _same(self, one: NamedSet, rows: Indices, other: NamedSet, its: Indices) -> bool:
        """Whether two sets have the same facets, or one of nodes has all those of the other.

        At an edge of a coarse mesh nodes alone do not tell which facets are meant.
        """
        if np.array_equal(np.sort(rows), np.sort(its)):
            return True
        if one.points is None and other.points is None:
            return False
        return np.array_equal(self._nodes(one, rows), self._nodes(other, its))

    def _nodes(self, each: NamedSet, rows: Indices) -> Indices:
        return np.unique(self.boundary[rows] if each.points is None else each.points)

    def _settle(self, each: NamedSet, rows: Indices) -> None:
        name, kind = each.name, each.kind
        shared = self.shared_with(rows)
        if len(shared) == 0:
            self.give(name, rows, kind)
            return
        k = int(self.of[shared[0]])
        other, its = self.names[k], f"{self._kinds[k]} {self.names[k]!r}"
        if self._same(each, rows, NamedSet(other, self._kinds[k]), self._given[k]):
            self._leave_out(
                name,
                f"{kind} {name!r} has the facets of {its}, and a facet can have one tag; use "
                f"the name {other!r}",
                "second names of the facets of a tag, which go by the first",
                f"{name!r} ({other!r})",
            )
            return
        self._leave_out(
            name,
            f"{kind} {name!r} cannot be used: it shares {len(shared)} of its {len(rows)} facets, "
            f"the first at {place(self.vertices[self.boundary[shared[0]]])}, with {its}, and a "
            "facet can have one tag; take them out of one of the two in the file, or remove "
            f"{other!r} from it if nothing needs that",
            "sets that share facets with a tag, which cannot be used",
            f"{name!r} ({len(shared)} of {len(rows)} facets with {other!r})",
        )

    def _rows(
        self, sets: Sequence[NamedSet], facets: Mapping[int, Indices]
    ) -> list[tuple[NamedSet, Indices]]:
        """The sets that are a part of the boundary, and which; why the others are none."""
        found = []
        outer = np.zeros(len(self.vertices), dtype=bool)
        outer[self.boundary] = True
        all_of_them = int(outer.sum())
        faces: NodeSetFaces | None = None
        for each in sets:
            if each.points is None:
                found.append((each, facets[id(each)]))
                continue
            nodes = np.unique(each.points)
            faces = faces or NodeSetFaces(self.vertices, self.boundary)
            inside = int((~outer[nodes]).sum())
            if inside or len(nodes) == all_of_them:
                self._pass_over(
                    each,
                    f"{inside} of its {len(nodes)} vertices lie inside the body"
                    if inside
                    else "it has all vertices of the boundary",
                )
            elif len(rows := faces.of(nodes)):
                found.append((each, rows))
            else:
                self._pass_over(each, "it has all vertices of no facet")
        return found

    def _pass_over(self, each: NamedSet, why: str) -> None:
        self.unusable.setdefault(
            each.name, f"{self.file}: {each.kind} {each.name!r} is no part of the boundary: {why}"
        )

    def _leave_out(self, name: str, why: str, note: str, entry: str) -> None:
        self.unusable[name] = f"{self.file}: {why}"
        self._notes.setdefault(note, []).append(entry)

    def notes(self) -> tuple[str, ...]:
        """A line for each reason why names are no tags, with the first names."""
        return tuple(
            f"{self.file}: {note}: {', '.join(entries[:NAMED_AT_MOST])}"
            + (f" and {len(entries) - NAMED_AT_MOST} more" if entries[NAMED_AT_MOST:] else "")
            for note, entries in self._notes.items()
        )
