"""What a simulation uses where nothing is given, and the evidence for it.

Every value comes from a study that can be run again; ``docs/stability.md`` has the reasoning.

* **Integrator**: position Verlet.  One evaluation a step at a CFL number of 0.7: four times fewer
  evaluations than SSP-RK3 for the same time and, in every scene tried, the same accuracy.  The
  paper's two stages let a mode grow at every free corner (``studies.stability``).
* **CFL** 0.7: below the limit of every material and formulation (0.81 at least; ``tau_p`` lets
  modes of free blocks grow tenfold in more than 1000 steps); ``plan()`` prints the limits,
  ``cfl="auto"`` takes nine tenths of them.
* **h/dx**: the smallest support is the most accurate one that is solvable: 19 neighbours on a
  lattice (``studies.operators``, ``studies.stability``).  1.0 for summation by parts: with less,
  few and chance neighbours make it hard to solve for.  1.1 where a restraint acts: with more
  neighbours the stress is more accurate, and a step little dearer (``studies.restraint``).
* **Form**: displacement form with a restraint of the motion that the gradient does not see.  SUPG
  methods give that motion no stiffness: their positions fold in the hard cases of
  ``studies.stability``.  They stay the default of the formulations that evolve a strain.
* **Operator**: on a box lattice ``LatticeDifference`` for the displacement form; ``Consistent`` on
  any other lattice and for SUPG; on any other cloud ``SummationByParts``, the one that is second
  order there (``studies.convergence --cloud``).
* **Initial strain**, where a scene states one: ``Equilibrated`` with summation by parts, whose
  momentum has the order 1.7 on disordered clouds otherwise and 2 with it (``studies.clouds``);
  ``Compatible`` where force and gradient are adjoint, ``Given`` where they are not.
* **SelfAdjoint weighting**: ``D(p)`` as printed makes energy when ``tau_F`` is longer than about
  ``0.3 h / c_p``, and lets modes grow slowly at a free corner; the self-adjoint form cannot.
* **tau_F = min(0.5, 5 c_s / c_p) h / c_p**, a time of the solid and the spacing, not of the step:
  results then do not depend on the step.  ``tau_F gamma`` is a viscosity, hence the shear wave
  speed near ``nu = 1/2`` (``studies.stability``).  **xi_F = 0**: a time-integrated residual costs
  the stress its second order at boundaries (``studies.convergence``).
* **tau_p = 0.1 dt** where ``J`` is evolved and ``nu >= 0.49``, ``dt`` the step that the CFL rule
  allows: the paper's; on a fine twisting column it takes the alternating part out of the pressure
  (``studies.twisting_column``).  ``D(J)`` is not a definite form either, and makes energy at
  smaller ``nu`` (``studies.stability``).
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sphsolid.cloud.first_possible import Candidate
from sphsolid.cloud.lattice.box import BoxLattice, box_of
from sphsolid.cloud.lattice_difference import LatticeDifference
from sphsolid.cloud.operator import Consistent, OperatorKind, SummationByParts
from sphsolid.cloud.secondary import H1, SecondaryPoints
from sphsolid.errors import InputError
from sphsolid.geometry.mesh import Mesh
from sphsolid.scheme.dilatation import Dilatation, FilteredDilatation, OwnDilatation
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.initial_strain import Compatible, Equilibrated, Given, InitialStrain
from sphsolid.scheme.integrator import Integrator as Integrator
from sphsolid.scheme.intrinsic_time import OfMesh, OfStep
from sphsolid.scheme.position_verlet import PositionVerlet
from sphsolid.scheme.restraint import Restraint
from sphsolid.scheme.stabilisation import SUPG, SelfAdjoint, Stabilisation

#: Smoothing length over spacing (Wendland C2: support 1.54, 1.8, 2 and 2.2 spacings).
H_OVER_DX_LATTICE = 0.77
H_OVER_DX_DISORDERED = 0.9
H_OVER_DX_BY_PARTS = 1.0
H_OVER_DX_RESTRAINED = 1.1
#: Where nothing else can be built: second neighbours on all sides of flat cells.
H_OVER_DX_WIDE = 1.3

#: Poisson's ratio from which ``tau_p`` is used.
NEARLY_INCOMPRESSIBLE = 0.49

#: Share of the limit that ``cfl="auto"`` takes: limits are those of a body at rest.
MARGIN = 0.9

#: Where the modes of a free lattice block at rest grow, with the settings of this file: data, made
#: from ``reports/stability/limits.csv`` (a test compares them).
LIMITS = Path(__file__).with_name("stability_limits.csv")


@dataclass(frozen=True)
class StabilityLimit:
    """CFL numbers above which a mode grows tenfold in 1000 (``slow``) or 50 (``fast``) steps."""

    slow: float
    fast: float


def default_integrator() -> Integrator:
    """Position Verlet."""
    return PositionVerlet()


def default_dilatation(formulation: Formulation, terms: Sequence[object]) -> Dilatation:
    """A filtered one in the displacement form with a restraint, each particle's own elsewhere.

    Never a second one: that of ``terms`` is the one that acts.
    """
    given = any(isinstance(term, FilteredDilatation) for term in terms)
    filtered = is_restrained(formulation, terms) and not given
    return FilteredDilatation() if filtered else OwnDilatation()


def is_restraint(stabilisation: object) -> bool:
    """True for the option that gives unseen motion a stiffness."""
    return isinstance(stabilisation, Restraint)


def is_restrained(formulation: Formulation, terms: Sequence[object]) -> bool:
    """True for the displacement form with a restraint among its terms, stabilisation included."""
    return is_displacement_form(formulation) and any(map(is_restraint, terms))


def default_cfl(integrator: Integrator) -> float:
    """CFL number of an integrator; 0.3 is the paper's for its own."""
    return integrator.usual_cfl


