"""The problem statement that both solvers read.  No solver in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.check_law import require_law
from sphsolid.errors import InputError, require
from sphsolid.geometry.body import Body
from sphsolid.scenes.constraint import Constraint

Array = NDArray[np.float64]
#: ``f(X (n, 3)) -> (n, 3)``.
VectorField = Callable[[Array], Array]
#: ``f(X (n, 3)) -> (n, 3, 3)``.
TensorField = Callable[[Array], Array]
#: ``f(X (n, 3), t) -> (n, 3)``.
TimeField = Callable[[Array, float], Array]


class ExactSolution(Protocol):
    """A known motion ``x = X + u(X, t)`` and its stress."""

    @property
    def period(self) -> float:
        """One period [s]: the span over which errors are averaged."""
        ...

    @property
    def momentum_scale(self) -> float:
        """L2 norm of the amplitude of the largest momentum component [kg/(m^2 s) m^1.5]."""
        ...

    @property
    def stress_scale(self) -> float:
        """L2 norm by which stress errors are divided [Pa m^1.5]."""
        ...

    def displacement(self, X: Array, t: float) -> Array:
        """``u (n, 3)`` [m]."""
        ...

    def velocity(self, X: Array, t: float) -> Array:
        """``du/dt (n, 3)`` [m/s]."""
        ...

    def deformation_gradient(self, X: Array, t: float) -> Array:
        """``F = I + grad u (n, 3, 3)``."""
        ...

    def first_piola(self, X: Array, t: float) -> Array:
        """``P (n, 3, 3)`` [Pa]."""
        ...


@dataclass(frozen=True)
class NoExactSolution:
    """The motion is not known in closed form: asking for errors is refused."""


@dataclass(frozen=True)
class FromGeometry:
    """The scene states no initial ``F``: it follows from the initial displacement."""


@dataclass(frozen=True)
class NoBodyForce:
    """No force acts on the volume; costs nothing."""


@dataclass(frozen=True)
class Traction:
    """``t_B(X, N, t) -> (n, 3)`` [Pa] per undeformed area on the boundary tag ``face``.

    ``N`` are the outward unit normals of the undeformed boundary at ``X``.
    """

    face: str
    value: Callable[[Array, Array, float], Array]


def at_rest(X: Array) -> Array:
    """Zero initial velocity or displacement ``(n, 3)``."""
    return np.zeros_like(X)


@dataclass(frozen=True)
class Scene:
    """Body, material, initial state, constraints, loads, exact solution, end time (SI units).

    ``provenance`` says what of the problem is published and what is a choice of ours.
    ``probes`` name material points, used by ``Probe("name")``.
    """

    name: str
    body: Body
    material: Any
    end_time: float
    initial_displacement: VectorField = at_rest
    initial_velocity: VectorField = at_rest
    initial_deformation_gradient: TensorField | FromGeometry = FromGeometry()
    constraints: tuple[Constraint, ...] = ()
    tractions: tuple[Traction, ...] = ()
    body_force: TimeField | NoBodyForce = NoBodyForce()
    exact: ExactSolution | NoExactSolution = NoExactSolution()
    probes: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    provenance: str = ""

    def __post_init__(self) -> None:
        require(
            np.isfinite(self.end_time) and self.end_time > 0.0,
            f"scene {self.name!r}: end_time = {self.end_time} s must be positive and finite",
        )
        require_law(self.material, f"scene {self.name!r}: material")
        for name in ("mu", "kappa", "density"):
            value = getattr(self.material, name, None)
            require(
                isinstance(value, int | float | np.number) and bool(0.0 < value < np.inf),
                f"scene {self.name!r}: material {name} = {value} must be positive and finite; "
                "build the material with its from_young(...)",
            )

    def initial_state(self, X: Array) -> tuple[Array, Array]:
        """Checked initial displacement [m] and velocity [m/s] at ``X (n, 3)``."""
        state = []
        for what, function in (
            ("initial_displacement", self.initial_displacement),
            ("initial_velocity", self.initial_velocity),
        ):
            value = np.asarray(function(X), dtype=float)
            if value.shape != X.shape:
                raise InputError(
                    f"scene {self.name!r}: {what} returned shape {value.shape}, expected {X.shape}"
                )
            bad = np.flatnonzero(~np.isfinite(value).all(axis=1))
            if len(bad):
                raise InputError(
                    f"scene {self.name!r}: {what} is not finite at {len(bad)} of {len(X)} points, "
                    f"the first at X = {X[bad[0]].tolist()} m; give finite initial data"
                )
            state.append(value)
        return state[0], state[1]

    def known_solution(self) -> ExactSolution:
        """The exact solution, or ``InputError`` where a scene has none."""
        if isinstance(self.exact, NoExactSolution):
            raise InputError(
                f"scene {self.name!r} has no exact solution, so no errors can be computed; "
                "use a scene with one (for instance swinging_cube) or compare two runs"
            )
        if not self.constraints:
            raise InputError(
                f"scene {self.name!r} has no constraints, so its motion is known only up to a "
                "rigid motion and errors are not defined; constrain it as its exact solution does"
            )
        return self.exact
