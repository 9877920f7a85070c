"""Stress concentration at a hole, from mesh files: ``python -m studies.plate_with_hole``.

A quarter plate read from Gmsh files is pulled slowly, by SUPG-SPH on hexahedra and on tetrahedra
and by B-bar finite elements on the same hexahedra.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
import pandas as pd

from sphsolid.scenes import gross_concentration
from studies.harness.cases import Case, Row
from studies.harness.front import Study
from studies.harness.results import Tables
from studies.plate_with_hole.cases import FEM, HALF_WIDTH, RADIUS, SPH
from studies.plate_with_hole.plane import plane_stress_over_pull
from studies.plate_with_hole.report import report
from studies.plate_with_hole.verdicts import verdicts
from studies.report import folding

#: Method, operator and mesh of the runs; the operator of an element method is "-".
RUNS = (
    (FEM, "-", "hex"),
    (SPH, "SummationByParts", "hex"),
    (SPH, "SummationByParts", "tet"),
    (SPH, "Consistent", "hex"),
    (SPH, "Consistent", "tet"),
)
#: Elements along and around of the plane reference.
PLANE_CELLS = 48
_VALUES = [
    "key", "method", "operator", "mesh", "thickness", "particles", "edge_particles",
    "edge_spread", "edge_fit", "highest_particles", "highest_fit", "unrest", "kinetic_share",
    *folding.COLUMNS, "steps", "setup_s", "wall_s",
]  # fmt: skip


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """All in plane strain, the default operator with a free face too; the quick form pulls faster.

    It has plane strain and the default operator only.
    """
    listed = []
    for thickness in ("plane_strain",) if options.quick else ("plane_strain", "free"):
        for method, operator, mesh in RUNS[:3] if options.quick or thickness == "free" else RUNS:
            listed.append(_case(options, method, operator, mesh, thickness, options.quick))
    return listed


def _case(
    options: argparse.Namespace, method: str, operator: str, mesh: str, thickness: str, quick: bool
) -> Case:
    key = f"{method.split()[0]}-{operator}-{mesh}-{thickness}".replace("---", "-")
    arguments = {
        "key": key, "method": method, "operator": operator, "mesh": mesh, "thickness": thickness,
        "rise": 1.5 if quick else 4.0, "hold": 0.75 if quick else 1.0,
        "shots": str(options.out / "shots"),
    }  # fmt: skip
    cost = 1.0 if method == FEM else 8.0
    return Case(key, "studies.plate_with_hole.cases:run_case", arguments, cost=cost)


def warm_up(options: argparse.Namespace) -> Sequence[Case]:
    """Short pulls; they also leave the operators in the cache."""
    made = []
    for method, operator, mesh in RUNS[:3]:
        case = _case(options, method, operator, mesh, "plane_strain", quick=True)
        short = {"rise": 0.01, "hold": 0.01, "shots": str(options.out / "partial")}
        made.append(Case(case.key, case.run, dict(case.arguments) | short, cost=1.0))
    return made


def tables(rows: list[Row]) -> Tables:
    """``table``: a row a run; ``ligament``, ``ring``: curves; ``plane``: the reference's ligament.

    ``against_*`` are relative differences from B-bar of the same reading of the thickness.
    """
    by_kind = {
        kind: pd.DataFrame([row for row in rows if row["kind"] == kind])
        for kind in ("value", "ligament", "ring")
    }
    value = by_kind["value"].reindex(columns=_VALUES)
    X, stress = plane_stress_over_pull(
        cells=PLANE_CELLS, radius=RADIUS, half_width=HALF_WIDTH
    )
    on_line = np.flatnonzero(np.isclose(X[:, 1], 0.0, atol=1e-9))
    on_line = on_line[np.argsort(X[on_line, 0])]
    plane = pd.DataFrame({"X": X[on_line, 0], "stress": stress[on_line, 1, 1]})
    return {
        "table": _compared(value, by_kind["ring"]),
        "ligament": by_kind["ligament"].reindex(columns=["key", "X", "stress"]),
        "ring": by_kind["ring"].reindex(columns=["key", "angle", "stress"]),
        "plane": plane,
        "known": pd.DataFrame(
            {
                "what": ["infinite plate", "long strip", "this plate, plane reference"],
                "concentration": [
                    3.0,
                    gross_concentration(radius=RADIUS, half_width=HALF_WIDTH),
                    float(plane["stress"].iloc[0]),
                ],
            }
        ),
    }


def _compared(value: pd.DataFrame, ring: pd.DataFrame) -> pd.DataFrame:
    table = value.copy()
    for name in ("against_fit", "against_particles", "against_highest", "against_ring"):
        table[name] = np.nan
    for _, runs in value.groupby("thickness"):
        elements = runs[runs["method"] == FEM]
        if len(elements) == 0:
            continue
        reference = elements.iloc[0]
        for index, run in runs[runs["method"] != FEM].iterrows():
            table.loc[index, "against_fit"] = run["edge_fit"] / reference["edge_fit"] - 1.0
            for name in ("edge", "highest"):
                column = {"edge": "against_particles", "highest": "against_highest"}[name]
                over = run[f"{name}_particles"] / reference[f"{name}_fit"]
                table.loc[index, column] = over - 1.0
            table.loc[index, "against_ring"] = _apart(ring, run["key"], reference["key"])
    return table


def _apart(ring: pd.DataFrame, key: str, reference: str) -> float:
    """Largest difference in the ring over the largest value, or nan without a common ring."""
    if len(ring) == 0:
        return float("nan")
    a, b = (
        ring[ring["key"] == name].sort_values("angle")["stress"].to_numpy()
        for name in (key, reference)
    )
    if len(a) == 0 or len(a) != len(b):
        return float("nan")
    return float(np.abs(a - b).max() / np.abs(b).max())


STUDY = Study(
    name="plate_with_hole",
    cases=cases,
    tables=tables,
    report=report,
    summary=lambda found: verdicts(found).to_string(index=False),
    warm_up=warm_up,
    description="Stress concentration at a hole, particles on mesh files against B-bar elements.",
)
