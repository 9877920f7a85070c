"""What either solver hands out at an instant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum import law
from sphsolid.errors import InputError
from sphsolid.geometry.mesh import Mesh, read_only
from sphsolid.record.budget import NOT_TRACKED, Budget, NotTracked
from sphsolid.record.placement import (
    NO_SECONDARY_GRADIENT,
    NoSecondaryGradient,
    SecondaryGradient,
)
from sphsolid.record.showing import look

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PointField:
    """Values at points that carry volume, so that it can be integrated.

    ``X (n, 3)`` [m] reference positions, ``V (n,)`` [m^3], ``values (n, ...)``.
    """

    X: Array
    V: Array
    values: Array

    def is_at(self, points: Array) -> bool:
        """True where the values stand at ``points (n, 3)`` [m] themselves.

        A mesh may have as many cells as vertices, so that numbers alone do not tell.
        """
        return np.array_equal(self.X, points)


@dataclass(frozen=True)
class Masses:
    """Points that carry the momentum: ``V (n,)`` [m^3], ``x`` [m] and ``velocity (n, 3)`` [m/s]."""

    V: Array
    x: Array
    velocity: Array

    def __post_init__(self) -> None:
        """Views that nobody can write to."""
        for each in fields(self):
            object.__setattr__(self, each.name, read_only(getattr(self, each.name)))


@dataclass(frozen=True)
class AtPrimaryPoints:
    """The momentum is carried by the primary points."""


AT_PRIMARY_POINTS = AtPrimaryPoints()


@dataclass(frozen=True)
class Snapshot:
    """The state of a body at ``time`` [s] after ``step`` steps.

    ``X, x, velocity (N, 3)`` and ``V (N,)`` at the primary points (particles, or nodes with their
    tributary volume), which are the vertices of ``mesh``; ``material`` is the constitutive law.
    ``stress_X (M, 3)``, ``stress_V (M,)``, ``F (M, 3, 3)``, ``J (M,)``, ``P (M, 3, 3)`` where the
    method evaluates the law: the particles themselves, or the element centroids of a finite
    element method (its superconvergent points).  ``strain_energy`` [J], zero in the undeformed
    state, and ``kinetic_energy`` [J] are totals with the method's own quadrature;
    ``volumetric_energy`` [J] is the part ``sum V U(J)`` of the strain energy, ``U`` the volumetric
    energy of the law, and what the terms of a method add to that, ``added_volumetric_energy``.
    ``added_pressure (M,)`` [Pa] is the mean Cauchy stress of what they add to ``P``.
    ``budget`` says where energy and momentum went, when a recorder asked for it; ``secondary`` is
    the gradient of ``x`` at the secondary particles, where there are any; ``further`` are the
    fields of a user's own terms ``(N, ...)`` at the primary points.  ``carried_by`` are the points
    whose momentum and kinetic energy are those of the method, where they are not the primary ones.
    Nobody writes to its arrays: one recorder must not change what the next one sees.
    """

    time: float
    step: int
    material: Any
    mesh: Mesh
    X: Array
    V: Array
    x: Array
    velocity: Array
    stress_X: Array
    stress_V: Array
    F: Array
    J: Array
    P: Array
    strain_energy: float
    added_pressure: Array = field(default_factory=lambda: np.zeros(()))
    added_volumetric_energy: float = 0.0
    budget: Budget | NotTracked = NOT_TRACKED
    secondary: SecondaryGradient | NoSecondaryGradient = NO_SECONDARY_GRADIENT
    further: Mapping[str, Array] = field(default_factory=dict)
    carried_by: Masses | AtPrimaryPoints = AT_PRIMARY_POINTS

    def __post_init__(self) -> None:
        """Arrays are kept as views that cannot be written to."""
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, each.name, read_only(value))

    @property
    def density(self) -> float:
        """``rho0`` [kg/m^3] of the undeformed solid."""
        return float(self.material.density)

    @property
    def momentum(self) -> Array:
        """``p = rho0 v (N, 3)`` [kg/(m^2 s)] per undeformed volume."""
        return self.density * self.velocity

    @property
    def displacement(self) -> Array:
        """``u = x - X (N, 3)`` [m]."""
        return self.x - self.X

    @property
    def kinetic_energy(self) -> float:
        """``sum V rho0 |v|^2 / 2`` [J]."""
        carried = self.masses
        return float(0.5 * self.density * np.sum(carried.V[:, None] * carried.velocity**2))

    @property
    def masses(self) -> Masses:
        """What carries the momentum: the primary points, unless the method has others."""
        if isinstance(self.carried_by, Masses):
            return self.carried_by
        return Masses(self.V, self.x, self.velocity)

    @property
    def volumetric_energy(self) -> float:
        """``sum V U(J)`` [J], ``U`` the volumetric energy of the law, and what terms add to it."""
        of_law = np.sum(self.stress_V * law.volumetric_energy(self.material, self.J))
        return float(of_law) + self.added_volumetric_energy

    @property
    def pressure(self) -> Array:
        """The pressure that acts ``(M,)`` [Pa], **positive in tension**: not its negative.

        That is ``U'(J)``, the mean stress, and :attr:`added_pressure` where terms add any: with
        ``FilteredDilatation`` it is the filtered ``p~``.
        ``U`` is the volumetric energy of the law; for ``kappa/2 (J - 1)^2`` this is
        ``kappa (J - 1)``.  Of a law that splits it is ``tr(cauchy) / 3`` where ``J = det F``.
        """
        return np.asarray(law.volumetric_pressure(self.material, self.J)) + self.added_pressure

    @property
    def cauchy(self) -> Array:
        """Cauchy stress ``sigma = P F^T / det F (M, 3, 3)`` [Pa], positive in tension."""
        return np.asarray(
            self.P @ np.swapaxes(self.F, 1, 2) / np.linalg.det(self.F)[:, None, None]
        )

    @property
    def von_mises(self) -> Array:
        """``sqrt(3/2 s:s) (M,)`` [Pa], ``s`` the deviator of the Cauchy stress."""
        sigma = self.cauchy
        mean = np.trace(sigma, axis1=1, axis2=2) / 3.0
        s = sigma - mean[:, None, None] * np.eye(3)
        return np.sqrt(1.5 * np.einsum("nij,nij->n", s, s))

    def field(self, name: str) -> PointField:
        """A field and its points; raises ``InputError`` for a name that is none of these.

        ``p``, ``u``, ``v`` at the primary points; ``P``, ``cauchy``, ``F``, ``J``, ``pressure``,
        ``von_mises`` where the law is evaluated; fields of a user's own terms by their names.
        """
        if name in self.further:
            return PointField(self.X, self.V, self.further[name])
        if name in ("p", "u", "v"):
            values = {"p": self.momentum, "u": self.displacement, "v": self.velocity}[name]
            return PointField(self.X, self.V, values)
        if name in ("P", "cauchy", "F", "J", "pressure", "von_mises"):
            return PointField(self.stress_X, self.stress_V, getattr(self, name))
        raise InputError(
            f"snapshot has no field {name!r}; choose one of p, u, v, P, cauchy, F, J, pressure, "
            "von_mises"
        )

    def at_vertices(self, name: str) -> Array:
        """A field at the primary points ``(N, ...)``; cell values are averaged by volume."""
        return at_vertices(self, name)

    def picture(self, field: str = "pressure", **options: Any) -> Any:
        """The deformed body, coloured by ``field``: a figure that a notebook shows.

        ``pressure`` [Pa] (positive in tension), ``von_mises`` [Pa], ``J``, the sizes ``u`` [m],
        ``v`` [m/s], ``p`` [kg/(m^2 s)], or a component: ``u_x``, ``P_xy``, ``cauchy_zz``,
        ``F_xx``.  Values are the method's own, carried to the vertices.  Options are ``up`` (the
        axis that points up), ``view``, ``limits``, ``title`` and ``path``; see
        :func:`sphsolid.look.pictures.picture_of`.  Raises ``InputError`` for an unknown field,
        and where matplotlib is not installed.
        """
        return look().picture(self, field, options)

    def _repr_png_(self) -> Any:
        if not look().can_draw:
            return None
        return self.picture()._repr_png_()


class HasFields(Protocol):
    """A snapshot, of a run or of its files."""

    @property
    def mesh(self) -> Mesh:
        """The undeformed mesh."""
        ...

    @property
    def X(self) -> Array:
        """Its vertices ``(N, 3)`` [m]."""
        ...

    def field(self, name: str) -> PointField:
        """A field and its points."""
        ...


class HasFurther(HasFields, Protocol):
    """One that says which fields it has beside the usual."""

    @property
    def further(self) -> Mapping[str, Array]:
        """Fields of a user's own terms at the vertices, by name."""
        ...


def at_vertices(snapshot: HasFields, name: str) -> Array:
    """A field at the primary points ``(N, ...)``; cell values are averaged by volume."""
    found = snapshot.field(name)
    if found.is_at(snapshot.X):
        return found.values
    total = np.zeros((len(snapshot.X), *found.values.shape[1:]))
    weight = np.zeros(len(snapshot.X))
    share = found.V.reshape(-1, *[1] * (found.values.ndim - 1)) * found.values
    for corner in snapshot.mesh.cells.T:
        np.add.at(total, corner, share)
        np.add.at(weight, corner, found.V)
    return np.asarray(total / weight.reshape(-1, *[1] * (total.ndim - 1)))
