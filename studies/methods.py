"""The registry of methods: each has one name, one colour and one way to build its solver.

A study takes methods from here, or varies one with :meth:`Method.but`::

    SUPG.but(tau_p=0.0)                                     # "self-adjoint SUPG, tau_p = 0"
    PAPER.but(formulation=PFHJ(), tau_F=OfStep(0.5))        # "paper, {p,F,H,J}, tau_F = 0.5 dt"

A new method is one entry in :data:`METHODS`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Protocol

import fem_reference as fem
import sphsolid as sph
from sphsolid.cloud.secondary import default_secondary
from sphsolid.defaults import default_supg
from sphsolid.errors import InputError, nearest
from sphsolid.geometry.body import Spacing
from sphsolid.recommendation import recommend_supg
from sphsolid.record import Solver
from sphsolid.scenes import Scene
from sphsolid.scheme.intrinsic_time import IntrinsicTime, as_time
from sphsolid.scheme.stabilisation import Stabilisation
from studies.engine.plotting import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, YELLOW


class Recipe(Protocol):
    """How a solver is built from a scene; what it leaves out is the solver's own choice."""

    def build(self, scene: Scene, spacing: Spacing) -> Solver:
        """A solver with particles or nodes ``spacing`` [m] apart."""
        ...

    def but(self, changes: Mapping[str, Any]) -> Recipe:
        """The same with other options; raises ``InputError`` for one that there is not."""
        ...


@dataclass(frozen=True)
class Times:
    """An intrinsic time as a multiple of the package's choice: ``tau_F=Times(2)``."""

    factor: float

    def of(self, usual: IntrinsicTime) -> IntrinsicTime:
        """The time itself."""
        return replace(usual, c=self.factor * usual.c)


@dataclass(frozen=True)
class Particles:
    """``sphsolid.Simulation`` with ``options``; ``supg`` are changes of the stabilisation.

    Without a ``stabilisation`` among the options, the changes are of the SUPG that the package
    sets for the formulation and the material.
    """

    options: tuple[tuple[str, Any], ...] = ()
    supg: tuple[tuple[str, Any], ...] = ()

    def build(self, scene: Scene, spacing: Spacing) -> sph.Simulation:
        """A simulation with particles ``spacing`` [m] apart."""
        given = dict(self.options)
        if self.supg:
            given["stabilisation"] = self.stabilisation(scene, spacing)
        return sph.Simulation(scene, spacing=spacing, **given)

    def stabilisation(self, scene: Scene, spacing: Spacing) -> Stabilisation:
        """The stabilisation of a scene, with the changes made."""
        given = dict(self.options)
        usual = given.get("stabilisation")
        if usual is None:
            formulation = given.get("formulation", recommend_supg(scene).formulation)
            secondary = default_secondary(scene.body.mesh(spacing))
            usual = default_supg(formulation, scene.material, secondary=secondary)
        changes = {
            name: value.of(as_time(getattr(usual, name))) if isinstance(value, Times) else value
            for name, value in self.supg
        }
        return replace(usual, **changes) if changes else usual

    def but(self, changes: Mapping[str, Any]) -> Particles:
        """Other options; those of :class:`~sphsolid.SUPG` change the stabilisation.

        Raises ``InputError`` where there is no SUPG to change.
        """
        terms = {each.name for each in fields(sph.SUPG)}
        _refuse_unknown(changes, sph.Simulation, terms)
        supg = {name: value for name, value in changes.items() if name in terms}
        options = {name: value for name, value in changes.items() if name not in terms}
        made = _merged(self.options, options)
        if supg and not self.supg and not {"stabilisation", "formulation"} & dict(made).keys():
            raise InputError(
                f"{', '.join(supg)} belong to sphsolid.SUPG, and the package default is none; vary "
                "studies.methods.SUPG, or give a formulation that evolves F"
            )
        if "stabilisation" in options:
            # Another stabilisation is not changed by what was changed of the one before.
            return Particles(made, _merged((), supg))
        return Particles(made, _merged(self.supg, supg))


@dataclass(frozen=True)
class Elements:
    """``fem_reference.Simulation`` with ``options``.

    ``edge`` is the number of node spacings along an element, so that ``spacing`` is that of nodes.
    """

    options: tuple[tuple[str, Any], ...] = ()
    edge: int = 1
    solver: ClassVar[Callable[..., Solver]] = fem.Simulation

    def build(self, scene: Scene, spacing: Spacing) -> Solver:
        """A simulation with nodes ``spacing`` [m] apart."""
        return type(self).solver(scene, spacing=spacing, **dict(self.options))

    def but(self, changes: Mapping[str, Any]) -> Elements:
        """Other options of the solver; raises ``InputError`` for one that there is not."""
        _refuse_unknown(changes, type(self).solver)
        return replace(self, options=_merged(self.options, changes))


