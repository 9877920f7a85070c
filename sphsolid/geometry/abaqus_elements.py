"""Elements of Abaqus: their types, and how their facets are numbered."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.abaqus_cards import Card
from sphsolid.geometry.file_content import SURFACE_CORNERS

Indices = NDArray[np.int64]

_PLANE = r"(S|DS|M3D|SFM3D|R3D|CP[SE]|CAX)"
#: Kind of an element and its number of nodes, by its type.
ELEMENTS = tuple(
    (re.compile(pattern), kind, nodes)
    for pattern, kind, nodes in (
        (r"D?C3D4\D*", "tetra", 4),
        (r"D?C3D10\D*", "tetra10", 10),
        (r"D?C3D8\D*", "hexahedron", 8),
        (r"D?C3D20\D*", "hexahedron20", 20),
        (r"D?C3D27\D*", "hexahedron27", 27),
        (r"D?C3D6\D*", "wedge", 6),
        (r"D?C3D15\D*", "wedge15", 15),
        (r"D?C3D5\D*", "pyramid", 5),
        (_PLANE + r"3\D*|STRI3", "triangle", 3),
        (_PLANE + r"6\D*|STRI65", "triangle6", 6),
        (_PLANE + r"4\D*5?", "quad", 4),
        (_PLANE + r"8\D*5?", "quad8", 8),
        (_PLANE + r"9\D*5?", "quad9", 9),
        (r"(T2D|T3D|B|MASS|ROTARY|SPRING|DASHPOT|CONN)\w*", "line", 0),
    )
)
#: Facets of an element by the number that ``*SURFACE`` calls them, S1 first, as local corners.
SURFACE_FACES = {
    "tetra": np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]),
    "hexahedron": np.array(
        [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
    ),
}


@dataclass(frozen=True)
class Elements:
    """Elements of one ``*ELEMENT`` line: ``ids (n,)`` and ``nodes (n, k)`` as in the file."""

    kind: str
    ids: Indices
    nodes: Indices

    def facets(self, where: str, ids: Indices, label: str) -> list[tuple[str, Indices]]:
        """Kind and nodes of facet ``label`` (S1 ...) of those that ``ids`` holds, if any.

        Surface elements are facets themselves.  Raises ``InputError`` for no such facet.
        """
        nodes = self.nodes[np.isin(self.ids, ids)]
        if len(nodes) == 0:
            return []
        if self.kind in SURFACE_CORNERS:
            return [(self.kind, nodes)]
        faces = SURFACE_FACES.get(re.sub(r"\d+$", "", self.kind), np.zeros((0, 3), int))
        wanted = re.fullmatch(r"S([1-6])", label.upper())
        if wanted is None or int(wanted.group(1)) > len(faces):
            raise InputError(
                f"{where}: elements of kind {self.kind} have no face {label!r}; allowed are "
                f"S1 to S{len(faces)}"
            )
        corners = nodes[:, faces[int(wanted.group(1)) - 1]]
        return [("triangle" if corners.shape[1] == 3 else "quad", corners)]


def elements_of(where: str, card: Card) -> Elements:
    """The elements of an ``*ELEMENT`` line; raises ``InputError`` for an unknown type."""
    name = card.given.get("TYPE", "")
    kinds = [(kind, size) for pattern, kind, size in ELEMENTS if pattern.fullmatch(name)]
    if not kinds:
        raise InputError(
            f"{where}: element type {name!r} is unknown; allowed are tetrahedra C3D4, C3D10 or "
            "hexahedra C3D8, C3D20, C3D27, with surface elements such as S3, S4, CPS3, M3D4"
        )
    kind, size = kinds[0]
    if kind == "line":
        ids = np.array([int(row.split(",")[0]) for row in card.data], dtype=np.int64)
        return Elements(kind, ids, np.zeros((len(ids), 0), np.int64))
    words = card.words()
    if len(words) % (size + 1):
        raise InputError(
            f"{where}: {len(words)} numbers do not make elements of type {name}, which have "
            f"{size} nodes; the file is truncated or damaged"
        )
    table = np.array([int(word) for word in words], dtype=np.int64).reshape(-1, size + 1)
    return Elements(kind, table[:, 0], table[:, 1:])
