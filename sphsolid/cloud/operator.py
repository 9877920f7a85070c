"""Operator kinds: how a gradient is taken and how its adjoint makes a force.

``Literal`` is [Lee2017] eqs. (30) and (32) as printed.  ``Consistent`` changes the gradient as
little as possible so that the force of a uniform stress is exact (see ``consistent``); without it
the method is first order at best near boundaries.  ``SummationByParts`` makes linear stress exact
too, which is what second order needs where particles are not on a lattice.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol
from typing import Literal as OneOf

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.boundary_weights import quadratically_exact_areas
from sphsolid.cloud.consistent import least_change
from sphsolid.cloud.gradient import (
    corrected_gradient,
    kernel_gradient,
    linear_kernel_gradient,
    offsets,
)
from sphsolid.cloud.lengths import Lengths
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.cloud.smoothing import SmoothingFunction
from sphsolid.cloud.summation_by_parts import skew_gradient
from sphsolid.errors import InputError, require
from sphsolid.geometry.integrals import layers_from_boundary
from sphsolid.geometry.mesh import Mesh
from sphsolid.protocols import check_protocol

Array = NDArray[np.float64]
GradientKind = OneOf["corrected_kernel", "linear_kernel", "kernel"]
_GRADIENTS = {
    "corrected_kernel": corrected_gradient,
    "linear_kernel": linear_kernel_gradient,
    "kernel": kernel_gradient,
}


@dataclass(frozen=True)
class Gradients:
    """Two gradients on one pair list ``(P, 3)`` [1/m].

    ``kinematic`` takes ``F`` and its rate; ``force`` is the one whose adjoint makes the internal
    force and whose ``F_x`` the angular-momentum projection needs.  They are the same object when
    the operator is adjoint.  ``areas (N, 3)`` [m^2] are the area vectors that go with ``force``;
    ``iterations`` what a solver took to find it, ``change`` how far ``force`` is from the printed
    gradient, relative to it in the root mean square.
    """

    kinematic: Array
    force: Array
    areas: Array
    iterations: int = 0
    change: float = 0.0

    @property
    def is_adjoint(self) -> bool:
        """True when force and kinematics share one gradient: energy-consistent in space."""
        return self.kinematic is self.force


@dataclass(frozen=True)
class Ingredients:
    """What every operator kind is made from."""

    mesh: Mesh
    volumes: Array
    areas: Array
    pairs: PairList
    smoothing: SmoothingFunction
    lengths: Lengths

    @property
    def h(self) -> float | Array:
        """Smoothing length [m], one or one a pair."""
        return self.lengths.of_pairs(self.mesh.vertices, self.pairs)

    def share(self) -> Array:
        """``W / W(0)`` of every pair ``(P,)``."""
        X, h = self.mesh.vertices, self.h
        distance = np.linalg.norm(offsets(X, X, self.pairs), axis=1)
        peak = self.smoothing.value(np.zeros(1), h)
        return self.smoothing.value(distance, h) / peak


@dataclass(frozen=True)
class Layout:
    """What an operator that brings its own quadrature is made on.

    ``volumes (N,)`` [m^3], ``areas`` [m^2] of every tag ``(N, 3)``, and the ``pairs``.
    """

    volumes: Array
    areas: dict[str, Array]
    pairs: PairList


def refuse_wrong_gradients(operator: OperatorKind, made: object, cloud: Ingredients) -> None:
    """Raise ``InputError`` unless ``made`` are gradients on the pairs of ``cloud``."""
    if not isinstance(made, Gradients):
        raise InputError(
            f"{operator.name}.build returned {type(made).__name__}; wanted is "
            "Gradients(kinematic, force, areas) of sphsolid.cloud.operator"
        )
    pairs, particles = len(cloud.pairs.indices), len(cloud.volumes)
    for name, rows in (("kinematic", pairs), ("force", pairs), ("areas", particles)):
        _check_rows(f"{operator.name}.build: {name}", getattr(made, name), rows, 3)


def refuse_wrong_layout(operator: OperatorKind, made: object, mesh: Mesh) -> None:
    """Raise ``InputError`` unless ``made`` is a layout on the vertices of ``mesh``."""
    if not isinstance(made, Layout) or not isinstance(made.pairs, PairList):
        raise InputError(
            f"{operator.name}.layout returned {type(made).__name__}; wanted is "
            "Layout(volumes, areas, pairs) of sphsolid.cloud.operator, its pairs a PairList"
        )
    size = len(mesh.vertices)
    _check_rows(f"{operator.name}.layout: volumes", made.volumes, size)
    require(
        bool(np.all(made.volumes > 0.0)),
        f"{operator.name}.layout: volumes must be positive, the least is {np.min(made.volumes):g}",
    )
    for tag, area in made.areas.items():
        _check_rows(f"{operator.name}.layout: areas of {tag!r}", area, size, 3)


def _check_rows(what: str, values: Any, *shape: int) -> None:
    found = np.shape(values)
    require(found == shape, f"{what} has the shape {found}; wanted is {shape}")
    bad = ~np.isfinite(np.asarray(values, dtype=np.float64)).reshape(shape[0], -1).all(axis=1)
    worst = f"{np.sum(bad)} rows, the first {np.argmax(bad)}"
    require(not bad.any(), f"{what} is not finite in {worst}")


class OperatorKind(Protocol):
    """An option that makes the gradients of a cloud: a frozen dataclass.

    One that brings volumes, areas and pairs of its own has a method ``layout(mesh)``, which returns
    a :class:`Layout`.
    """

    @property
    def name(self) -> str:
        """Short, for file names."""
        ...

    def build(self, cloud: Ingredients) -> Gradients:
        """The gradients on ``cloud.pairs``; raises ``InputError`` where there are none."""
        ...


def _base(kind: GradientKind, cloud: Ingredients) -> Array:
    if kind not in _GRADIENTS:
        raise InputError(f"gradient {kind!r} is not one of {sorted(_GRADIENTS)}")
    X = cloud.mesh.vertices
    return _GRADIENTS[kind](X, X, cloud.volumes, cloud.pairs, cloud.smoothing, cloud.h)


def _relative(change: Array, base: Array) -> float:
    return float(np.sqrt(np.sum(change**2) / np.sum(base**2)))


@dataclass(frozen=True)
class Literal:
    """The paper as printed.

    ``gradient``: ``"corrected_kernel"`` is eq. (30); ``"linear_kernel"`` differentiates the
    linear-corrected kernel analytically, the other reading of its text; ``"kernel"`` is the usual
    one of total-Lagrangian SPH, which corrects the gradient and not the kernel ([Randles1996]).
    """

    gradient: GradientKind = "corrected_kernel"

    @property
    def name(self) -> str:
        """``Literal``, ``Literal(linear kernel)`` or ``Literal(kernel)``."""
        if self.gradient == "corrected_kernel":
            return "Literal"
        return f"Literal({self.gradient.replace('_', ' ')})"

    def build(self, cloud: Ingredients) -> Gradients:
        """The gradient, used for kinematics and force."""
        G = _base(self.gradient, cloud)
        return Gradients(G, G, cloud.areas)


@dataclass(frozen=True)
class Consistent:
    """The paper's gradient with the least change that satisfies the divergence theorem.

    ``use = "everywhere"`` (default): force and kinematics adjoint, so the space discretisation
    neither makes nor eats energy.  ``use = "force"``: kinematics stay literal; stresses are more
    accurate at the boundary, energy is not controlled.  ``layers``: on a lattice the change is
    confined to particles within that many cells of the boundary (more if the support reaches
    further).  ``weight_exponent``: the change is weighed by ``w = (W / W_0)^exponent``; 0 shares it
    equally among all neighbours, larger values leave it to the nearest.
    """

    #: Worth keeping on disk; ``repr`` and our sources say all that it depends on.
    is_kept: ClassVar[bool] = True

    use: OneOf["everywhere", "force"] = "everywhere"
    gradient: GradientKind = "corrected_kernel"
    layers: int = 2
    weight_exponent: float = 0.5

    def __post_init__(self) -> None:
        if self.use not in ("everywhere", "force"):
            raise InputError(f"Consistent: use {self.use!r} is not one of 'everywhere', 'force'")
        require(
            self.layers >= 1 and 0.0 <= self.weight_exponent < float("inf"),
            f"Consistent: layers = {self.layers} must be at least 1 and weight_exponent = "
            f"{self.weight_exponent} finite and not negative; 2 and 0.5 are the defaults",
        )

    @property
    def name(self) -> str:
        """``Consistent`` or ``Consistent(force)``."""
        return "Consistent" if self.use == "everywhere" else "Consistent(force)"

    def build(self, cloud: Ingredients) -> Gradients:
        """Solve for the change and apply it; raises ``InputError`` where none exists."""
        base = _base(self.gradient, cloud)
        X, pairs = cloud.mesh.vertices, cloud.pairs
        share = cloud.share()
        weights = np.where(share > 0.0, share**self.weight_exponent, 0.0)
        if cloud.mesh.is_lattice:
            # Rows that see a boundary particle, with its share of a volume, differ from the inner
            # stencil, and so do the columns that see those rows: twice the cells in reach.
            reach = cloud.smoothing.support * float(np.max(cloud.h)) / cloud.mesh.spacing
            cells = int(np.ceil(reach - 1e-9)) - 1
            near = layers_from_boundary(cloud.mesh) <= max(self.layers, 2 * cells)
            weights = weights * (near[pairs.row_of_pair] & near[pairs.indices])
        change = least_change(base, pairs, X, cloud.volumes, cloud.areas, weights)
        corrected = base + change.D
        kinematic = corrected if self.use == "everywhere" else base
        return Gradients(
            kinematic, corrected, cloud.areas, change.iterations, _relative(change.D, base)
        )


@dataclass(frozen=True)
class SummationByParts:
    """A gradient and force that sum by parts: second order on any cloud (``summation_by_parts``).

    ``epsilon``: how much exactness on quadratics counts against nearness to the printed gradient
    (smaller: more exact, longer to find); ``weight_exponent`` as for :class:`Consistent`;
    ``tolerance`` of the solver relative to the first defect.
    """

    #: As of :class:`Consistent`.
    is_kept: ClassVar[bool] = True

    epsilon: float = 0.02
    weight_exponent: float = 0.25
    tolerance: float = 1.0e-10
    gradient: GradientKind = "corrected_kernel"

    def __post_init__(self) -> None:
        require(
            0.0 < self.epsilon < float("inf")
            and 0.0 <= self.weight_exponent < float("inf")
            and 1.0e-12 <= self.tolerance <= 1.0e-2,
            f"SummationByParts: epsilon = {self.epsilon} must be positive, weight_exponent = "
            f"{self.weight_exponent} not negative, tolerance = {self.tolerance} within "
            "[1e-12, 1e-2]; 0.02, 0.25 and 1e-10 are the defaults",
        )

    @property
    def name(self) -> str:
        """``SummationByParts``."""
        return "SummationByParts"

    def build(self, cloud: Ingredients) -> Gradients:
        """Solve for the pair; raises ``InputError`` where none exists."""
        X = cloud.mesh.vertices
        areas = np.sum(list(quadratically_exact_areas(cloud.mesh).values()), axis=0)
        base = _base(self.gradient, cloud)
        found = skew_gradient(
            base,
            cloud.pairs,
            X,
            cloud.volumes,
            areas,
            cloud.lengths.spacings(X),
            cloud.share(),
            weight_exponent=self.weight_exponent,
            epsilon=self.epsilon,
            tolerance=self.tolerance,
        )
        return Gradients(
            found.G, found.G, areas, found.iterations, _relative(found.G - base, base)
        )


def check_operator(operator: object) -> None:
    """Raise ``InputError`` unless ``operator`` keeps the protocol."""
    check_protocol(
        "operator", operator, ("name", "build"),
        "use one of Literal(), Consistent(), SummationByParts(), or see "
        "docs/how_to_add/operator.md",
    )