@dataclass(frozen=True)
class MixedElements(Elements):
    """``fem_reference.MixedSimulation`` with ``options``."""

    solver: ClassVar[Callable[..., Solver]] = fem.MixedSimulation


@dataclass(frozen=True)
class FiniteVolumes(Elements):
    """``fem_reference.FiniteVolumeSimulation`` with ``options``; ``spacing`` is that of cells."""

    solver: ClassVar[Callable[..., Solver]] = fem.FiniteVolumeSimulation


def _refuse_unknown(
    changes: Mapping[str, Any], solver: Callable[..., Any], others: Collection[str] = ()
) -> None:
    known = [*inspect.signature(solver).parameters, *others]
    for name in changes:
        if name not in known:
            raise InputError(
                f"{name} is no option of a method{nearest(name, known)}; there are "
                f"{', '.join(sorted(known))}"
            )


def _merged(
    before: tuple[tuple[str, Any], ...], changes: Mapping[str, Any]
) -> tuple[tuple[str, Any], ...]:
    return tuple((dict(before) | dict(changes)).items())


@dataclass(frozen=True)
class Method:
    """A named way to solve a scene, and how it is drawn: the same in every study.

    ``look`` are keywords of a line; ``label`` says in a few words what it is.
    """

    name: str
    label: str
    colour: str
    marker: str
    recipe: Recipe
    line: str = "-"

    def simulation(self, scene: Scene, *, spacing: Spacing) -> Any:
        """A solver of ``scene`` with particles or nodes ``spacing`` [m] apart."""
        return self.recipe.build(scene, spacing)

    @property
    def look(self) -> dict[str, Any]:
        """Keywords of a line in a figure."""
        return {"color": self.colour, "marker": self.marker, "linestyle": self.line}

    def but(
        self,
        *,
        name: str = "",
        label: str = "",
        colour: str = "",
        marker: str = "",
        line: str = "",
        **changes: Any,
    ) -> Method:
        """The same with other options; its name says which, unless ``name`` is given."""
        made = name or ", ".join([self.name, *(_said(*change) for change in changes.items())])
        return Method(
            name=made,
            label=label or made,
            colour=colour or self.colour,
            marker=marker or self.marker,
            recipe=self.recipe.but(changes),
            line=line or self.line,
        )


#: Options whose value says by its name what it is.
_SPEAK_FOR_THEMSELVES = (
    "formulation", "stabilisation", "secondary", "integrator", "operator", "element", "smoothing",
    "angular_momentum", "weighting", "initial_strain",
)  # fmt: skip


def _said(option: str, value: Any) -> str:
    """``{p,F,J}``, ``tau_p = 0``, ``tau_F = 0.5 h/c_p``, ``tau_F x 2``, ``CFL 0.5``."""
    if isinstance(value, Times):
        return f"{option} x {value.factor:g}"
    if option == "cfl":
        return f"CFL {value:g}" if isinstance(value, float) else f"CFL {value}"
    if isinstance(value, IntrinsicTime):
        return f"{option} = {said(value)}"
    if option in _SPEAK_FOR_THEMSELVES:
        return str(getattr(value, "name", None) or repr(value)).removesuffix("()")
    return f"{option} = {value:g}" if isinstance(value, float | int) else f"{option} = {value!r}"


def said(time: IntrinsicTime | float) -> str:
    """``0.5 h/c_p``, ``0.1 dt``, ``0``."""
    known = as_time(time)
    return f"{known.c:.3g} {known.unit}" if known.c else "0"


