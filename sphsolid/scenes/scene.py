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
from sphsolid.scenes import checks
from sphsolid.scenes.callbacks import asked
from sphsolid.scenes.constraint import Constraint, Fixed

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

    def __post_init__(self) -> None:
        """Refuse a value that is no function."""
        if not isinstance(self.face, str):
            raise InputError(f"Traction: face = {self.face!r} is not the name of a boundary tag")
        checks.function(f"traction on {self.face!r}: value", self.value, "lambda X, N, t")

    def at(self, X: Array, N: Array, t: float) -> Array:
        """Checked ``t_B (n, 3)`` [Pa]; see :func:`callbacks.asked`."""
        return asked(self.value, X, N, what=f"traction on {self.face}", t=t)


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
        """Refuse what is no part of a problem; lists become tuples."""
        scene = f"scene {self.name!r}"
        if not isinstance(self.name, str):
            raise InputError(f"{scene}: the name of a scene is a string")
        if not isinstance(self.provenance, str):
            raise InputError(f"{scene}: provenance = {self.provenance!r} is not a string")
        end_time = checks.number(f"{scene}: end_time", self.end_time, "s")
        require(
            end_time > 0.0, f"{scene}: end_time = {self.end_time} s must be positive and finite"
        )
        checks.body(f"{scene}: body", self.body)
        require_law(self.material, f"{scene}: material")
        checks.material(f"{scene}: material", self.material)
        for name in ("initial_displacement", "initial_velocity"):
            checks.function(f"{scene}: {name}", getattr(self, name), "lambda X")
        if not isinstance(self.initial_deformation_gradient, FromGeometry):
            what = f"{scene}: initial_deformation_gradient"
            checks.function(what, self.initial_deformation_gradient, "lambda X")
        if not isinstance(self.body_force, NoBodyForce):
            checks.function(f"{scene}: body_force", self.body_force, "lambda X, t")
        if isinstance(self.exact, type):
            raise InputError(f"{scene}: exact = {self.exact.__name__} is a class; make an object")
        if not isinstance(self.exact, NoExactSolution) and not callable(
            getattr(self.exact, "displacement", None)
        ):
            raise InputError(
                f"{scene}: exact = {self.exact!r} is no exact solution; leave it out where none is "
                "known: NoExactSolution()"
            )
        for name, made in (
            ("end_time", end_time),
            ("constraints", checks.members("constraints", self.constraints, Constraint)),
            ("tractions", checks.members("tractions", self.tractions, Traction)),
            ("probes", checks.probes(scene, self.probes)),
        ):
            object.__setattr__(self, name, made)

    @property
    def is_driven(self) -> bool:
        """True when a load or a prescribed motion can do work on the body."""
        moved = any(not isinstance(part.velocity, Fixed) for part in self.constraints)
        return moved or bool(self.tractions) or not isinstance(self.body_force, NoBodyForce)

    def initial_state(self, X: Array) -> tuple[Array, Array]:
        """Checked initial displacement [m] and velocity [m/s] at ``X (n, 3)``."""
        return (
            self.displacement_at_start(X),
            asked(self.initial_velocity, X, what=self._named("initial_velocity")),
        )

    def displacement_at_start(self, X: Array) -> Array:
        """Checked initial displacement [m] at ``X (n, 3)``."""
        return asked(self.initial_displacement, X, what=self._named("initial_displacement"))

    @property
    def states_deformation(self) -> bool:
        """True when the scene states an initial ``F``."""
        return not isinstance(self.initial_deformation_gradient, FromGeometry)

    def stated_deformation(self, X: Array) -> Array:
        """Checked initial ``F (n, 3, 3)``, ``det F > 0``, of a scene that states one."""
        given, what = self.initial_deformation_gradient, "initial_deformation_gradient"
        assert not isinstance(given, FromGeometry)
        F = asked(given, X, what=self._named(what), tensor=True)
        checks.orientation(self._named(what), F, X)
        return F

    def body_force_at(self, X: Array, t: float) -> Array:
        """Checked ``f0 (n, 3)`` [N/m^3] of a scene that has a body force."""
        force = self.body_force
        assert not isinstance(force, NoBodyForce)
        return asked(force, X, what=self._named("body force"), t=t)

    def _named(self, callback: str) -> str:
        return f"scene {self.name!r}: {callback}"

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


def check_scene(scene: object) -> None:
    """Raise ``InputError`` unless ``scene`` is a :class:`Scene`, not what makes one."""
    if not isinstance(scene, Scene):
        made = f"; call it: {getattr(scene, '__name__', 'scene')}(...)" if callable(scene) else ""
        raise InputError(f"scene = {scene!r} is not a Scene{made}")
