"""What the paper claims and what was asked of the conservation study, decided by its tables.

Every function takes tables and returns :class:`Verdict` rows, so thresholds stand in one place.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields

import numpy as np
import pandas as pd

from studies.conservation.measures import DEFAULTS
from studies.convergence.figures import select
from studies.report.folding import sound
from studies.report.order import fit_order

#: Shares of the natural scales ``sum V |p|``, ``sum V |x| |p|`` below which a sum is round-off.
ROUND_OFF = 1.0e-12
#: Drift beyond which something other than round-off is at work.
NOT_ROUND_OFF = 1.0e-6
#: |L(5 s) - impulse| over the natural scale.
SAME_IMPULSE = 1.0e-10
#: Pressure noise over that of B-bar finite elements on the same mesh: smooth; smooth in part.
SMOOTH, PARTLY_SMOOTH = 2.0, 4.0
#: Rest of the energy ledger over the initial energy, and the order in the step it must fall with.
CLOSED, SECOND_ORDER = 1.0e-6, 2.0
#: |L - undeformed-arm estimate| over the latter, at a thousandth of the load.
RIGID_LIMIT = 1.0e-3
SETTING = [
    "group", "method", "formulation", "secondary", "operator", "weighting", "integrator", "spacing",
    "h_over_dx", "spin",
]  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """``claim`` by ``source``; the ``measured`` figure that decides it against ``wanted``."""

    claim: str
    source: str
    where: str
    measured: float
    wanted: float
    verdict: str


def undeformed_impulse(load: float = 1.0) -> np.ndarray:
    """Angular impulse [kg m^2/s] of the tractions with the arms of the undeformed block.

    Force impulses ``+-A int eta dt (150, 300, 450)`` (9 m^2, 6.25 s^2) at the centroids of the two
    loaded faces, (6, 1.5, 1.5) and (1.5, 10, 1.5) m.
    """
    arm = np.array([4.5, -8.5, 0.0])
    return np.asarray(load * np.cross(arm, 9.0 * 6.25 * np.array([150.0, 300.0, 450.0])))


def verdicts(table: pd.DataFrame, cube: pd.DataFrame, orders: pd.DataFrame) -> pd.DataFrame:
    """One row a claim, in the order of the paper and then of what was asked beyond it."""
    rows = [*paper_verdicts(table), *block_verdicts(table), *cube_verdicts(cube, orders)]
    return pd.DataFrame(
        [asdict(row) for row in rows], columns=[field.name for field in fields(Verdict)]
    )


def paper_verdicts(table: pd.DataFrame) -> Iterator[Verdict]:
    """Claims of [Lee2017] section 8.1 about the L-shaped block."""
    # What is left to the package must keep what the paper's setting keeps.
    runs = table[table["group"].isin(["all", "defaults"])]
    yield from _each_below(
        runs, "linear", ROUND_OFF, "linear momentum is zero to round-off", "paper"
    )
    yield from _each_below(
        runs, "angular_free", ROUND_OFF, "angular momentum is constant without loads", "paper"
    )
    bare = select(table, group="no projection")
    if len(bare):
        k = bare["angular_free"].idxmin()
        least = float(bare["angular_free"].min())
        yield Verdict(
            "without the projection it is not", "paper", _name(bare.loc[k]), least, NOT_ROUND_OFF,
            _reproduced(least > NOT_ROUND_OFF),
        )  # fmt: skip
    if len(runs):
        kept = runs["outcome"] == "kept"
        word = "reproduced" if kept.all() else "in part" if kept.any() else "not reproduced"
        yield Verdict(
            "runs to 20 s, every combination (share)", "paper", "all", float(kept.mean()), 1.0, word
        )
    yield from pressure_verdicts(table)


def pressure_verdicts(table: pd.DataFrame) -> Iterator[Verdict]:
    """Is the pressure smooth?  {p,F} H6 against finite elements on the same mesh."""
    runs = select(table, formulation="{p,F}")
    paper = (runs["group"] == "all") & (runs["secondary"] == "H6")
    for _, run in runs[paper | (runs["group"] == "defaults")].iterrows():
        elements = select(table, group="elements", spacing=run["spacing"])
        if len(elements):
            ratio = float(run["noise"]) / float(elements["noise"].iloc[0])
            # The pressure of folded positions is that of no body, however smooth.
            ratio = ratio if bool(sound(run.to_frame().T).all()) else math.inf
            word = "in part" if ratio <= PARTLY_SMOOTH else "not reproduced"
            yield Verdict(
                f"pressure is smooth: {_kind(run)}, noise over that of B-bar", "paper",
                _name(run), ratio, SMOOTH, "reproduced" if ratio <= SMOOTH else word,
            )  # fmt: skip


def block_verdicts(table: pd.DataFrame) -> Iterator[Verdict]:
    """What was asked of the L-shaped block beyond the paper."""
    runs = table[table["group"].isin(["all", "defaults"])]
    for verdict in _each_below(
        runs, "impulse_gap", SAME_IMPULSE, "angular momentum at 5 s is the applied impulse", "asked"
    ):
        yield _as_met(verdict)
    small = select(table, group="small load")
    if len(small):
        gaps = small.apply(_estimate_gap, axis=1)
        yield Verdict(
            "a thousandth of the load: the undeformed-arm impulse", "asked",
            _name(small.loc[gaps.idxmax()]), float(gaps.max()), RIGID_LIMIT,
            _met(float(gaps.max()) <= RIGID_LIMIT),
        )  # fmt: skip


def cube_verdicts(cube: pd.DataFrame, orders: pd.DataFrame) -> Iterator[Verdict]:
    """What was asked of the spinning cube."""
    projected = cube[cube["projection"] != "none"]
    sph = projected[projected["method"] != "B-bar FEM"]
    for column, claim in (
        ("angular_total", "cube: angular momentum kept for ten turns"),
        ("linear_total", "cube: linear momentum kept for ten turns"),
    ):
        for verdict in _each_below(sph, column, ROUND_OFF, claim, "asked", healthy=False):
            yield _as_met(verdict)
    ladder = select(cube, group="ladder", cfl=0.3, outcome="kept")
    slow = select(cube, group="slow", outcome="kept", integrator="TVD-RK2")
    for runs, claim in (
        (ladder, "cube: ledger closes at CFL 0.3 (finest run)"),
        (slow, "cube, a tenth of the spin: ledger closes (least step)"),
    ):
        if len(runs):
            run = runs.loc[(runs["spacing"] * runs["cfl"]).idxmin()]
            for column, what in (("rest", ""), ("left_over", ", with the projection's work")):
                rest = float(run[column])
                yield Verdict(claim + what, "asked", _name(run), rest, CLOSED, _met(rest <= CLOSED))
    orders = orders[orders["method"] != "B-bar FEM"]
    for column, claim in (
        ("order", "cube: the rest falls as dt^2 or faster"),
        ("order_left_over", "cube: so does it with the projection's work"),
    ):
        if len(orders):
            worst = orders.loc[orders[column].idxmin()]
            value = float(worst[column])
            yield Verdict(
                claim, "asked", _name(worst), value, SECOND_ORDER, _met(value >= SECOND_ORDER)
            )


def rest_orders(cube: pd.DataFrame) -> pd.DataFrame:
    """Fitted order of the rest of the ledger in the CFL number, a row a setting.

    Runs of the groups ``ladder``, ``methods`` and ``elements`` that kept their energy.
    """
    part = cube[
        cube["group"].isin(["ladder", "methods", "elements", "defaults"])
        & (cube["outcome"] == "kept")
    ]
    rows = []
    for key, runs in part.groupby(SETTING, sort=False, dropna=False):
        if runs["cfl"].nunique() > 1:
            cfl = runs["cfl"].to_numpy()
            finest = runs.loc[runs["cfl"].idxmin()]
            rows.append(
                dict(zip(SETTING, key, strict=True))
                | {
                    "steps": len(runs),
                    "order": fit_order(cfl, runs["rest"].to_numpy()),
                    "order_left_over": fit_order(cfl, runs["left_over"].to_numpy()),
                    "cfl": finest["cfl"],
                    "rest": finest["rest"],
                    "left_over": finest["left_over"],
                }
            )
    return pd.DataFrame(
        rows, columns=[*SETTING, "steps", "order", "order_left_over", "cfl", "rest", "left_over"]
    )


def _each_below(
    runs: pd.DataFrame,
    column: str,
    wanted: float,
    claim: str,
    source: str,
    *,
    healthy: bool = True,
) -> Iterator[Verdict]:
    """Every run at most ``wanted``: reproduced; some: in part.

    A run that was lost, or whose positions folded, has not shown it.
    """
    if len(runs) == 0:
        return
    values = runs[column].astype(float)
    good = values <= wanted
    if healthy:
        good &= sound(runs)
    word = "reproduced" if good.all() else "in part" if good.any() else "not reproduced"
    worst = runs.loc[values.fillna(math.inf).idxmax()]
    yield Verdict(claim, source, _name(worst), float(worst[column]), wanted, word)


def _estimate_gap(run: pd.Series) -> float:
    estimate = undeformed_impulse(float(run["load"]))
    L = run[["L_x", "L_y", "L_z"]].to_numpy(dtype=float)
    return float(np.linalg.norm(L - estimate) / np.linalg.norm(estimate))


def _name(run: pd.Series) -> str:
    names = ("formulation", "secondary", "operator", "weighting")
    words = [str(run[name]) for name in names if run[name] not in ("-", "as printed")]
    if run["method"] != "SUPG-SPH":
        words = [str(run["method"]), *words]
    if run["integrator"] not in ("-", "TVD-RK2"):
        words.append(str(run["integrator"]))
    return " ".join(words) + f", spacing {run['spacing']:g} m, CFL {run['cfl']:g}"


def _kind(run: pd.Series) -> str:
    return DEFAULTS if run["method"] == DEFAULTS else str(run["operator"])


def _as_met(verdict: Verdict) -> Verdict:
    words = {"reproduced": "met", "in part": "met in part", "not reproduced": "not met"}
    return Verdict(**(asdict(verdict) | {"verdict": words[verdict.verdict]}))


def _reproduced(holds: bool) -> str:
    return "reproduced" if holds else "not reproduced"


def _met(holds: bool) -> str:
    return "met" if holds else "not met"
