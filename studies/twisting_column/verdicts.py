"""What the paper claims of the twisting column, and whether the study's tables bear it out.

Every verdict follows from the tables by a rule that is stated beside it.  The paper gives pictures
and no numbers, so the thresholds are ours.  The twist is judged on sequences of lattices, against a
code outside this repository: its error changes sign, and the B-bar elements have one of their own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from studies.convergence.figures import select
from studies.harness.results import Tables
from studies.report.folding import has_folded
from studies.twisting_column import outside
from studies.twisting_column.methods import (
    FEM,
    H1,
    H6,
    LITERAL,
    LITERAL_H6,
    PAPER_LATTICES,
    lattice,
    usual,
)
from studies.twisting_column.sequence import SAME_LIMIT, TooFew, twist_error, twist_sequence

REPRODUCED, IN_PART, NOT = "reproduced", "reproduced in part", "not reproduced"
UNDECIDED = "not decided: runs are missing"


@dataclass(frozen=True)
class Verdict:
    """A claim, the rule that decides it, what was measured, and what follows."""

    claim: str
    rule: str
    measured: str
    verdict: str


def graded(whole: bool, part: bool) -> str:
    """The three grades; ``part`` counts only where ``whole`` does not hold."""
    return REPRODUCED if whole else (IN_PART if part else NOT)


def claims(tables: Tables) -> list[Verdict]:
    """One verdict for each claim of [Lee2017] section 8.3, and one on its equations as printed.

    None holds that rests on a run whose positions folded.
    """
    runs = usual(tables["table"])
    paper = list(PAPER_LATTICES)
    own = runs["label"].isin([H1, H6])
    judged = (
        (_h1_is_h6(runs, tables["differences"]), own & runs["cells"].isin(paper)),
        (_converges(runs), runs["label"] == H1),
        (_agrees(runs), (runs["label"] == H1) & (runs["cells"] >= 5)),
        (_coarsest_is_good(runs), own & runs["cells"].isin(paper)),
        (_h6_costs_six_times(tables["cost"]), runs["label"] == ""),
        (_as_printed(runs), runs["label"].isin([LITERAL, LITERAL_H6]) & runs["cells"].isin(paper)),
    )
    return [_unless_folded(one, runs[rests_on]) for one, rests_on in judged]


def _unless_folded(one: Verdict, runs: pd.DataFrame) -> Verdict:
    """The verdict, or that the claim does not hold, with the runs that folded."""
    bad = runs[has_folded(runs)]
    if len(bad) == 0:
        return one
    names = ", ".join(
        f"{run.label} {lattice(int(run.cells))} at {1e3 * run.folded_at:.0f} ms"
        for run in bad.itertuples()
    )
    return replace(one, measured=f"{one.measured}; folded: {names}", verdict=NOT)


def _one(runs: pd.DataFrame, label: str, cells: int) -> pd.Series | None:
    found = select(runs, label=label, cells=cells)
    return found.iloc[0] if len(found) and bool(found.iloc[0]["survived"]) else None


def twist_apart(one: pd.Series, other: pd.Series) -> float:
    """Largest relative difference of the twist at 20, 40, .. 100 ms."""
    return max(abs(one[f"twist_{ms}"] / other[f"twist_{ms}"] - 1.0) for ms in outside.INSTANTS)


def _h1_is_h6(runs: pd.DataFrame, apart: pd.DataFrame) -> Verdict:
    claim = "SUPG-SPH-H1 and H6 give practically identical results on three lattices (Fig. 14)"
    rule = (
        "reproduced: on every lattice twist within 1 %, rms distance of positions below 2 % of "
        "the width, rms difference of pressure below 10 %; in part: without the pressure"
    )
    texts: list[str] = []
    twists: list[float] = []
    distances: list[float] = []
    pressures: list[float] = []
    for cells in PAPER_LATTICES:
        one, other = _one(runs, H1, cells), _one(runs, H6, cells)
        pair = select(usual(apart), label=H6, other=H1, cells=cells)
        if one is None or other is None or len(pair) == 0:
            continue
        twists.append(twist_apart(other, one))
        distances.append(float(pair.iloc[0]["position_rms [m]"]))
        pressures.append(float(pair.iloc[0]["pressure_rms"]))
        texts.append(
            f"{lattice(cells)}: twist {100 * twists[-1]:.2f} %, positions "
            f"{100 * distances[-1]:.2f} %, pressure {100 * pressures[-1]:.1f} %"
        )
    if not texts:
        return Verdict(claim, rule, "–", UNDECIDED)
    shape = max(twists) <= 0.01 and max(distances) <= 0.02
    grade = graded(shape and max(pressures) <= 0.10, shape)
    return Verdict(claim, rule, "; ".join(texts), grade)


def _converges(runs: pd.DataFrame) -> Verdict:
    claim = "the solution converges under refinement of the particles (Figs. 14, 15a)"
    rule = (
        "reproduced: rms distance of positions from the finest elements falls at every "
        f"refinement of H1, and the twist at 0.1 s of the sequence has a limit within "
        f"{SAME_LIMIT:.1%} of that of {outside.NAME}, known to {SAME_LIMIT:.1%}, and ends within "
        "1 % of it; in part: the finest lattice is nearer in position than the coarsest"
    )
    own = select(runs, label=H1).sort_values("cells")
    own = own[own["survived"].astype(bool) & own["position_rms"].notna()]
    found = twist_sequence(runs, H1)
    if isinstance(found, TooFew) or len(own) < 2:
        return Verdict(claim, rule, "–", UNDECIDED)
    rms = own["position_rms"].to_numpy()
    order = np.log(rms[0] / rms[-1]) / np.log(own["cells"].iloc[-1] / own["cells"].iloc[0])
    listed = ", ".join(
        f"{lattice(int(c))} {1e3 * r:.1f} mm" for c, r in zip(own["cells"], rms, strict=True)
    )
    measured = f"{listed}: order {order:.1f}; twist {found.text()}"
    limit = abs(found.limit_error) <= SAME_LIMIT and found.limit_within <= SAME_LIMIT
    whole = bool((np.diff(rms) < 0.0).all()) and limit and abs(found.errors[-1]) <= 0.01
    return Verdict(claim, rule, measured, graded(whole, rms[-1] < rms[0]))


def _pressure(run: pd.Series) -> tuple[float, str]:
    spread = run["reference_mean_99"] - run["reference_mean_1"]
    apart = max(
        abs(run[f"pressure_mean_{share}"] - run[f"reference_mean_{share}"]) / spread
        for share in (1, 50, 99)
    )
    text = (
        f"percentiles of the mean pressure {100 * apart:.0f} % of their range (its rms "
        f"difference {100 * run['mean_rms']:.0f} %, at the instant "
        f"{100 * run['pressure_rms']:.0f} %)"
    )
    return apart, text


def _height(run: pd.Series) -> float:
    return float(abs(run["corners_100"] - outside.corners()))


def _agrees(runs: pd.DataFrame) -> Verdict:
    claim = "SUPG-SPH at 6x31x6 agrees very well with the benchmark methods (Fig. 15)"
    rule = (
        f"against {outside.NAME}, reproduced: twist of H1 within 2 % at 20 .. 100 ms on 6x31x6 and "
        "on every finer lattice, for its error changes sign and one lattice can be right by "
        "chance; height of the top's corners at 0.1 s within 30 mm; against the finest B-bar FE "
        "percentiles 1, 50, 99 by volume of the pressure averaged over the next 10 ms, at the same "
        "centroids, Y > 0.5 m, within 15 % of the range between them; in part: twist and height"
    )
    run, elements = _one(runs, H1, 5), _one(runs, FEM, 5)
    if run is None or elements is None or np.isnan(run["position_rms"]):
        return Verdict(claim, rule, "–", UNDECIDED)
    finer = select(runs, label=H1)
    finer = finer[(finer["cells"] >= 5) & finer["survived"].astype(bool)]
    errors = {lattice(int(one["cells"])): twist_error(one) for _, one in finer.iterrows()}
    height, (pressure, text) = _height(run), _pressure(run)
    listed = ", ".join(f"{name} {100 * error:.2f} %" for name, error in errors.items())
    measured = (
        f"twist within {listed} (B-bar FE {lattice(5)} {100 * twist_error(elements):.2f} %); "
        f"height {1e3 * height:.0f} mm, {text}"
    )
    shape = max(errors.values()) <= 0.02 and height <= 0.03
    return Verdict(claim, rule, measured, graded(shape and pressure <= 0.15, shape))


def _coarsest_is_good(runs: pd.DataFrame) -> Verdict:
    claim = "the coarsest lattice, 4x19x4, already shows the deformation and pressure (Fig. 14)"
    rule = (
        f"twist of H1 and H6 within 4 % of {outside.NAME} at 20 .. 100 ms on all three lattices of "
        "the paper, so not only where the error changes sign; on 4x19x4 height within 60 mm and "
        "pressure within 30 %, as at 6x31x6; in part: twist alone"
    )
    texts, whole, part = [], True, True
    for label in (H1, H6):
        three = [_one(runs, label, cells) for cells in PAPER_LATTICES]
        lasted = [run for run in three if run is not None]
        if len(lasted) < len(three) or np.isnan(lasted[0]["position_rms"]):
            return Verdict(claim, rule, "–", UNDECIDED)
        errors = [twist_error(run) for run in lasted]
        height, (pressure, text) = _height(lasted[0]), _pressure(lasted[0])
        listed = ", ".join(f"{100 * error:.2f}" for error in errors)
        name = lasted[0]["secondary"]
        texts.append(f"{name}: twist within {listed} %, height {1e3 * height:.0f} mm, {text}")
        part = part and max(errors) <= 0.04
        whole = whole and part and height <= 0.06 and pressure <= 0.30
    return Verdict(claim, rule, "; ".join(texts), graded(whole, part))


def _h6_costs_six_times(cost: pd.DataFrame) -> Verdict:
    claim = "H6 takes six times the effort of H1 in the SUPG terms (section 8.2)"
    rule = (
        "time of a step less that of a step without stabilisation, H6 over H1; reproduced: "
        "4.5 to 7.5; in part: above 2"
    )
    if len(cost) == 0:
        return Verdict(claim, rule, "–", UNDECIDED)
    step = cost.set_index("secondary")["step_s"]
    ratio = (step["H6"] - step["none"]) / (step["H1"] - step["none"])
    measured = (
        f"SUPG terms {ratio:.1f} times, whole step {step['H6'] / step['H1']:.1f} times "
        f"({1e3 * step['none']:.2f}, {1e3 * step['H1']:.2f}, {1e3 * step['H6']:.2f} ms without, "
        f"with H1, with H6 at {lattice(int(cost['cells'].iloc[0]))})"
    )
    return Verdict(claim, rule, measured, graded(4.5 <= ratio <= 7.5, ratio > 2.0))


def _as_printed(runs: pd.DataFrame) -> Verdict:
    claim = "the equations as printed (Literal operator) give these results"
    rule = (
        f"against {outside.NAME}, reproduced: H1 and H6 keep the twist within 2 % at "
        "20 .. 100 ms and gain no energy (E/E0 at most 1.001) on every lattice of the paper; "
        "in part: on one of them"
    )
    texts, good = [], []
    for label in (LITERAL, LITERAL_H6):
        for cells in PAPER_LATTICES:
            found = select(runs, label=label, cells=cells)
            if len(found) == 0:
                continue
            run = found.iloc[0]
            alive = bool(run["survived"])
            twist = twist_error(run) if alive else float("nan")
            good.append(alive and twist <= 0.02 and run["energy_kept"] <= 1.001)
            texts.append(
                f"{run['secondary']} {lattice(cells)}: "
                + (f"twist {100 * twist:.1f} %, E/E0 {run['energy_kept']:.3f}" if alive
                   else f"lost at {1e3 * run['end_time']:.0f} ms")
            )  # fmt: skip
    if not texts:
        return Verdict(claim, rule, "–", UNDECIDED)
    return Verdict(claim, rule, "; ".join(texts), graded(all(good), any(good)))


def verdict_frame(judged: list[Verdict]) -> Iterator[dict[str, str]]:
    """Rows for a table; the rules are sentences of their own."""
    for one in judged:
        yield {"claim": one.claim, "verdict": one.verdict, "measured": one.measured}
