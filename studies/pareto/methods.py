"""The methods that are compared, as the registry makes them; a new one is a line here."""

from __future__ import annotations

import itertools
from typing import Any

import sphsolid as sph
from sphsolid.defaults import NEARLY_INCOMPRESSIBLE
from sphsolid.scheme.formulation import Formulation
from studies.methods import (
    B_BAR,
    DISPLACEMENT,
    LATTICE,
    PACKAGE,
    PAPER,
    SUPG,
    TAYLOR_HOOD,
    UNSTABILISED,
    Method,
)
from studies.pareto.problems import CUBE, FAIR, LINEAR_FAIR, PROBLEMS, PULSE, VIBRATION

MARKERS = {sph.PF(): "o", sph.PFJ(): "^", sph.PFHJ(): "s"}
PF, PFJ, PFHJ = MARKERS
H6, NO_PROJECTION = sph.H6(), sph.NoProjection()


def _of(base: Method, formulation: Formulation, line: str = "", **changes: Any) -> Method:
    marker = MARKERS[formulation]
    return base.but(formulation=formulation, marker=marker, line=line, **changes)


MIXED = {formulation: _of(SUPG, formulation) for formulation in MARKERS}
DENSE = {formulation: _of(SUPG, formulation, "--", secondary=H6) for formulation in MARKERS}
PLAIN = {formulation: _of(UNSTABILISED, formulation) for formulation in MARKERS}
#: Differences along the lines of a lattice: the default's order, and the others.
LATTICES = (
    PACKAGE,
    *(method for order, method in LATTICE.items() if order != sph.LatticeDifference().order),
    # An integrator of order four: LATTICE[6].but(integrator=sph....(), line="--").
)
#: The SUPG methods among which one is recommended: the package's integrator and projection.
CANDIDATES = (*MIXED.values(), DENSE[PF], DENSE[PFJ], PLAIN[PF], DISPLACEMENT)
#: Methods whose limits make the reference of the column, one of each kind.
REFERENCES = (B_BAR, MIXED[PFJ])


def papers(nu: float) -> tuple[Method, ...]:
    """The paper's, whose ``tau_p`` depends on Poisson's ratio."""
    tau_p = sph.OfStep(0.1 if nu >= NEARLY_INCOMPRESSIBLE else 0.0)
    with_J = _of(PAPER, PFJ)
    return _of(PAPER, PF), with_J.but(name=with_J.name, tau_p=tau_p)


def compared(nu: float) -> tuple[Method, ...]:
    """Every method at a Poisson's ratio."""
    return (
        *LATTICES,
        *CANDIDATES,
        *(_of(SUPG, fields, ":", integrator=sph.SSPRK3()) for fields in (PF, PFJ)),
        *papers(nu),
        B_BAR,
        TAYLOR_HOOD,
    )


def front(nu: float) -> tuple[Method, ...]:
    """What the figures show."""
    return *LATTICES, MIXED[PF], MIXED[PFJ], papers(nu)[1], B_BAR, TAYLOR_HOOD


def methods_of(scene: str, nu: float) -> tuple[Method, ...]:
    """Who runs a problem.  Off the lattice: B-bar elements alone, on as many nodes."""
    problem = PROBLEMS[scene]
    if not problem.on_lattice:
        return PACKAGE, MIXED[PF], MIXED[PFJ], B_BAR
    paper = papers(nu)[1]
    return compared(nu) if problem.everyone else tuple(m for m in front(nu) if m != paper)


def options() -> tuple[Method, ...]:
    """Formulation x stabilisation x projection: what each option costs and gives."""
    families = (PLAIN, MIXED, DENSE)
    kinds = [family[fields] for fields, family in itertools.product(MARKERS, families)]
    unprojected = [method.but(angular_momentum=NO_PROJECTION) for method in kinds]
    return (*itertools.chain(*zip(kinds, unprojected, strict=True)), DISPLACEMENT)


def goes_finest(scene: str, method: Method, nu: float) -> bool:
    """Whether a method is run on the finest lattice of a problem, the dearest runs of the study.

    Elements need it to reach a thousandth, and to cost what particles do; the linear limit has no
    loads and is cheaper.
    """
    if scene == CUBE:
        fields = (PFJ,) if nu >= 0.45 else (PF, PFJ)
        return method in (B_BAR, TAYLOR_HOOD, *(MIXED[each] for each in fields))
    if scene == LINEAR_FAIR and nu < 0.45:
        return method in (B_BAR, TAYLOR_HOOD, *LATTICES)
    others = scene in (FAIR, LINEAR_FAIR, VIBRATION, PULSE) and nu < 0.499
    return others and method in (B_BAR, TAYLOR_HOOD)
