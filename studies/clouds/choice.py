"""Clouds of the unit cube by name: ``lattice``, ``jitter:J``, ``tet``, ``hex:FILE`` and more.

``scattered:J`` has the particles of ``jitter:J`` as bare points in a surface, without the cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from sphsolid.errors import InputError, require
from sphsolid.geometry import Box, HexMesh, MeshFile, PointCloud, Surface, TetBox, TetMesh
from sphsolid.geometry.body import AS_MESHED, Body, Spacing
from sphsolid.geometry.point_file import read_points
from sphsolid.geometry.refine import Refined
from studies.engine.sources import ROOT

KINDS = "lattice, jitter:J, tet, scattered:J, hex:FILE, tet:FILE, points:FILE[,SURFACE]"
TAGS = ("X+", "X-", "Y+", "Y-", "Z+", "Z-")
_TOLERANCE = 1.0e-6


@dataclass(frozen=True)
class Instance:
    """A cloud at one level: the body, the spacing to ask of it, the nominal one of its mesh."""

    body: Body
    spacing: Spacing
    h: float


@dataclass(frozen=True)
class Generated:
    """A cube that can be made at any spacing; ``jitter`` as of ``Box``, or tetrahedra."""

    jitter: float = 0.0
    tetrahedra: bool = False

    def levels(self, finest: int) -> list[int]:
        """Cells along an edge: 4, 8, ... up to ``finest``."""
        return [cells for cells in (4, 8, 16, 32, 64) if cells <= finest]

    def at(self, level: int) -> Instance:
        """The cube at ``1 / level``."""
        body = TetBox() if self.tetrahedra else Box(jitter=self.jitter)
        return Instance(body, 1.0 / level, 1.0 / level)

    def cells(self, level: int) -> float:
        """Cells along an edge."""
        return float(level)


@dataclass(frozen=True)
class Scattered:
    """The particles of a disordered cube without its cells: positions in a surface."""

    jitter: float

    def levels(self, finest: int) -> list[int]:
        """Cells along an edge, as of :class:`Generated`."""
        return Generated(self.jitter).levels(finest)

    def at(self, level: int) -> Instance:
        """The points at ``1 / level``."""
        mesh = Box(jitter=self.jitter).mesh(1.0 / level)
        inner = np.ones(len(mesh.vertices), dtype=bool)
        inner[mesh.boundary] = False
        surface = Surface.closed(vertices=mesh.vertices, faces=mesh.faces)
        return Instance(PointCloud(mesh.vertices[inner], surface), AS_MESHED, 1.0 / level)

    def cells(self, level: int) -> float:
        """Spacings along an edge."""
        return float(level)


@dataclass(frozen=True)
class Filed:
    """A cube from a mesh file, and its uniform refinements."""

    path: str

    @cached_property
    def h(self) -> float:
        """Nominal spacing of the file [m]."""
        return MeshFile(_found(self.path)).mesh(AS_MESHED).spacing

    def levels(self, finest: int) -> list[int]:
        """Refinements, as long as the spacing is at least about ``1 / finest``."""
        return [k for k in range(7) if k == 0 or self.h / 2**k >= 0.85 / finest]

    def at(self, level: int) -> Instance:
        """The file refined ``level`` times."""
        body = Refined(MeshFile(_found(self.path)), level)
        return Instance(body, AS_MESHED, self.h / 2**level)

    def cells(self, level: int) -> float:
        """Spacings along an edge."""
        return 2**level / self.h


@dataclass(frozen=True)
class Bare:
    """Points in a file and the closed surface around them: one level."""

    points: str
    surface: str = ""

    @cached_property
    def body(self) -> PointCloud:
        """The cloud; without a surface file the cube's faces are cut at the points' spacing."""
        around = (
            Surface.read(_found(self.surface))
            if self.surface
            else cube_surface(_along_an_edge(read_points(_found(self.points))))
        )
        return PointCloud(_found(self.points), around)

    def levels(self, finest: int) -> list[int]:
        """The one there is."""
        return [0]

    def at(self, level: int) -> Instance:
        """The cloud as it is."""
        return Instance(self.body, AS_MESHED, self.body.mesh(AS_MESHED).spacing)

    def cells(self, level: int) -> float:
        """Spacings along an edge."""
        return 1.0 / self.body.mesh(AS_MESHED).spacing


Cloud = Generated | Scattered | Filed | Bare


def cloud_of(text: str) -> Cloud:
    """The cloud that ``text`` names; raises ``InputError`` for a bad name, file or body."""
    kind, _, rest = text.partition(":")
    where = f"--cloud {text!r}"
    if kind in ("lattice", "tet") and ":" not in text:
        return Generated(tetrahedra=kind == "tet")
    if kind == "jitter":
        return Generated(jitter=_amount(where, rest))
    if kind == "scattered":
        return Scattered(_amount(where, rest))
    if kind in ("hex", "tet"):
        require(rest != "", f"{where}: a file is wanted after {kind}:")
        filed = Filed(rest)
        _check_cube(where, MeshFile(_found(rest)), HexMesh if kind == "hex" else TetMesh)
        return filed
    if kind == "points":
        names = [name.strip() for name in rest.split(",")]
        require(
            names[0] != "" and len(names) <= 2 and names[-1] != "",
            f"{where}: wanted is points:FILE or points:FILE,SURFACE",
        )
        bare = Bare(*names)
        _check_cube(where, bare.body, TetMesh)
        return bare
    raise InputError(f"{where} is not a cloud; choose one of {KINDS}")


def label_of(text: str) -> str:
    """A short name for tables: ``jitter 0.4``, ``tet``, ``hex cube_hex_8``."""
    kind, _, rest = text.partition(":")
    if not rest:
        return kind
    return f"{kind} {rest if kind in ('jitter', 'scattered') else Path(rest.split(',')[0]).stem}"


def cube_surface(cells: int) -> Surface:
    """The faces of the unit cube, each cut into ``cells^2`` squares and these into triangles."""
    mesh = Box().mesh(1.0 / cells)
    return Surface.closed(vertices=mesh.vertices, faces=mesh.faces)


def _amount(where: str, text: str) -> float:
    try:
        amount = float(text)
    except ValueError as error:
        raise InputError(f"{where}: {text!r} is not a number; jitter:0.4 for instance") from error
    require(
        0.0 < amount <= 0.9,
        f"{where}: the jitter must be within (0, 0.9] of the spacing; particles move by at most "
        "half of it",
    )
    return amount


def _found(path: str) -> Path:
    """As given, or from the root of the repository."""
    at_root = ROOT / path
    return at_root if not Path(path).exists() and at_root.exists() else Path(path)


def _along_an_edge(points: np.ndarray) -> int:
    """Spacings along an edge of the unit cube that so many points inside it stand for."""
    require(points.ndim == 2 and len(points) > 0, "there are no points")
    margin = 0.5 * len(points) ** (-1.0 / 3.0)
    inner = np.all((points > margin) & (points < 1.0 - margin), axis=1)
    return max(2, int(np.rint(np.count_nonzero(inner) ** (1.0 / 3.0))) + 1)


def _check_cube(where: str, body: Body, kind: type) -> None:
    """The scene is the unit cube with its six tags: nothing else will do."""
    mesh = body.mesh(AS_MESHED)
    require(
        isinstance(mesh, kind),
        f"{where}: the file holds cells of type {mesh.shape.name}; name it with "
        f"{'tet' if isinstance(mesh, TetMesh) else 'hex'}:FILE",
    )
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    fits = np.all(np.abs(low) < _TOLERANCE) and np.all(np.abs(high - 1.0) < _TOLERANCE)
    require(
        bool(fits) and abs(body.volume - 1.0) < _TOLERANCE,
        f"{where}: the body reaches from {low.tolist()} to {high.tolist()} m with volume "
        f"{body.volume:.6g} m^3; the swinging cube needs the unit cube [0, 1]^3 in metres",
    )
    require(
        tuple(sorted(mesh.faces)) == TAGS,
        f"{where}: the boundary tags are {sorted(mesh.faces)}; the swinging cube needs exactly "
        f"{list(TAGS)}",
    )
    for name in TAGS:
        plane = 1.0 if name[1] == "+" else 0.0
        off = mesh.vertices[mesh.face_particles(name)][:, "XYZ".index(name[0])] - plane
        require(
            bool(np.all(np.abs(off) < _TOLERANCE)),
            f"{where}: tag {name} has vertices off the plane {name[0]} = {plane:g}; tags must be "
            "the faces of the cube",
        )
