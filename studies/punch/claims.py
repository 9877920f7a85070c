"""The paper's claims about the punch test, and what was asked, each decided by its tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from studies.engine.claims import Claim
from studies.engine.results import Tables
from studies.measures.folding import has_folded, sound
from studies.measures.indicators import FLUCTUATES, REMOVED, SMOOTH
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE, SUPG, Method
from studies.punch.runs import (
    CLASSICAL,
    COMPARED,
    CONSISTENT,
    DEFAULTS,
    GALERKIN,
    H1,
    H6,
    H6_NO_TAU_P,
    INITIAL,
    LITERAL,
    READINGS,
    WIDE,
    WIDE_NO_TAU_P,
    WITHOUT_TAU_F,
    Reading,
)
from studies.punch.tables import elements, one_run

#: Distance [m] of heights of the top face, and of pressure percentiles as a share of their range.
TOLERANCE, PRESSURE_SHARE = 0.004, 0.05
#: Ratio of the noises of two pressures that look alike; percentiles do not see a checkerboard.
NOISE_RATIO = 1.2
#: What "six times the computational effort" may be when measured.
SIX = (5.0, 7.0)
#: Heights of the top face at 15 ms [m] by an independent hexahedral finite element code.
INDEPENDENT = {"initial": (0.455, 0.541), "held": (0.350, 0.744)}
_ENDS = ("top_low", "top_high")
#: With and without ``tau_p = 0.1 dt``, all else equal.
PAIRS = {
    "paper, {p,F,H,J} H6, tau_F = 0.5 dt": (H6_NO_TAU_P, H6),
    "the same, support 2 dx": (WIDE_NO_TAU_P, WIDE),
    "paper, {p,F,J} H1, tau_F = 0": (WITHOUT_TAU_F[0.0], WITHOUT_TAU_F[0.1]),
    "self-adjoint SUPG": (DEFAULTS[0.0], DEFAULTS[0.1]),
}


def claims(tables: Tables) -> list[Claim]:
    """Claims of [Lee2017] section 8.2 first, then what this study was asked for."""
    table = tables["table"]
    return [
        *_pressure(table), _h1_and_h6(table), _cost(tables["cost"]), _distortion(table),
        Claim(
            "SUPG-SPH is more accurate than JST-SPH with as many particles", {}, ">=", 1.0,
            source="paper", said="see python -m studies.comparison", wanted="-",
        ),
        *_asked(table), *_of_the_default(table),
    ]  # fmt: skip


def _value(column: str, run: pd.DataFrame) -> float:
    return float(run[column].iloc[0]) if len(run) else math.nan


def _is_sound(run: pd.DataFrame) -> bool:
    """Whether the positions of a run had not folded when methods are compared."""
    return not bool(has_folded(run, by=COMPARED).any())


def _pressure(table: pd.DataFrame) -> Iterator[Claim]:
    def noise(method: Method, reading: Reading = INITIAL) -> float:
        return _value("noise_mean", one_run(table, reading, method))

    yield Claim(
        "displacement SPH has excessive pressure fluctuations (Fig. 10a): noise",
        {reading.name: noise(CLASSICAL, reading) for reading in READINGS},
        ">=", FLUCTUATES, source="paper", format=".3f",
    )  # fmt: skip
    yield Claim(
        "they are still there with tau_p = 0 (Fig. 10b, c): noise",
        {"without SUPG": noise(GALERKIN), "tau_F = 0.5 dt": noise(H6_NO_TAU_P)},
        ">=", FLUCTUATES, source="paper", format=".3f",
    )  # fmt: skip
    smooth = noise(H6)
    yield Claim(
        "with tau_p = 0.1 dt and tau_F = 0.5 dt the pressure is smooth (Fig. 10d): noise",
        smooth, "<=", SMOOTH, source="paper", format=".3f",
        sound=_is_sound(one_run(table, INITIAL, H6)),
        said=f"initial {smooth:.3f}; held {noise(H6, READINGS[1]):.3f} (steep at the edge)",
        wanted=f"initial at most {SMOOTH:g}",
    )  # fmt: skip
    pairs = {name: (noise(a), noise(b)) for name, (a, b) in PAIRS.items()}
    pairs = {name: pair for name, pair in pairs.items() if not math.isnan(sum(pair))}
    yield Claim(
        "it is tau_p that removes the fluctuations: noise with tau_p = 0 and 0.1 dt",
        {name: b / a for name, (a, b) in pairs.items()},
        "<=", REMOVED, source="paper",
        # Where there were no fluctuations, none were removed.
        sound={name: a >= FLUCTUATES for name, (a, _) in pairs.items()},
        said="; ".join(f"{name}: {a:.3f} to {b:.3f}" for name, (a, b) in pairs.items()),
        wanted=f"from at least {FLUCTUATES:g} to at most {REMOVED:.0%} of it",
    )  # fmt: skip


def _h1_and_h6(table: pd.DataFrame) -> Claim:
    said, shares, folds = [], {}, {}
    for reading in READINGS:
        pair = [one_run(table, reading, method) for method in (H1, H6)]
        if not all(map(len, pair)):
            continue
        one, six = (run.iloc[0] for run in pair)
        height = _largest(one, six, _ENDS)
        share = _largest(one, six, ("pressure_1", "pressure_99"))
        share /= six["pressure_99"] - six["pressure_1"]
        noise = one["noise_mean"] / six["noise_mean"]
        said.append(
            f"{reading.name}: top face {1e3 * height:.1f} mm, pressure {share:.1%}, noise "
            f"{noise:.2f} times"
        )
        parts = (height / TOLERANCE, share / PRESSURE_SHARE, max(noise, 1.0 / noise) / NOISE_RATIO)
        shares[reading.name] = float(np.max(parts))
        folds[reading.name] = all(map(_is_sound, pair))
    return Claim(
        "H1 and H6 agree very well in pressure and deformation (Fig. 11c, d)", shares, "<=", 1.0,
        source="paper", sound=folds, said="; ".join(said),
        wanted=f"{1e3 * TOLERANCE:g} mm, {PRESSURE_SHARE:.0%} of the range of percentiles, "
        f"{NOISE_RATIO:g} times",
    )  # fmt: skip


def _cost(cost: pd.DataFrame) -> Claim:
    ratios = {
        f"{row.lattice}, tau_p = {row.tau_p:g}{' dt' if row.tau_p else ''}": row.terms_ratio
        for row in cost.itertuples()
    }
    said = ", ".join(f"{name}: {ratio:.1f}" for name, ratio in ratios.items())
    if ratios:
        low, high = cost["step_ratio"].min(), cost["step_ratio"].max()
        said += f"; a whole step {low:.1f} to {high:.1f}"
    return Claim(
        "the SUPG terms of H6 cost six times those of H1 (time, {p,F,H,J}, TVD-RK2)", ratios,
        "within", SIX, source="paper", said=said, wanted=f"terms {SIX[0]:g} to {SIX[1]:g} times",
    )  # fmt: skip


def _distortion(table: pd.DataFrame) -> Claim:
    end = table["until"].max()
    held = table[table["press"].str.startswith("held") & (table["until"] == end)]
    particles = select(held, method=H1.name, operator=CONSISTENT.name)
    solids = select(held, method=B_BAR.name)
    stopped = solids[~solids["survived"].astype(bool)]
    fails = ", ".join(
        f"{row.lattice} diverged at {1e3 * row.diverged_at:.1f} ms" for row in stopped.itertuples()
    )
    hold = {
        "H1 runs": bool(len(particles)) and bool(sound(particles).all()),
        "B-bar diverges": bool(len(solids)) and len(stopped) == len(solids),
    }
    return Claim(
        "extremely large distortions run with H1 where mesh-based methods are not suitable "
        "(Fig. 12; held)", {name: float(value) for name, value in hold.items()}, ">=", 1.0,
        source="paper", wanted="H1 runs, B-bar diverges",
        said=f"to {1e3 * end:g} ms H1 runs in {sound(particles).sum()} of {len(particles)} cases "
        f"without folding ({particles['survived'].sum()} to the end), "
        f"B-bar in {solids['survived'].sum()} of {len(solids)}" + (f" ({fails})" if fails else ""),
    )  # fmt: skip


def _asked(table: pd.DataFrame) -> Iterator[Claim]:
    for what, apart in _tops(table, (H6, H1, SUPG)):
        best, worst = min(apart, key=apart.__getitem__), max(apart, key=apart.__getitem__)
        yield Claim(
            what, apart, "<=", TOLERANCE, wanted=f"within {1e3 * TOLERANCE:g} mm",
            said=f"{_mm(apart[best])} ({best}) to {_mm(apart[worst])} ({worst})",
        )  # fmt: skip
    kept = [
        _value("energy_kept", one_run(table, INITIAL, H1, operator))
        for operator in (LITERAL, CONSISTENT)
    ]
    yield Claim(
        "energy kept by H1 with the operator as printed, over the consistent one (initial)",
        kept[0] / kept[1], format=".2f",
    )  # fmt: skip


def _tops(
    table: pd.DataFrame, methods: Sequence[Method]
) -> Iterator[tuple[str, dict[str, float]]]:
    """What is compared, and by method how far the range of the top face is from it [m]."""
    for level, name in ((0, "coarsest lattice"), (1, "next lattice")):
        for reading in READINGS:
            runs = {m.name: one_run(table, reading, m, level=level) for m in methods}
            runs = {method: run for method, run in runs.items() if len(run)}
            solids = elements(table, reading)
            if not runs or len(solids) == 0:
                continue
            finest = solids.iloc[[-1]]
            outside = dict(zip(_ENDS, INDEPENDENT[reading.name], strict=True))
            references = {
                "B-bar of the same lattice": one_run(table, reading, B_BAR, level=level),
                f"B-bar {finest['lattice'].iloc[0]}": finest,
                "an independent hexahedral FE": pd.DataFrame([outside]),
            }
            for what, reference in references.items():
                if len(reference):
                    apart = {method: _apart(run, reference) for method, run in runs.items()}
                    yield f"{reading.name}, {name}: range of the top face at 15 ms as {what}", apart


def _of_the_default(table: pd.DataFrame) -> Iterator[Claim]:
    """The package default: it must not fold, and have the shape of the elements."""
    runs = select(table, method=PACKAGE.name)
    if len(runs) == 0:
        return
    good = sound(runs)
    yield Claim.counted(
        "no run folds or diverges", int(good.sum()), len(runs), where=PACKAGE.name,
        said=f"{good.sum()} of {len(runs)}", wanted="all",
    )  # fmt: skip
    # With nothing that damps the elements ring too: their noise is what it is held against.
    noise = {
        reading.name: _value("noise_mean", one_run(table, reading, PACKAGE))
        / _value("noise_mean", one_run(table, reading, B_BAR))
        for reading in READINGS
    }
    yield Claim(
        f"pressure noise over that of {B_BAR.name}, coarsest lattice", noise, where=PACKAGE.name,
        format=".2f",
    )  # fmt: skip
    for what, apart in _tops(table, (PACKAGE,)):
        yield Claim(
            what, apart[PACKAGE.name], "<=", TOLERANCE, where=PACKAGE.name,
            said=_mm(apart[PACKAGE.name]), wanted=f"within {1e3 * TOLERANCE:g} mm",
        )  # fmt: skip


def _mm(distance: float) -> str:
    return "folded or diverged" if math.isinf(distance) else f"{1e3 * distance:.1f} mm"


def _apart(run: pd.DataFrame, reference: pd.DataFrame) -> float:
    """How far the range of the top face is from another [m]; nowhere near where it has none."""
    apart = _largest(run.iloc[0], reference.iloc[0], _ENDS)
    return apart if _is_sound(run) and not math.isnan(apart) else math.inf


def _largest(one: pd.Series, other: pd.Series, names: Sequence[str]) -> float:
    """Largest difference of these columns; nan where one is missing."""
    return float(np.max([abs(float(one[name]) - float(other[name])) for name in names]))
