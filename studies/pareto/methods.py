"""The methods that are compared, as the registry makes them; a new one is a line here."""

from __future__ import annotations

import itertools
from typing import Any

import sphsolid as sph
from sphsolid.defaults import NEARLY_INCOMPRESSIBLE
from sphsolid.scheme.formulation import Formulation
from studies.methods import B_BAR, DISPLACEMENT, PAPER, SUPG, TAYLOR_HOOD, UNSTABILISED, Method

MARKERS = {sph.PF(): "o", sph.PFJ(): "^", sph.PFHJ(): "s"}
PF, PFJ, PFHJ = MARKERS
H6, NO_PROJECTION = sph.H6(), sph.NoProjection()


def _of(base: Method, formulation: Formulation, line: str = "", **changes: Any) -> Method:
    marker = MARKERS[formulation]
    return base.but(formulation=formulation, marker=marker, line=line, **changes)


MIXED = {formulation: _of(SUPG, formulation) for formulation in MARKERS}
DENSE = {formulation: _of(SUPG, formulation, "--", secondary=H6) for formulation in MARKERS}
PLAIN = {formulation: _of(UNSTABILISED, formulation) for formulation in MARKERS}
#: What may be recommended: the package's integrator and projection, any formulation.
CANDIDATES = (*MIXED.values(), DENSE[PF], DENSE[PFJ], PLAIN[PF], DISPLACEMENT)
#: Methods whose limits make the reference of the column, one of each kind.
REFERENCES = (B_BAR, MIXED[PFJ])


def compared(nu: float) -> tuple[Method, ...]:
    """Every method at a Poisson's ratio, on which the paper's ``tau_p`` depends."""
    tau_p = sph.OfStep(0.1 if nu >= NEARLY_INCOMPRESSIBLE else 0.0)
    return (
        *CANDIDATES,
        *(_of(SUPG, fields, ":", integrator=sph.SSPRK3()) for fields in (PF, PFJ)),
        _of(PAPER, PF),
        _of(PAPER, PFJ).but(name=_of(PAPER, PFJ).name, tau_p=tau_p),
        B_BAR,
        TAYLOR_HOOD,
    )


def options() -> tuple[Method, ...]:
    """Formulation x stabilisation x projection: what each option costs and gives."""
    families = (PLAIN, MIXED, DENSE)
    kinds = [family[fields] for fields, family in itertools.product(MARKERS, families)]
    unprojected = [method.but(angular_momentum=NO_PROJECTION) for method in kinds]
    return (*itertools.chain(*zip(kinds, unprojected, strict=True)), DISPLACEMENT)


def goes_finest(method: Method, nu: float) -> bool:
    """Whether a method is run on the cube's finest lattice, the dearest runs of the study."""
    fields = (PFJ,) if nu >= 0.45 else (PF, PFJ)
    return method in (B_BAR, TAYLOR_HOOD, *(MIXED[each] for each in fields))
