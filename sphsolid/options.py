"""The options of a simulation: what the user gave, checked, and what is chosen where nothing is."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any
from typing import Literal as OneOf

from sphsolid.cloud.cloud import Cloud
from sphsolid.cloud.first_possible import Candidate, first_possible
from sphsolid.cloud.lattice_difference import LatticeDifference
from sphsolid.cloud.long_cells import doubts
from sphsolid.cloud.operator import OperatorKind, check_operator
from sphsolid.cloud.secondary import default_secondary
from sphsolid.cloud.smoothing import SmoothingFunction, WendlandC2, check_smoothing
from sphsolid.continuum.check_law import check_first_use
from sphsolid.defaults import (
    default_cfl,
    default_dilatation,
    default_integrator,
    default_stabilisation,
    is_restrained,
    is_restraint,
    largest_stable_cfl,
    operator_candidates,
)
from sphsolid.errors import InputError, require
from sphsolid.geometry.body import Spacing
from sphsolid.geometry.mesh import Mesh
from sphsolid.recommendation import Recommendation, recommend, recommend_supg
from sphsolid.record.probes import check_probes
from sphsolid.scenes.checks import as_float, number
from sphsolid.scenes.scene import Scene, check_scene
from sphsolid.scheme.dilatation import Dilatation, FilteredDilatation, check_dilatation
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.initial_strain import InitialStrain, check_initial_strain
from sphsolid.scheme.integrator import Integrator, check_integrator
from sphsolid.scheme.projection import AngularMomentumTreatment, LocalProjection, check_projection
from sphsolid.scheme.stabilisation import Stabilisation, check_formulation, check_pair
from sphsolid.scheme.term import TermOption, check_term_option
from sphsolid.scheme.time_step import check_cfl

#: What is chosen from the scene where nothing is given.
CHOSEN = (
    "stabilisation", "dilatation", "h_over_dx", "integrator", "cfl", "formulation", "operator",
    "smoothing",
)  # fmt: skip


@dataclass(frozen=True)
class Options:
    """What the user gave; ``None`` where it is left to ``sphsolid.defaults``."""

    spacing: Spacing
    formulation: Formulation | None
    stabilisation: Stabilisation | None
    dilatation: Dilatation | None
    terms: Sequence[TermOption]
    operator: OperatorKind | None
    smoothing: SmoothingFunction | None
    h_over_dx: float | None
    cfl: float | OneOf["auto"] | None
    angular_momentum: AngularMomentumTreatment | None
    initial_strain: InitialStrain | None
    integrator: Integrator | None

    def __post_init__(self) -> None:
        """Numbers as floats; raises ``InputError`` for classes in the place of objects."""
        for name in ("spacing", "h_over_dx", "cfl"):
            object.__setattr__(self, name, as_float(getattr(self, name)))
        for name, value in self.given.items():
            if isinstance(value, type):
                raise InputError(f"{name} = {value.__name__} is a class; write {value.__name__}()")
        terms: object = self.terms
        if not isinstance(terms, list | tuple):
            raise InputError(f"terms = {terms!r} is no list; write terms=[...]")
        object.__setattr__(self, "terms", tuple(terms))

    @property
    def given(self) -> dict[str, Any]:
        """By name, as keywords of a simulation."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @property
    def by_default(self) -> tuple[str, ...]:
        """What was left to ``sphsolid.defaults``."""
        return tuple(name for name in CHOSEN if getattr(self, name) is None)


@dataclass(frozen=True)
class Method:
    """Everything that is chosen before there are particles."""

    material: Any
    integrator: Integrator
    advice: Recommendation
    formulation: Formulation
    cfl: float
    mesh: Mesh
    stabilisation: Stabilisation
    dilatation: Dilatation
    terms: tuple[TermOption, ...]
    angular_momentum: AngularMomentumTreatment