#: What a user gets who chooses nothing.
PACKAGE = Method("package default", "package default", VERMILION, "o", Particles())
#: The package default with differences of one order along the lines of a box lattice.
LATTICE = {
    order: PACKAGE.but(
        name=f"lattice order {order}", colour=colour, marker=marker,
        operator=sph.LatticeDifference(order=order),
    )
    for order, colour, marker in ((2, PURPLE, "<"), (4, VERMILION, "h"), (6, ORANGE, ">"))
}  # fmt: skip
#: The SUPG methods as the package sets them: the self-adjoint weighting, position Verlet.
SUPG = Method(
    "self-adjoint SUPG", "self-adjoint SUPG", GREEN, "p",
    Particles(supg=(("weighting", sph.SelfAdjoint()),)),
)  # fmt: skip
#: Integrator, step and weighting of the paper; each of its scenes has its own intrinsic times.
PAPER = Method(
    "paper",
    "[Lee2017]: SUPG-SPH H1, TVD-RK2 at CFL 0.3",
    BLUE,
    "s",
    Particles(
        (
            ("stabilisation", sph.SUPG(tau_F=sph.OfStep(1.0), xi_F=0.0, tau_p=sph.OfStep(0.0))),
            ("integrator", sph.TVDRK2()),
            ("cfl", 0.3),
        )
    ),
)
#: The same without its stabilisation.
UNSTABILISED = SUPG.but(
    name="unstabilised", colour=PURPLE, marker="v", stabilisation=sph.NoStabilisation()
)
#: The classical method: F from the positions, no stabilisation.
DISPLACEMENT = UNSTABILISED.but(
    name="displacement SPH", colour=ORANGE, marker="X", formulation=sph.Displacement()
)
#: Displacement SPH as people run it: springs of pairs against hourglass modes, on our operators ...
HOURGLASS = DISPLACEMENT.but(
    name="hourglass-controlled SPH", colour=SKY, marker="d", stabilisation=sph.HourglassControl(),
)  # fmt: skip
#: ... and with the gradient, kernel and smoothing length of the codes that ship it.
HOURGLASS_AS_SHIPPED = HOURGLASS.but(
    name="hourglass-controlled SPH, as shipped", marker="D", line="--",
    operator=sph.Literal("kernel"), smoothing=sph.CubicSpline(), h_over_dx=2.0**0.5,
)  # fmt: skip
#: Earlier methods of the paper's authors, with their integrator and step.
JST = PAPER.but(
    name="JST-SPH", colour=BLACK, marker="v", line="--", stabilisation=sph.JST(),
    smoothing=sph.CubicSpline(), h_over_dx=1.0, angular_momentum=sph.NoProjection(),
)  # fmt: skip
UPWIND = JST.but(
    name="upwind SPH", colour=YELLOW, marker="^", line="-", stabilisation=sph.Upwind()
)
UPWIND_LIMITED = UPWIND.but(
    name="upwind SPH, limited", marker="<", line=":", stabilisation=sph.Upwind("limited")
)
B_BAR = Method("B-bar FEM", "B-bar FEM", BLACK, "D", Elements(), line="-.")
TAYLOR_HOOD = Method(
    "Taylor-Hood FEM", "Taylor-Hood FEM", SKY, "P",
    Elements((("element", fem.TaylorHoodHex()),), edge=2), line="-.",
)  # fmt: skip
Q1 = Method(
    "Q1 FEM", "Q1 FEM, full integration", BLACK, "x",
    Elements((("element", fem.FullHex()),)), line=":",
)  # fmt: skip
NODAL_PRESSURE = Method(
    "nodal pressure FEM", "tetrahedra, average nodal pressure", ORANGE, "*",
    Elements((("element", fem.NodalPressureTet()),)), line="-.",
)  # fmt: skip
PG_FEM = Method("PG-FEM", "PG-FEM, tetrahedra", BLUE, "h", MixedElements(), line="-.")
PG_FEM_HEX = Method(
    "PG-FEM, hexahedra", "PG-FEM, hexahedra", BLUE, "H",
    MixedElements((("method", fem.PGFEM(cells=fem.Hexahedra())),)), line=":",
)  # fmt: skip
C_TOUCH = Method("C-TOUCH", "C-TOUCH finite volumes", PURPLE, "8", FiniteVolumes(), line="-.")

METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        PACKAGE, *LATTICE.values(), SUPG, PAPER, UNSTABILISED, DISPLACEMENT, HOURGLASS,
        HOURGLASS_AS_SHIPPED, JST, UPWIND, UPWIND_LIMITED, B_BAR, TAYLOR_HOOD, Q1, NODAL_PRESSURE,
        PG_FEM, PG_FEM_HEX, C_TOUCH,
    )
}  # fmt: skip


def method(name: str) -> Method:
    """The registered method of this name; raises ``InputError`` where there is none."""
    if name not in METHODS:
        raise InputError(f"no method {name!r}; there are {', '.join(METHODS)}")
    return METHODS[name]
