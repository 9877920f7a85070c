"""What the paper claims and what was asked of the conservation study, decided by its tables."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pandas as pd

from studies.engine.claims import Claim, Source
from studies.engine.document import format_cell
from studies.engine.results import Tables
from studies.measures.folding import sound
from studies.measures.order import fit_order
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE, SUPG

#: Shares of the natural scales ``sum V |p|``, ``sum V |x| |p|`` below which a sum is round-off.
ROUND_OFF = 1.0e-12
#: Drift beyond which something other than round-off is at work.
NOT_ROUND_OFF = 1.0e-6
#: |L(5 s) - impulse| over the natural scale.
SAME_IMPULSE = 1.0e-10
#: Pressure noise over that of B-bar finite elements on the same mesh: smooth; smooth in part.
SMOOTH, PARTLY_SMOOTH = 2.0, 4.0
#: Residual of the energy budget over the initial energy, and the order in the step it falls with.
CLOSED, SECOND_ORDER = 1.0e-6, 2.0
#: |L - undeformed-arm estimate| over the latter, at a thousandth of the load.
RIGID_LIMIT = 1.0e-3
#: Setting of the runs that have an order in the step together.
SETTING = ["group", "method", "formulation", "integrator", "spacing", "spin"]
_CUBE_CFL = 0.3


def undeformed_impulse(load: float = 1.0) -> np.ndarray:
    """Angular impulse [kg m^2/s] of the tractions with the arms of the undeformed block.

    Force impulses ``+-A int eta dt (150, 300, 450)`` (9 m^2, 6.25 s^2) at the centroids of the two
    loaded faces, (6, 1.5, 1.5) and (1.5, 10, 1.5) m.
    """
    arm = np.array([4.5, -8.5, 0.0])
    return np.asarray(load * np.cross(arm, 9.0 * 6.25 * np.array([150.0, 300.0, 450.0])))


def orders(cube: pd.DataFrame) -> pd.DataFrame:
    """Fitted order of the residual in the CFL number, a row a setting.

    Runs of the groups ``ladder``, ``methods``, ``elements``, ``package`` and ``default`` that kept
    their energy.
    """
    groups = ["ladder", "methods", "elements", "package", "default"]
    rows = []
    kept = cube[cube["group"].isin(groups) & (cube["outcome"] == "kept")]
    for key, runs in kept.groupby(SETTING, sort=False, dropna=False):
        if runs["cfl"].nunique() > 1:
            cfl, finest = runs["cfl"].to_numpy(), runs.loc[runs["cfl"].idxmin()]
            rows.append(
                dict(zip(SETTING, key, strict=True))
                | {
                    "steps": len(runs),
                    "order": fit_order(cfl, runs["residual"].to_numpy()),
                    "order_left_over": fit_order(cfl, runs["left_over"].to_numpy()),
                    **{name: finest[name] for name in ("cfl", "residual", "left_over")},
                }
            )
    columns = ["steps", "order", "order_left_over", "cfl", "residual", "left_over"]
    return pd.DataFrame(rows, columns=[*SETTING, *columns])


def claims(tables: Tables) -> list[Claim]:
    """The claims of the paper in its order, then what was asked beyond it."""
    table, cube = tables["table"], tables["cube"]
    # Self-adjoint SUPG must keep what the paper's setting keeps.
    runs = table[table["group"].isin(["paper", "package"])]
    return [
        *_of_the_paper(table, runs),
        *_pressures(table),
        *_impulses(table, runs),
        *_of_the_cube(cube),
        *_of_orders(tables["orders"]),
        *_of_the_default(tables),
    ]


def _of_the_paper(table: pd.DataFrame, runs: pd.DataFrame) -> Iterator[Claim]:
    """Momenta and survival, [Lee2017] section 8.1."""
    yield from _every(runs, "linear", "linear momentum is zero to round-off", ROUND_OFF, "paper")
    yield from _every(
        runs, "angular_free", "angular momentum is constant without loads", ROUND_OFF, "paper"
    )
    bare = select(table, group="no projection")
    if len(bare):
        least = bare.loc[bare["angular_free"].idxmin()]
        yield Claim(
            "without the projection it is not", float(least["angular_free"]), ">", NOT_ROUND_OFF,
            "paper", _name(least), format=".1e",
        )  # fmt: skip
    if len(runs):
        kept = int((runs["outcome"] == "kept").sum())
        what = "runs to 20 s with its energy, every combination"
        yield Claim.counted(what, kept, len(runs), source="paper", where="all", wanted="all")


def _pressures(table: pd.DataFrame) -> Iterator[Claim]:
    """Is the pressure smooth?  {p,F} H6 against finite elements on the same mesh."""
    runs = select(table, formulation="{p,F}")
    printed = (runs["group"] == "paper") & (runs["secondary"] == "H6")
    for _, run in runs[printed | (runs["method"] == SUPG.name)].iterrows():
        if run["group"] not in ("paper", "package"):
            continue
        elements = select(table, group="elements", method=B_BAR.name, spacing=run["spacing"])
        if len(elements):
            yield Claim(
                "pressure is smooth: noise over that of B-bar",
                float(run["noise"]) / float(elements["noise"].iloc[0]), "<=", SMOOTH, "paper",
                _name(run), in_part=PARTLY_SMOOTH,
                # The pressure of folded positions is that of no body, however smooth.
                sound=bool(sound(run.to_frame().T).all()), format=".2f",
            )  # fmt: skip


def _impulses(table: pd.DataFrame, runs: pd.DataFrame) -> Iterator[Claim]:
    what = "angular momentum at 5 s is the applied impulse"
    yield from _every(runs, "impulse_gap", what, SAME_IMPULSE)
    small = select(table, group="small load")
    if len(small):
        gaps = small.apply(_estimate_gap, axis=1)
        yield Claim(
            "a thousandth of the load: the undeformed-arm impulse", float(gaps.max()), "<=",
            RIGID_LIMIT, where=_name(small.loc[gaps.idxmax()]), format=".1e",
        )  # fmt: skip


def _of_the_cube(cube: pd.DataFrame) -> Iterator[Claim]:
    projected = cube[
        (cube["projection"] == "local") & ~cube["method"].isin([B_BAR.name, PACKAGE.name])
    ]
    for kind in ("angular", "linear"):
        # Momenta are kept by a run that makes energy too, and by one that ends early.
        what = f"cube: {kind} momentum kept for ten turns"
        yield from _every(projected, f"{kind}_total", what, ROUND_OFF, healthy=False)
    ladder = select(cube, group="ladder", cfl=_CUBE_CFL, outcome="kept")
    slow = select(cube, group="slow", outcome="kept", integrator="TVD-RK2")
    for runs, what in (
        (ladder, f"cube: energy budget closes at CFL {_CUBE_CFL:g} (finest run)"),
        (slow, "cube, a tenth of the spin: energy budget closes (least step)"),
    ):
        if len(runs):
            run = runs.loc[(runs["spacing"] * runs["cfl"]).idxmin()]
            for column, more in (("residual", ""), ("left_over", ", with the projection's work")):
                yield Claim(
                    what + more, float(run[column]), "<=", CLOSED, where=_name(run), format=".1e"
                )


def _of_orders(fitted: pd.DataFrame) -> Iterator[Claim]:
    of_supg = fitted[~fitted["method"].isin([B_BAR.name, PACKAGE.name])]
    for own in (of_supg, select(fitted, method=PACKAGE.name)):
        for column, what in (
            ("order", "cube: the residual falls as dt^2 or faster"),
            ("order_left_over", "cube: so does it with the projection's work"),
        ):
            if len(own):
                worst = own.loc[own[column].idxmin()]
                yield Claim(
                    what, float(worst[column]), ">=", SECOND_ORDER, where=_name(worst),
                    format=".2f",
                )  # fmt: skip


def _of_the_default(tables: Tables) -> Iterator[Claim]:
    """Momenta of every body with the restraint on, and energy that only goes."""
    block, cube = (select(tables[name], method=PACKAGE.name) for name in ("table", "cube"))
    name = PACKAGE.name
    whole = block[block["group"].isin(["default", "long", "disorder"])]
    for column, what in (
        ("linear", "linear momentum is zero to round-off"),
        ("angular_free", "angular momentum is constant without loads"),
    ):
        yield from _every(whole, column, f"{name}: {what}", ROUND_OFF)
    yield from _every(
        whole, "impulse_gap", f"{name}: angular momentum at 5 s is the applied impulse",
        SAME_IMPULSE,
    )  # fmt: skip
    for kind in ("angular", "linear"):
        what = f"{name}, cube: {kind} momentum kept for ten turns"
        yield from _every(cube, f"{kind}_total", what, ROUND_OFF)
    bodies = tables["bodies"]
    drifts = bodies[["linear_drift", "angular_drift"]].max(axis=1)
    drifts = drifts.where(bodies["outcome"] == "kept")
    names = (bodies["shape"] + ", " + bodies["cloud"]).tolist()
    if len(bodies):
        worst = int(np.argmax(drifts.fillna(math.inf)))
        yield Claim(
            "both momenta of free bodies", dict(zip(names, drifts.astype(float), strict=True)),
            "<=", ROUND_OFF, where=name, wanted=f"at most {ROUND_OFF:.0e}",
            said=f"{format_cell(float(drifts.iloc[worst]), '.1e')} at most, {names[worst]}; "
            f"{len(names)} bodies",
        )  # fmt: skip
    for runs, what in ((whole, "block"), (cube, "cube")):
        yield from _every(
            runs, "given_back", f"{name}, {what}: the restraint takes energy between any records",
            ROUND_OFF,
        )  # fmt: skip


def _every(
    runs: pd.DataFrame,
    column: str,
    what: str,
    most: float,
    source: Source = "asked",
    *,
    healthy: bool = True,
) -> Iterator[Claim]:
    """Every run has at most so much; the worst is named.

    A run that diverged, or whose positions folded, has not shown it, unless it need not be
    ``healthy``.
    """
    if len(runs) == 0:
        return
    values = runs[column].astype(float)
    worst = values.fillna(math.inf).idxmax()
    good = sound(runs) if healthy else values.notna()
    yield Claim(
        what, {str(k): v for k, v in enumerate(values)}, "<=", most, source,
        _name(runs.loc[worst]), sound={str(k): bool(v) for k, v in enumerate(good)},
        said=format_cell(values[worst], ".1e"), wanted=f"at most {most:.0e}",
    )  # fmt: skip


def _estimate_gap(run: pd.Series) -> float:
    estimate = undeformed_impulse(float(run["load"]))
    L = run[["L_x", "L_y", "L_z"]].to_numpy(dtype=float)
    return float(np.linalg.norm(L - estimate) / np.linalg.norm(estimate))


def _name(run: pd.Series) -> str:
    return f"{run['method']}, spacing {run['spacing']:g} m, CFL {run['cfl']:g}"