def choose(scene: Scene, options: Options) -> Method:
    """Check every option and fill in the defaults; raises ``InputError`` before anything is built.

    Cheap checks come first, the mesh late.
    """
    check_scene(scene)
    if options.h_over_dx is not None:
        number("h_over_dx", options.h_over_dx, "spacings")
    material = check_first_use(scene.material)
    integrator = default_integrator() if options.integrator is None else options.integrator
    check_integrator(integrator)
    advice = _advice(scene, options)
    formulation = advice.formulation if options.formulation is None else options.formulation
    check_formulation(formulation)
    cfl = _cfl(options, integrator, formulation, material)
    if options.stabilisation is not None:
        check_pair(formulation, options.stabilisation)
    if options.dilatation is not None:
        check_dilatation(formulation, options.dilatation)
    for term in options.terms:
        check_term_option("a member of terms", term, "use SUPG(...)")
        term.check(formulation)
    treatment = LocalProjection() if options.angular_momentum is None else options.angular_momentum
    check_projection(treatment)
    _check_discretisation(options)
    mesh = scene.body.mesh(options.spacing)
    check_probes(scene, mesh)
    stabilisation: Stabilisation | None = options.stabilisation
    if stabilisation is None:
        stabilisation = default_stabilisation(
            formulation, material, secondary=default_secondary(mesh)
        )
        check_pair(formulation, stabilisation)
    dilatation = options.dilatation
    if dilatation is None:
        dilatation = default_dilatation(formulation, (stabilisation, *options.terms))
    _check_one_filter(dilatation, options.terms)
    return Method(
        material, integrator, advice, formulation, cfl, mesh, stabilisation, dilatation,
        tuple(options.terms), treatment,
    )  # fmt: skip


def _check_one_filter(dilatation: Dilatation, terms: Sequence[TermOption]) -> None:
    """Each takes ``U(J)`` away and puts ``U(S J)`` in its place: of two, the energy is negative."""
    filters = [each for each in (dilatation, *terms) if isinstance(each, FilteredDilatation)]
    require(
        len(filters) < 2,
        f"{len(filters)} filtered dilatations ({', '.join(map(repr, filters))}): the volumetric "
        "energy sees one Jacobian; give one, as dilatation=FilteredDilatation(...)",
    )


def _advice(scene: Scene, options: Options) -> Recommendation:
    """What is recommended with the stabilisation that was given, if one was."""
    given = options.stabilisation
    return recommend(scene) if given is None or is_restraint(given) else recommend_supg(scene)


def _cfl(
    options: Options, integrator: Integrator, formulation: Formulation, material: Any
) -> float:
    cfl = options.cfl
    if cfl == "auto":
        cfl = largest_stable_cfl(integrator, formulation, material)
    cfl = default_cfl(integrator) if cfl is None else cfl
    if isinstance(cfl, bool):
        raise InputError(f"cfl = {cfl} is not a number; 0.3 is the paper's value")
    check_cfl(cfl)
    return cfl


def _check_discretisation(options: Options) -> None:
    if options.smoothing is not None:
        check_smoothing(options.smoothing)
    if options.operator is not None:
        check_operator(options.operator)
    if options.initial_strain is not None:
        check_initial_strain(options.initial_strain)


@dataclass(frozen=True)
class Discretised:
    """The particles and what they were built with."""

    cloud: Cloud
    operator: OperatorKind
    h_over_dx: float
    #: Operators that the default tried before this one, and why each was refused.
    refused: tuple[tuple[Candidate, str], ...]
    #: What makes the operators doubtful on this mesh.
    doubts: tuple[str, ...]


def discretised(method: Method, options: Options) -> Discretised:
    """Particles of ``method`` with the first operator that exists; warns of what is doubtful."""
    restrained = is_restrained(method.formulation, (method.stabilisation, *method.terms))
    found = first_possible(
        method.mesh,
        WendlandC2() if options.smoothing is None else options.smoothing,
        operator_candidates(
            method.mesh, options.operator, options.h_over_dx, restrained=restrained
        ),
    )
    if restrained:
        _refuse_unused(found.candidate.operator, options)
    doubtful = tuple(doubts(found.cloud))
    if doubtful:
        warnings.warn("; ".join(doubtful), stacklevel=3)
    candidate = found.candidate
    return Discretised(
        found.cloud, candidate.operator, candidate.h_over_dx, found.refused, doubtful
    )


def _refuse_unused(operator: OperatorKind, options: Options) -> None:
    """Along lines no smoothing function is evaluated: whoever gives one expects that it is."""
    given = [name for name in ("h_over_dx", "smoothing") if getattr(options, name) is not None]
    require(
        not (given and isinstance(operator, LatticeDifference)),
        f"{' and '.join(given)} would have no effect: on this box lattice {operator.name} reads "
        "lines of particles; leave it out, or give operator=Consistent() too",
    )
