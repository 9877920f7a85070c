"""A deck for CalculiX from a scene: what both of our solvers read, for a code that is not ours.

Hexahedra C3D20R, of 20 nodes with reduced integration, on the vertices of the scene's own mesh.
A step is implicit and of fixed length.  ``ALPHA = 0`` is Newmark's trapezoidal rule, which adds no
damping of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.continuum.saint_venant_kirchhoff import SaintVenantKirchhoff
from sphsolid.errors import InputError, require
from sphsolid.geometry.mesh import HexMesh
from sphsolid.scenes import Constraint, Fixed, NoBodyForce, Scene
from studies.outside.hexahedra import QuadraticHexahedra, quadratic
from studies.outside.nodal_loads import History, nodal_history

Array = NDArray[np.float64]
#: A normal is along an axis when its largest component is one to within this.
_ALONG = 1.0e-9


@dataclass(frozen=True)
class Implicit:
    """Steps of ``step`` [s] to ``until`` [s], with a record each ``every`` [s].

    ``alpha`` in [-1/3, 0] is that of Hilber, Hughes and Taylor.
    """

    step: float
    until: float
    every: float
    alpha: float = 0.0

    def __post_init__(self) -> None:
        """Refuse times that do not fit."""
        for name in ("step", "until", "every"):
            value = getattr(self, name)
            require(
                math.isfinite(value) and value > 0.0,
                f"Implicit: {name} = {value} s must be positive and finite",
            )
        for name in ("until", "every"):
            share = getattr(self, name) / self.step
            require(
                abs(share - round(share)) < 1e-6 * share,
                f"Implicit: {name} = {getattr(self, name)} s is no whole number of steps of "
                f"{self.step} s",
            )
        require(
            -1.0 / 3.0 <= self.alpha <= 0.0,
            f"Implicit: alpha = {self.alpha} is outside [-1/3, 0]",
        )

    @property
    def times(self) -> Array:
        """Start and end of every step ``(n + 1,)`` [s]."""
        return np.arange(round(self.until / self.step) + 1, dtype=np.float64) * self.step

    def lines(self) -> Iterator[str]:
        """The card of the step."""
        yield f"*STEP,NLGEOM,INC={2 * len(self.times)}"
        yield f"*DYNAMIC,DIRECT,ALPHA={self.alpha:g}"
        yield f"{self.step:.12g},{self.until:.12g}"

    def output(self) -> Iterator[str]:
        """Displacements of all nodes, and both energies of the body."""
        each = round(self.every / self.step)
        yield f"*NODE PRINT,NSET=ALL,FREQUENCY={each}"
        yield "U"
        yield f"*EL PRINT,ELSET=BODY,FREQUENCY={each},TOTALS=ONLY"
        yield "ELSE,ELKE"


@dataclass(frozen=True)
class Frequencies:
    """The ``count`` lowest frequencies of the body at rest, in the linear limit."""

    count: int = 2

    def lines(self) -> Iterator[str]:
        """The card of the step."""
        yield "*STEP"
        yield "*FREQUENCY"
        yield f"{self.count}"

    def output(self) -> Iterator[str]:
        """Nothing: frequencies are always written."""
        yield from ()


@dataclass(frozen=True)
class Deck:
    """The ``text`` of an input file and the ``elements`` that it is about."""

    text: str
    elements: QuadraticHexahedra


def deck(scene: Scene, mesh: HexMesh, step: Implicit | Frequencies) -> Deck:
    """The deck of ``scene`` on the hexahedra of ``mesh``, a mesh of its body.

    Raises ``InputError`` for what a deck cannot say: another law than :class:`NeoHookean` and
    :class:`SaintVenantKirchhoff`, an initial displacement or ``F``, a prescribed motion, a
    constraint on a face that is not across an axis, a load that is no product of a function of
    place and one of time, and a body force that varies.
    """
    if not isinstance(mesh, HexMesh):
        raise InputError(
            f"deck of scene {scene.name!r}: its cells are {mesh.shape.name}s; C3D20R are hexahedra"
        )
    elements = quadratic(mesh)
    moving = isinstance(step, Implicit)
    lines = [
        f"** {scene.name}: {len(elements.cells)} C3D20R",
        "*NODE,NSET=ALL", *_rows(elements.nodes),
        "*ELEMENT,TYPE=C3D20R,ELSET=BODY", *_elements(elements),
        "*MATERIAL,NAME=SOLID", *_law(scene, linear=not moving),
        "*DENSITY", f"{scene.material.density:.12g}",
        "*SOLID SECTION,ELSET=BODY,MATERIAL=SOLID",
        *_held(scene, elements),
    ]  # fmt: skip
    loads: list[tuple[str, History]] = []
    if isinstance(step, Implicit):
        lines += _initial(scene, elements)
        loads = [
            (f"T{k}", nodal_history(scene, traction, elements, step.times))
            for k, traction in enumerate(scene.tractions)
        ]
    for name, load in loads:
        lines += [f"*AMPLITUDE,NAME={name}", *_pairs(step.times, load.amplitude)]  # type: ignore[union-attr]
    lines += [*step.lines()]
    for name, load in loads:
        lines += [f"*CLOAD,AMPLITUDE={name}", *_by_component(load.nodes, load.force)]
    if moving:
        lines += _weight(scene, elements)
    lines += [*step.output(), "*END STEP"]
    return Deck("\n".join(lines) + "\n", elements)


def _rows(nodes: Array) -> Iterator[str]:
    for number, (x, y, z) in enumerate(nodes, 1):
        yield f"{number},{x:.12g},{y:.12g},{z:.12g}"


def _elements(elements: QuadraticHexahedra) -> Iterator[str]:
    for number, cell in enumerate(elements.cells + 1, 1):
        # At most 16 entries a line.
        yield f"{number}," + ",".join(map(str, cell[:15])) + ","
        yield ",".join(map(str, cell[15:]))


def _law(scene: Scene, *, linear: bool) -> list[str]:
    """Neo-Hooke with ``U = kappa/2 (J - 1)^2``; linear in Green's strain; or both linear."""
    law = scene.material
    if not isinstance(law, NeoHookean | SaintVenantKirchhoff):
        raise InputError(
            f"deck of scene {scene.name!r}: material {type(law).__name__} is neither NeoHookean "
            "nor SaintVenantKirchhoff"
        )
    if isinstance(law, NeoHookean) and not linear:
        return ["*HYPERELASTIC,NEO HOOKE", f"{0.5 * law.mu:.12g},{2.0 / law.kappa:.12g}"]
    young = 9.0 * law.kappa * law.mu / (3.0 * law.kappa + law.mu)
    return ["*ELASTIC", f"{young:.12g},{0.5 * young / law.mu - 1.0:.12g}"]


