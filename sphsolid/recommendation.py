"""Which formulation and stabilisation to use for a scene, and why.

The displacement form with a restraint is the one that holds its shape in every hard case of
``studies.stability``.  What it costs and how accurate it is beside all others, and the choice among
SUPG methods, are evidence of ``studies.pareto`` in ``recommendations.csv``.  For each Poisson's
ratio the family ``supg`` has the cheapest formulation whose error at equal particles is within a
tenth of the best, on the swinging cube and on the twisting column; the family ``restraint`` has the
displacement form.  No material there depends on the cofactor.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path

from sphsolid.cloud.secondary import H6
from sphsolid.defaults import default_supg, poisson_ratio
from sphsolid.errors import require
from sphsolid.scenes.scene import Scene, check_scene
from sphsolid.scheme.formulation import PF, PFHJ, PFJ, Displacement, Formulation
from sphsolid.scheme.restraint import Restraint
from sphsolid.scheme.stabilisation import NoStabilisation, Stabilisation

#: Data, made from ``reports/pareto/recommendation.csv`` (a test compares them).
RECOMMENDATIONS = Path(__file__).with_name("recommendations.csv")
#: Rows of the table that hold for all of its scenes.
EVERY_SCENE = "all"
#: Families of rows; a table without that column has SUPG methods alone.
SUPG_METHODS, RESTRAINED = "supg", "restraint"
_FORMULATIONS: dict[str, Formulation] = {
    each.name: each for each in (PF(), PFJ(), PFHJ(), Displacement())
}


@dataclass(frozen=True)
class Evidence:
    """A row of the table: ``error_ratio`` is the worst error over the best formulation's,
    ``cpu_ratio`` and ``bytes_ratio`` the cost over that of the most accurate one, at ``nu``.
    """

    nu: float
    formulation: str
    stabilisation: str
    error_ratio: float
    cpu_ratio: float
    bytes_ratio: float


@dataclass(frozen=True)
class NotMeasured:
    """The table has no material of this kind."""


@dataclass(frozen=True)
class Recommendation:
    """What to use, the reason in one sentence, and the row it rests on."""

    formulation: Formulation
    stabilisation: Stabilisation
    reason: str
    evidence: Evidence | NotMeasured


def recommend(scene: Scene) -> Recommendation:
    """The formulation and stabilisation for ``scene``: the displacement form with a restraint.

    Raises ``InputError`` for what is no scene.
    """
    check_scene(scene)
    material, nu = scene.material, poisson_ratio(scene.material)
    reason = (
        "displacement form with a restraint: it holds its shape in the hard cases of "
        "studies.stability, in which positions of SUPG methods fold"
    )
    row = NotMeasured() if material.depends_on_H else _row_of(nu, RESTRAINED)
    if isinstance(row, Evidence):
        reason += f"; {_numbers(row, nu)}"
    return Recommendation(Displacement(), Restraint(), reason, row)


def recommend_supg(scene: Scene) -> Recommendation:
    """The same among the SUPG methods, from the material of ``scene``.

    A law that depends on the cofactor gets {p, F, H, J} as in [Lee2017]; any other what the table
    says at the next larger Poisson's ratio that was tried, and above all of them at the largest.
    """
    check_scene(scene)
    material, nu = scene.material, poisson_ratio(scene.material)
    if material.depends_on_H:
        full = PFHJ()
        reason = (
            f"{full.name}: the energy depends on the cofactor, whose law is then solved as "
            "published; studies.pareto has no such material"
        )
        return Recommendation(full, default_supg(full, material), reason, NotMeasured())
    row = _row_of(nu, SUPG_METHODS)
    require(
        isinstance(row, Evidence),
        f"{RECOMMENDATIONS} has no row of the family {SUPG_METHODS} for every scene; copy it from "
        "a report of studies.pareto",
    )
    assert isinstance(row, Evidence)
    fields = _FORMULATIONS[row.formulation]
    stabilisation: Stabilisation = NoStabilisation()
    if row.stabilisation != "none":
        supg = default_supg(fields, material)
        stabilisation = replace(supg, secondary=H6()) if row.stabilisation == "SUPG-H6" else supg
    return Recommendation(fields, stabilisation, _reason(row, nu), row)


def _reason(row: Evidence, nu: float) -> str:
    words = "without stabilisation" if row.stabilisation == "none" else f"with {row.stabilisation}"
    return f"{row.formulation} {words}: {_numbers(row, nu)}"


def _numbers(row: Evidence, nu: float) -> str:
    tried = f"nu = {row.nu:g}"
    if abs(nu - row.nu) > 5e-4:
        tried += f" (the next tried above {nu:.4g})" if nu < row.nu else " (the largest tried)"
    error = (
        "has the smallest error"
        if row.error_ratio < 1.005
        else f"has {row.error_ratio:.2f} times the smallest error"
    )
    return (
        f"in studies.pareto at {tried} it {error} at equal particles "
        f"and takes {row.cpu_ratio:.2f} times the CPU time and {row.bytes_ratio:.2f} times the "
        "memory of the most accurate formulation"
    )


def _row_of(nu: float, family: str) -> Evidence | NotMeasured:
    with RECOMMENDATIONS.open(encoding="utf-8", newline="") as file:
        rows = [
            Evidence(
                nu=float(row["nu"]),
                formulation=row["formulation"],
                stabilisation=row["stabilisation"],
                error_ratio=float(row["error_ratio"]),
                cpu_ratio=float(row["cpu_ratio"]),
                bytes_ratio=float(row["bytes_ratio"]),
            )
            for row in csv.DictReader(file)
            if row["scene"] == EVERY_SCENE and row.get("family", SUPG_METHODS) == family
        ]
    if not rows:
        return NotMeasured()
    rows.sort(key=lambda row: row.nu)
    return next((row for row in rows if row.nu >= nu - 1e-9), rows[-1])