def default_operator(mesh: Mesh, *, restrained: bool = False) -> OperatorKind:
    """``Consistent`` on a lattice, ``SummationByParts`` on any other cloud.

    ``LatticeDifference`` on a box lattice where the motion that it does not see is ``restrained``.
    """
    if restrained and isinstance(box_of(mesh), BoxLattice):
        return LatticeDifference()
    return Consistent() if mesh.is_lattice else SummationByParts()


def default_h_over_dx(mesh: Mesh, operator: OperatorKind, *, restrained: bool = False) -> float:
    """Smoothing length over spacing; ``restrained`` where unseen motion has a stiffness."""
    if mesh.is_lattice:
        return H_OVER_DX_LATTICE
    if not isinstance(operator, SummationByParts):
        return H_OVER_DX_DISORDERED
    return H_OVER_DX_RESTRAINED if restrained else H_OVER_DX_BY_PARTS


def operator_candidates(
    mesh: Mesh, operator: OperatorKind | None, h_over_dx: float | None, *, restrained: bool = False
) -> list[Candidate]:
    """What to build, in the order of preference: one candidate where the operator is given.

    By default a disordered cloud falls back on ``Consistent``, with a wider support at last.
    """

    def candidate(kind: OperatorKind) -> Candidate:
        usual = default_h_over_dx(mesh, kind, restrained=restrained)
        return Candidate(kind, usual if h_over_dx is None else h_over_dx)

    if operator is not None:
        return [candidate(operator)]
    candidates = [candidate(default_operator(mesh, restrained=restrained))]
    if not mesh.is_lattice:
        candidates.append(candidate(Consistent()))
        if h_over_dx is None:
            candidates.append(Candidate(Consistent(), H_OVER_DX_WIDE))
    return candidates


def default_initial_strain(
    operator: OperatorKind, formulation: Formulation, *, adjoint: bool
) -> InitialStrain:
    """How to start where the scene states a strain (see ``scheme.initial_strain``)."""
    if isinstance(operator, SummationByParts):
        return Equilibrated()
    return Compatible() if adjoint or not formulation.evolves_F else Given()


def poisson_ratio(material: Any) -> float:
    """``nu = (3 kappa - 2 mu) / (6 kappa + 2 mu)`` of the undeformed solid."""
    mu, kappa = material.mu, material.kappa
    return float((3.0 * kappa - 2.0 * mu) / (6.0 * kappa + 2.0 * mu))


def default_stabilisation(
    formulation: Formulation, material: Any, *, secondary: SecondaryPoints | None = None
) -> Stabilisation:
    """A restraint where every strain comes from the positions, else :func:`default_supg`."""
    if is_displacement_form(formulation):
        return Restraint()
    return default_supg(formulation, material, secondary=secondary)


def is_displacement_form(formulation: Formulation) -> bool:
    """True where the state is positions and momenta alone."""
    return not (formulation.evolves_F or formulation.evolves_H or formulation.evolves_J)


def default_supg(
    formulation: Formulation, material: Any, *, secondary: SecondaryPoints | None = None
) -> SUPG:
    """Self-adjoint SUPG with ``tau_F = min(0.5, 5 c_s / c_p) h / c_p``, whatever the step.

    ``tau_p = 0.1 dt`` where ``J`` is evolved and ``nu >= 0.49``; ``H1`` when not given.
    """
    speeds = (material.mu / (material.kappa + 4.0 / 3.0 * material.mu)) ** 0.5
    damps_J = formulation.evolves_J and poisson_ratio(material) >= NEARLY_INCOMPRESSIBLE
    return SUPG(
        tau_F=OfMesh(min(0.5, 5.0 * speeds)),
        xi_F=0.0,
        tau_p=OfStep(0.1 if damps_J else 0.0),
        weighting=SelfAdjoint(),
        secondary=H1() if secondary is None else secondary,
    )


@dataclass(frozen=True)
class NotTabulated:
    """``studies.stability`` has no row for this integrator and formulation."""


def stability_limit(
    integrator: Integrator, formulation: Formulation, material: Any
) -> StabilityLimit | NotTabulated:
    """Measured limit of the default settings: that of the next larger Poisson's ratio tried."""
    if is_displacement_form(formulation):
        # The map is of SUPG, whose step counts distances, not the highest frequency.
        return NotTabulated()
    law = "{p,F,J}" if formulation.evolves_J else "{p,F}"
    with LIMITS.open(encoding="utf-8", newline="") as file:
        rows = [
            (float(row["nu"]), StabilityLimit(float(row["slow"]), float(row["fast"])))
            for row in csv.DictReader(file)
            if (row["integrator"], row["formulation"]) == (integrator.name, law)
        ]
    if not rows:
        return NotTabulated()
    rows.sort(key=lambda row: row[0])
    nu = poisson_ratio(material)
    return next((limit for ratio, limit in rows if ratio >= nu - 1e-9), rows[-1][1])


def largest_stable_cfl(
    integrator: Integrator, formulation: Formulation, material: Any
) -> float:
    """``MARGIN`` times the CFL number above which a mode grows, with the default settings.

    Raises ``InputError`` where the stability map has no such method.
    """
    limit = stability_limit(integrator, formulation, material)
    if isinstance(limit, NotTabulated):
        raise InputError(
            f"cfl = 'auto': the stability map has no {formulation.name} with {integrator.name}; "
            f"give a number ({default_cfl(integrator):g} is the default) or run "
            "python -m studies.stability"
        )
    return MARGIN * limit.slow
