"""Verdicts: our limits against CalculiX, our lattices against their limits, and the beam."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from sphsolid.scenes import OnCylinder, PlaneClamp
from studies.engine.claims import Claim
from studies.engine.results import Tables
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE
from studies.outside.problems import Beam
from studies.outside.sequences import CALCULIX, sequence

#: How near to CalculiX our limit, and to its own limit our finest lattice, must be.
NEAR = 0.01
#: The beam with so many points across its height must be this near, and so much better than with
#: half as many cells.
BEAM_POINTS, BEAM_NEAR, BEAM_FALL = 17, 0.005, 2.0
TIP = "least u_y of the tip [mm]"
PLANE, CYLINDER = Beam(PlaneClamp()).name, Beam(OnCylinder()).name


def claims(tables: Tables) -> list[Claim]:
    """Three claims a method, over all problems, and those of the beam."""
    table = tables["table"]
    ours = table[table["method"] != CALCULIX]
    found = []
    for method, rows in ours.groupby("method", sort=False):
        for what, column in (
            ("finest lattice within the share asked for of CalculiX", "off_finest"),
            ("limits of the lattices within the share asked for of CalculiX", "off_limit"),
            ("finest lattice within that share of its own limit", "left"),
        ):
            worst = {
                str(problem): own.loc[own[column].abs().idxmax()]
                for problem, own in rows.groupby("problem", sort=False)
                if own[column].notna().any()
            }
            said = ", ".join(
                f"{problem} {row[column]:+.2%} ({row['quantity']})"
                for problem, row in worst.items()
            )
            if not worst:
                continue
            sizes = {problem: abs(float(row[column])) for problem, row in worst.items()}
            found.append(
                Claim(what, sizes, "<=", NEAR, where=str(method), said=said,
                      wanted=f"the worst quantity of each problem within {NEAR:.0%}")
            )  # fmt: skip
    return [*found, *_beam(tables)]


def beam_errors(tables: Tables, problem: str, method: str) -> dict[int, float]:
    """By points across the height: ``u_y`` over the limit by CalculiX, less one."""
    theirs = sequence(tables["calculix"], problem, TIP)
    own = sequence(select(tables["ours"], method=method), problem, TIP)
    if theirs is None or own is None:
        return {}
    errors = own.values / theirs.limit.value - 1.0
    return dict(zip((int(n) + 1 for n in own.levels), map(float, errors), strict=True))


def _beam(tables: Tables) -> Iterator[Claim]:
    for problem in (PLANE, CYLINDER):
        for method in (PACKAGE.name, B_BAR.name):
            errors = beam_errors(tables, problem, method)
            if not errors:
                continue
            said = ", ".join(f"{points} points {error:+.2%}" for points, error in errors.items())
            at, before = (errors.get(n) for n in (BEAM_POINTS, (BEAM_POINTS + 1) // 2))
            yield Claim(
                f"{problem}: error at {BEAM_POINTS} points, against CalculiX",
                {} if at is None else abs(at), "<=", BEAM_NEAR, where=method, said=said,
                wanted=f"at most {BEAM_NEAR:.1%}",
            )  # fmt: skip
            yield Claim(
                f"{problem}: the error falls with the spacing, ratio on the last halving",
                {} if at is None or before is None else abs(before / at), ">=", BEAM_FALL,
                where=method,
            )  # fmt: skip
            yield Claim(
                f"{problem}: the lattices come together, ratio of the last two changes",
                _change(errors), ">=", BEAM_FALL, where=method,
            )  # fmt: skip


def _change(errors: dict[int, float]) -> float | dict[str, float]:
    """By how much the change of a sequence fell on its last halving: no limit enters it."""
    values = [errors.get(n) for n in ((BEAM_POINTS + 3) // 4, (BEAM_POINTS + 1) // 2, BEAM_POINTS)]
    coarse, middle, fine = values
    if coarse is None or middle is None or fine is None:
        return {}
    return abs((coarse - middle) / (middle - fine))


def explained(tables: Tables) -> pd.DataFrame:
    """Where our limit is not within :data:`NEAR`: by how much, and what the limits may be off.

    ``covered`` is True where both limits together are known no better than the difference.
    """
    table = tables["table"]
    far = table[(table["method"] != CALCULIX) & (table["off_limit"].abs() > NEAR)].copy()
    within = (far["outside_within"] + far["limit_within"]) / far["outside"].abs()
    far["within"] = within
    far["covered"] = within >= far["off_limit"].abs()
    return far[["problem", "quantity", "method", "off_limit", "off_finest", "within", "covered"]]


def of_the_clamp(tables: Tables) -> pd.DataFrame:
    """Limits of the beam by CalculiX with either clamp, beside what its authors published."""
    rows = []
    for problem in (PLANE, CYLINDER):
        found = sequence(tables["calculix"], problem, TIP)
        if found is not None:
            limit = found.limit
            rows.append({"what": f"CalculiX, {problem}", "mm": limit.value, "within": limit.within})
    published = tables["particles"]
    authors = published[published["code"] == "Turek and Hron"]
    rows += [
        {"what": f"published, {row.source}", "mm": row.low, "within": np.nan}
        for row in authors.itertuples()
    ]
    return pd.DataFrame(rows, columns=["what", "mm", "within"])