def _held(scene: Scene, elements: QuadraticHexahedra) -> list[str]:
    found = set[tuple[int, int]]()
    for constraint in scene.constraints:
        if not isinstance(constraint.velocity, Fixed):
            raise InputError(
                f"deck of scene {scene.name!r}: the motion of {constraint.face!r} is prescribed; "
                "only what is held still can be said"
            )
        if constraint.face not in elements.faces:
            raise InputError(
                f"deck of scene {scene.name!r}: the body has no face {constraint.face!r}, only "
                f"{sorted(elements.faces)}"
            )
        nodes = np.unique(elements.faces[constraint.face])
        found |= {(int(n), axis) for axis in _axes(constraint, elements) for n in nodes}
    if not found:
        return []
    return ["*BOUNDARY", *(f"{n + 1},{axis + 1},{axis + 1}" for n, axis in sorted(found))]


def _axes(constraint: Constraint, elements: QuadraticHexahedra) -> list[int]:
    """The components that a constraint holds, 0 to 2."""
    if constraint.direction == "all":
        return [0, 1, 2]
    corners = elements.nodes[elements.faces[constraint.face][:, :4]]
    area = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal = np.abs(area / np.linalg.norm(area, axis=1, keepdims=True))
    axis = int(np.argmax(normal[0]))
    require(
        bool(np.all(normal[:, axis] > 1.0 - _ALONG)),
        f"deck: the face {constraint.face!r} is not across one axis; only such can roll or slide",
    )
    return [axis] if constraint.direction == "normal" else [k for k in range(3) if k != axis]


def _initial(scene: Scene, elements: QuadraticHexahedra) -> list[str]:
    require(
        not scene.states_deformation,
        f"deck of scene {scene.name!r}: it states an initial F, which a deck cannot say",
    )
    u, v = scene.initial_state(elements.nodes)
    require(
        not np.any(u),
        f"deck of scene {scene.name!r}: it starts displaced, which a deck cannot say",
    )
    if not np.any(v):
        return []
    every = np.arange(len(v))
    return ["*INITIAL CONDITIONS,TYPE=VELOCITY", *_by_component(every, v)]


def _by_component(nodes: Iterable[int], values: Array) -> Iterator[str]:
    """Lines ``node,component,value`` of what is not zero."""
    for node, value in zip(nodes, values, strict=True):
        for axis in np.flatnonzero(value):
            yield f"{node + 1},{axis + 1},{value[axis]:.12g}"


def _pairs(times: Array, values: Array) -> Iterator[str]:
    for first in range(0, len(times), 4):
        both = zip(times[first : first + 4], values[first : first + 4], strict=True)
        yield ",".join(f"{t:.12g},{value:.12g}" for t, value in both)


def _weight(scene: Scene, elements: QuadraticHexahedra) -> list[str]:
    """A body force that is the same everywhere and at all times, as gravity."""
    if isinstance(scene.body_force, NoBodyForce):
        return []
    ends = (0.0, 0.37 * scene.end_time, scene.end_time)
    found = np.stack([scene.body_force_at(elements.nodes, t) for t in ends])
    force = found[0, 0]
    size = float(np.linalg.norm(force))
    if size == 0.0 and not np.any(found):
        return []
    require(
        bool(np.all(np.abs(found - force) <= 1e-12 * size)),
        f"deck of scene {scene.name!r}: its body force varies; only a uniform, constant one is "
        "gravity",
    )
    x, y, z = force / size
    return ["*DLOAD", f"BODY,GRAV,{size / scene.material.density:.12g},{x:.12g},{y:.12g},{z:.12g}"]
