"""Elements of Abaqus: their types, and how their facets are numbered."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.abaqus_cards import Card

Indices = NDArray[np.int64]

_PLANE = r"(S|DS|M3D|SFM3D|R3D|CP[SE])"
#: Kind of an element and its number of nodes, by its type.
_READ = tuple(
    (re.compile(pattern), kind, nodes)
    for pattern, kind, nodes in (
        (r"D?C3D4\D*", "tetra", 4),
        (r"D?C3D10\D*", "tetra10", 10),
        (r"D?C3D8\D*", "hexahedron", 8),
        (r"D?C3D20\D*", "hexahedron20", 20),
        (r"D?C3D27\D*", "hexahedron27", 27),
        (_PLANE + r"3\D*|STRI3", "triangle", 3),
        (_PLANE + r"6\D*|STRI65", "triangle6", 6),
        (_PLANE + r"4\D*5?", "quad", 4),
        (_PLANE + r"8\D*5?", "quad8", 8),
        (_PLANE + r"9\D*5?", "quad9", 9),
    )
)
#: Lines that Gmsh writes for the curves of its model: no part of a body.
_CURVES = re.compile(r"T[23]D[23]\w*")
#: Elements without a volume that are left out, and said to be.
_LEFT_OUT = re.compile(r"(MASS|ROTARY|SPRING|DASHPOT|CONN|GAP|HEATCAP|JOINT|ITS|ITT|DRAG)\w*")
_SOLID_ONLY = "mesh the body again with tetrahedra or hexahedra"
_REMOVE = "remove them from the file, or their part"
#: What the elements of a type are that is refused, and the way out.
_REFUSED = tuple(
    (re.compile(pattern), what, way_out)
    for pattern, what, way_out in (
        (r"D?C3D(6|15)\w*", "wedges", _SOLID_ONLY),
        (r"D?C3D5\w*", "pyramids", _SOLID_ONLY),
        (r"COH\w*", "cohesive elements", "remove them and join the nodes on their two sides"),
        (r"GK\w*", "gasket elements", _SOLID_ONLY),
        (r"SC[68]\w*|CSS8\w*", "continuum shells", "write them as solid elements C3D8"),
        (r"(B[23]|PIPE|ELBOW|FRAME)\w*", "beams", _REMOVE),
        (r"CIN\w*|ACIN\w*", "infinite elements", _REMOVE),
        (r"AC[123AP]\w*|ASI\w*", "acoustic elements", _REMOVE),
        (r"EC3D8\w*", "Eulerian elements, which may be empty", "write them as C3D8"),
        (r"P[CD]3D\w*", "particles", _SOLID_ONLY),
        (r"CCL\w*", "cylindrical elements", _SOLID_ONLY),
        (r"(CAX|SAX|MAX|RAX|SFMAX|SAXA|CAXA|DSAX|DCAX|DC2D|MCL|SFMCL|MGAX|CGAX)\w*",
         "elements of an axisymmetric or plane model", "mesh the body in 3D"),
        (r"EMC\w*", "electromagnetic elements", _REMOVE),
        (r"F[23AC]\w*|FLINK", "elements of a fluid", _REMOVE),
        (r"R[23]D2|RB[23]D2", "rigid links", _REMOVE),
        (r"[UZ]\d+", "user elements or substructures", _REMOVE),
    )
)  # fmt: skip
#: The largest number of a node or an element.
LARGEST = np.iinfo(np.int64).max
#: Facets of an element by the number that ``*SURFACE`` calls them, S1 first, as local corners.
SURFACE_FACES = {
    "tetra": np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]),
    "hexahedron": np.array(
        [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
    ),
}


@dataclass(frozen=True)
class Elements:
    """Elements of one ``*ELEMENT`` line: ``ids (n,)`` and ``nodes (n, k)`` as in the file.

    Those of kind ``line`` are no part of a body, and their nodes are not kept.
    """

    name: str
    kind: str
    ids: Indices
    nodes: Indices

    @property
    def left_out(self) -> bool:
        """Whether a reader should hear that these are not read."""
        return self.kind == "line" and not _CURVES.fullmatch(self.name)


def numbers(words: list[str]) -> Indices:
    """Whole numbers of 64 bits; raises ``ValueError`` for anything else."""
    for word in words:
        if "_" in word or not word.isascii():  # Python reads 1_000 and digits of any script.
            raise ValueError(f"not a number: {word!r}")
    try:
        return np.array([int(word) for word in words], dtype=np.int64)
    except OverflowError:
        large = next(word for word in words if abs(int(word)) > LARGEST)
        raise ValueError(
            f"the number {large.strip()[:40]} is too large; they go up to {LARGEST}"
        ) from None


def elements_of(where: str, card: Card) -> Elements:
    """The elements of an ``*ELEMENT`` line; raises ``InputError`` for a type that is not read."""
    name = card.given["TYPE"].upper()
    for pattern, what, way_out in _REFUSED:
        if pattern.fullmatch(name):
            raise InputError(
                f"{where}: {len(card.data)} lines of elements of type {name} ({what}) are not "
                f"read: {way_out}"
            )
    if _CURVES.fullmatch(name) or _LEFT_OUT.fullmatch(name):
        ids = numbers([row.split(",")[0] for row in _starts(card.data)])
        return Elements(name, "line", ids, np.zeros((len(ids), 0), np.int64))
    kinds = [(kind, size) for pattern, kind, size in _READ if pattern.fullmatch(name)]
    if not kinds:
        raise InputError(
            f"{where}: element type {name!r} is unknown; allowed are tetrahedra C3D4, C3D10 or "
            "hexahedra C3D8, C3D20, C3D27, with surface elements such as S3, S4, CPS3, M3D4"
        )
    kind, size = kinds[0]
    words = card.words()
    require(
        size != 27 or len(words) % (size + 1) == 0,
        f"{where}: elements of type {name} with fewer than 27 nodes are not read: write all of "
        "them, or elements C3D20",
    )
    _refuse_other_counts(where, card.data, name, size)
    table = numbers(words).reshape(-1, size + 1)
    return Elements(name, kind, table[:, 0], table[:, 1:])


def facets_of(where: str, kind: str, nodes: Indices, label: str) -> tuple[str, Indices]:
    """Kind and nodes ``(n, k)`` of facet ``label`` (S1 ...) of elements.

    Surface elements are facets themselves.  Raises ``InputError`` for no such facet.
    """
    require(kind != "line", f"{where}: elements without a volume or area have no face {label!r}")
    faces = SURFACE_FACES.get(re.sub(r"\d+$", "", kind))
    if faces is None:
        require(
            not re.fullmatch(r"E\d", label.upper()),
            f"{where}: {label!r} are edges of surface elements, which are not read; name faces",
        )
        return kind, nodes
    wanted = re.fullmatch(r"S([1-6])", label.upper())
    if wanted is None or int(wanted.group(1)) > len(faces):
        raise InputError(
            f"{where}: elements of kind {kind} have no face {label!r}; allowed are "
            f"S1 to S{len(faces)}"
        )
    corners = nodes[:, faces[int(wanted.group(1)) - 1]]
    return ("triangle" if corners.shape[1] == 3 else "quad"), corners


def _starts(lines: list[str]) -> list[str]:
    """The lines that begin an element: those that no line with a comma at its end goes before."""
    before = ["", *lines[:-1]]
    return [line for line, last in zip(lines, before, strict=True) if not last.endswith(",")]


def _refuse_other_counts(where: str, lines: list[str], name: str, nodes: int) -> None:
    """Raises ``InputError`` for an element of another number of nodes, or with a blank one.

    An element may go on in the next line, but begins in one of its own.
    """
    begin = count = 0
    for k, line in enumerate(lines):
        words = line.rstrip(",").split(",")
        begin = k if count == 0 else begin
        count += len(words)
        require(
            all(word.strip() for word in words),
            f"{where}: the line {line[:60]!r} leaves a node of an element of type {name} blank; "
            f"write all {nodes} of them",
        )
        if count > nodes + 1:
            break
        count %= nodes + 1
    if count == 0:
        return
    # It is over where no comma says that it goes on.
    end = begin
    while lines[end].endswith(",") and end + 1 < len(lines):
        end += 1
    text = ",".join(line.rstrip(",") for line in lines[begin : end + 1])
    element, *its = text.split(",")
    way_out = "complete it, or correct the type"
    if len(its) > nodes:
        way_out = (
            "elements of an order above two are not read: save the mesh with order 1 or 2 (Gmsh: "
            "Mesh.ElementOrder), or correct the type"
        )
    raise InputError(
        f"{where}: elements of type {name} need {nodes} nodes and element {element.strip()[:20]} "
        f"has {len(its)}; {way_out}"
    )
