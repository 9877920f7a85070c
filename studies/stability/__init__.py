"""Where does each method break?  Hard cases in time, and the spectrum of one step.

``python -m studies.stability``; ``--part`` runs one of the two halves.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.engine.claims import Claim, Source
from studies.engine.study import Case, Results, Row, Study, Tables
from studies.measures.indicators import FLUCTUATES, REMOVED
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE, SUPG, UNSTABILISED, Method
from studies.stability import waves
from studies.stability.hard_cases import (
    AT_200,
    AT_300,
    CASES,
    FAST_COLUMN,
    FINE,
    LONG,
    LONG_COLUMN,
    LONG_METHODS,
    METHODS,
    OTHER_STEPS,
    PAPER_COLUMN,
    PRINTED,
    RK3,
    STABILISED,
    VARIANTS,
    WITHOUT_J,
    WITHOUT_TAU_P,
    hard_cases,
    hard_table,
    tiny_cases,
)
from studies.stability.hard_problems import SEED_LEFT, Column
from studies.stability.judgement import (
    ABSENT,
    CRITERIA,
    DIVERGED,
    SOUND,
    USELESS,
    judged,
    overview,
)
from studies.stability.spectrum_cases import (
    default_limits_figure,
    limits_figure,
    map_figure,
    scans,
    spectrum_cases,
    spectrum_tables,
    tiny_spectra,
)
from studies.stability.spectrum_growth import LIMITS, NEUTRAL

#: Change of the share of energy kept that counts as none, and work that is round-off.
SAME, ROUND_OFF = 0.02, 1.0e-9
#: Self-adjoint SUPG where the formulation is left to the material, or the smaller one is named.
OWN_SUPG = (SUPG.name, WITHOUT_J.name)
#: Asked of the package default: energy left of the long columns at 0.1 s, by cells a metre.
ENERGY_LEFT = {4: 0.97, 6: 0.99}
#: Of the column at 200 rad/s: energy, twist and noise; of that at 300 rad/s the height of its top.
ENERGY_AT_200, TWIST_AT_200, NOISE_AT_200, HEIGHT_AT_300 = 0.965, 0.01, 0.22, 0.02


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """The hard cases and the waves, then the spectra, or one of the two halves."""
    listed: list[Case] = []
    if options.part != "spectrum":
        listed += [*hard_cases(quick=options.quick), *waves.wave_cases(quick=options.quick)]
    if options.part != "hard":
        listed += spectrum_cases(quick=options.quick)
    return listed


def warm_up(options: argparse.Namespace) -> Sequence[Case]:
    """Tiny cases of the halves that run."""
    hard = tiny_cases() if options.part != "spectrum" else ()
    return [*hard, *(tiny_spectra() if options.part != "hard" else ())]


def tables(rows: list[Row]) -> Tables:
    """``table``: the hard cases, judged; ``vibration``, ``pulse``; those of the spectrum."""
    hard = judged(hard_table(rows), {case.name: case.reference for case in CASES})
    return {"table": hard} | waves.wave_tables(rows) | spectrum_tables(rows)


# --- claims -------------------------------------------------------------------------------------


def claims(tables: Tables) -> list[Claim]:
    """What is said of stability; when some cases were not run, no more than a part holds."""
    table = tables["table"]
    missing = len({case.name for case in CASES} - set(table["case"]))
    partial = f"{missing} of {len(CASES)} cases were not run" if missing else ""
    hard = [claim(table, partial) for claim in HARD_CLAIMS]
    return [*waves.wave_claims(tables), *hard]


def _counted(
    what: str, runs: pd.DataFrame, holds: pd.Series[bool], partial: str, do: str, beside: str = "",
    **more: Any,
) -> Claim:  # fmt: skip
    """How many ``do``, what is to be known ``beside``, and the names of those that do not."""
    several = runs["method"].nunique() > 1
    names = [
        f"{row.case} ({row.method})" if several else str(row.case)
        for row in runs[~holds].itertuples()
    ]
    parts = [f"{int(holds.sum())} of {len(runs)} {do}", beside, "; ".join(names)]
    said = "; ".join(filter(None, [*parts[:2], f"not: {parts[2]}" if names else ""]))
    return Claim.counted(
        what, int(holds.sum()), len(runs), incomplete=partial, said=said, wanted=f"all {do}", **more
    )


def default_holds_its_shape(table: pd.DataFrame, partial: str) -> Claim:
    """With the package default no positions fold and no cell is inside out, in any case."""
    runs = select(table[table["verdict"] != ABSENT], method=PACKAGE.name)
    folded = runs["folded"].astype(bool) | (runs["inside_out"] > 0.0)
    return _counted(
        "no fold and no cell inside out in any hard case", runs,
        (runs["verdict"] != DIVERGED) & ~folded, partial, "hold their shape", where=PACKAGE.name,
    )  # fmt: skip


def default_is_sound(table: pd.DataFrame, partial: str) -> Claim:
    """The package default is sound in every case."""
    runs = select(table[table["verdict"] != ABSENT], method=PACKAGE.name)
    return _counted(
        "every hard case is sound with the package default", runs, runs["verdict"] == SOUND,
        partial, "are sound", where=PACKAGE.name,
    )  # fmt: skip


def default_keeps_its_energy(table: pd.DataFrame, partial: str) -> Claim:
    """Energy of the long columns at 0.1 s with the package default."""
    runs = select(table[table["case"].str.startswith(LONG_COLUMN)], method=PACKAGE.name)
    runs = runs[~runs["case"].str.contains("jitter") & runs["cells"].isin(ENERGY_LEFT)]
    asked = {row.case: ENERGY_LEFT[row.cells] for row in runs.itertuples()}
    return Claim(
        "energy left of the long columns at 0.1 s", _by_case(runs, "energy_at_tenth"), ">=", asked,
        where=PACKAGE.name, sound=_unfolded(runs), incomplete=partial, format=".3f",
        said=", ".join(f"{row.case.removeprefix(LONG_COLUMN).strip()}: {row.energy_at_tenth:.3f}"
                       for row in runs.itertuples()),
        wanted=", ".join(f"{least:g} on 1/{cells}" for cells, least in ENERGY_LEFT.items()),
    )  # fmt: skip


def _by_case(runs: pd.DataFrame, column: str) -> dict[str, float]:
    return dict(zip(runs["case"], runs[column].astype(float), strict=True))


def _unfolded(runs: pd.DataFrame) -> dict[str, bool]:
    good = ~runs["folded"].astype(bool) & (runs["verdict"] != DIVERGED)
    return dict(zip(runs["case"], map(bool, good), strict=True))


def _at(table: pd.DataFrame, case: str, method: Method) -> dict[str, Any]:
    """The row of a run; nothing where there is none."""
    runs = select(table, case=case, method=method.name)
    return dict(runs.iloc[0]) if len(runs) else {}


def _lasted(run: Mapping[str, Any]) -> bool:
    return bool(run) and run["verdict"] != DIVERGED


def default_at_200(table: pd.DataFrame, partial: str) -> Claim:
    """Energy, twist and noise of the column at 200 rad/s on 1/5 with the package default."""
    own, fine, same = (_at(table, AT_200, method) for method in (PACKAGE, FINE, B_BAR))
    what = f"{AT_200}: energy, twist and noise"
    if not own or not _lasted(fine):
        return Claim(what, {}, "<=", 1.0, where=PACKAGE.name)
    twist = abs(own["answer"] / fine["answer"] - 1.0)
    beside = f" ({B_BAR.name} {same['noise_end']:.2f})" if same else ""
    # Of each the share of what is allowed.
    parts = {
        "energy": (1.0 - own["energy_kept"]) / (1.0 - ENERGY_AT_200),
        "twist": twist / TWIST_AT_200, "noise": own["noise_end"] / NOISE_AT_200,
    }  # fmt: skip
    return Claim(
        what, parts, "<=", 1.0, where=PACKAGE.name,
        sound=_lasted(own) and not own["folded"], incomplete=partial,
        said=f"energy {own['energy_kept']:.3f}; twist off by {twist:.1%} from fine elements; "
        f"noise {own['noise_end']:.2f}{beside}",
        wanted=f"{ENERGY_AT_200:g}; {TWIST_AT_200:.0%}; {NOISE_AT_200:g}",
    )  # fmt: skip


def default_at_300(table: pd.DataFrame, partial: str) -> Claim:
    """Height of the top of the column at 300 rad/s on 1/8 with the package default."""
    own, fine = (_at(table, AT_300, method) for method in (PACKAGE, FINE))
    known = bool(own) and _lasted(fine)
    found = {"": abs(own["top_height"] / fine["top_height"] - 1.0)} if known else {}
    return Claim(
        f"{AT_300}: height of the top, from fine elements", found, "<=", HEIGHT_AT_300,
        where=PACKAGE.name, sound=_lasted(own) and not own["folded"], incomplete=partial,
        format=".1%",
    )  # fmt: skip


def positions_hold(table: pd.DataFrame, partial: str) -> Claim:
    """Positions fold in no hard case with self-adjoint SUPG as the package sets it."""
    lasted = table[~table["verdict"].isin([DIVERGED, ABSENT])]
    ours = lasted[lasted["method"].isin(OWN_SUPG)]
    theirs = select(lasted, method=B_BAR.name)
    folded = int(theirs["folded"].astype(bool).sum())
    return _counted(
        "positions do not fold in any hard case", ours, ~ours["folded"].astype(bool), partial,
        "do not fold", f"{B_BAR.name}: {len(theirs) - folded} of {len(theirs)}",
        where=", ".join(OWN_SUPG),
    )  # fmt: skip


def long_columns_are_sound(table: pd.DataFrame, partial: str) -> Claim:
    """Self-adjoint SUPG is sound on every lattice from nu 0.3 to 0.495."""
    runs = select(table[table["case"].str.startswith(LONG_COLUMN)], method=SUPG.name)
    what = "the column is sound on every lattice, nu 0.3 to 0.495, to 0.2 s"
    return _counted(
        what, runs, runs["verdict"] == SOUND, partial, "are sound", where=SUPG.name
    )


def every_case_has_a_method(table: pd.DataFrame, partial: str) -> Claim:
    """Every case is sound with some stabilised particle method."""
    runs = table[table["method"].isin([PACKAGE.name, *STABILISED])]
    best = runs.assign(sound=runs["verdict"] == SOUND, lasted=runs["verdict"] != DIVERGED)
    found = best.groupby("case", sort=False)[["sound", "lasted"]].any()
    by_case = found.reset_index().assign(method="")
    return _counted(
        "every hard case is sound with some stabilised method", by_case, by_case["sound"], partial,
        "are sound with one", f"{int(found['lasted'].sum())} run to their end with one",
    )  # fmt: skip


def one_method_for_all(table: pd.DataFrame, partial: str) -> Claim:
    """One and the same setting is sound in all cases.

    Only settings that ran the most cases count: a variant put to few is not compared.  The long
    columns, which only a few methods run, are judged on their own.  A seed that a method cannot
    have does not count against it.
    """
    names = [PACKAGE.name, *STABILISED, *(variant.name for variant in VARIANTS)]
    runs = _short(table[table["method"].isin(names)])
    runs = runs.assign(sound=runs["verdict"].isin([SOUND, ABSENT]))
    counts = runs.groupby("method", sort=False)["sound"].agg(["sum", "size"])
    compared = counts[counts["size"] == counts["size"].max()]
    best = compared["sum"].idxmax() if len(compared) else ""
    mine = runs[runs["method"] == best]
    return _counted(
        "one setting is sound in every case", mine, mine["sound"], partial, "are sound with it",
        where=f"best: {best}",
    )  # fmt: skip


def all_survive(table: pd.DataFrame, partial: str) -> Claim:
    """Columns and punches do not diverge with any stabilised method; surviving uselessly is only
    a part.
    """
    runs = _short(table[table["method"].isin(STABILISED)])
    runs = runs[runs["case"].str.contains("column|punch")]
    useless = int((runs["verdict"] == USELESS).sum())
    parts = [f"{useless} of them useless" if useless else "", partial]
    return _counted(
        "columns to 300 rad/s and nu 0.4999, disordered ones, and the punch survive", runs,
        runs["verdict"] != DIVERGED, "; ".join(filter(None, parts)), "run to their end",
        source="paper", where="stabilised methods",
    )  # fmt: skip


def seeds_decay(table: pd.DataFrame, partial: str) -> Claim:
    """All seeds are smaller at the end with every stabilised method."""
    seeded = table[table["case"].str.startswith("seeded")]
    runs = seeded[seeded["method"].isin(STABILISED)]
    others = seeded[seeded["method"].isin([variant.name for variant in VARIANTS])]
    cure = (others["verdict"] == SOUND).groupby(others["method"], sort=False).all()
    cured = [str(name) for name, sound in cure.items() if sound]
    return _counted(
        "hourglass, saw tooth, noise and checkerboard are damped", runs, runs["verdict"] == SOUND,
        partial, "decay", f"all do with {'; '.join(cured)}" if cured else "",
        source="paper", where="stabilised methods",
    )  # fmt: skip


def tension_is_stable(table: pd.DataFrame, partial: str) -> Claim:
    """Noise stays bounded in tension with every stabilised method."""
    runs = select(table[table["method"].isin(STABILISED)], case="pulled to stretch 2")
    grown = ", ".join(f"{answer:.2g}" for answer in runs["answer"])
    return _counted(
        "no tensile instability in the total Lagrangian frame", runs, runs["verdict"] == SOUND,
        partial, "are sound", f"growth of the noise to stretch 2: {grown}", source="paper",
        where="stabilised methods",
    )  # fmt: skip


def pressure_term_smooths(table: pd.DataFrame, partial: str) -> Claim:
    """Of pressure that fluctuates with ``tau_p = 0``, ``tau_p`` leaves at most ``REMOVED``."""
    return _smoothed(
        "it is tau_p that removes the fluctuations of the punch: noise with tau_p = 0 and with it",
        table, WITHOUT_TAU_P, partial, "paper",
    )  # fmt: skip


def stabilisation_smooths(table: pd.DataFrame, partial: str) -> Claim:
    """Of pressure that fluctuates without stabilisation, SUPG leaves ``REMOVED``."""
    return _smoothed(
        "stabilisation removes the fluctuations of the punch: noise without it and with it",
        table, UNSTABILISED.name, partial, "asked",
    )  # fmt: skip


def _smoothed(what: str, table: pd.DataFrame, without: str, partial: str, source: Source) -> Claim:
    runs = select(table, case="punch, initial")
    noise = runs[runs["survived"] == True].set_index("method")["noise_end"].to_dict()  # noqa: E712
    if not {SUPG.name, without} <= set(noise):
        return Claim(what, {}, "<=", REMOVED, source=source)
    before, after = float(noise[without]), float(noise[SUPG.name])
    return Claim(
        what, after / before, "<=", REMOVED, source=source, incomplete=partial,
        # Where there were no fluctuations, none were removed.
        sound=before >= FLUCTUATES, said=f"{before:.3f} to {after:.3f}",
        wanted=f"from at least {FLUCTUATES:g} to at most {REMOVED:.0%} of it",
    )  # fmt: skip


def damping_makes_no_energy(table: pd.DataFrame, partial: str) -> Claim:
    """The self-adjoint ``D(p)`` dissipates in every run."""
    known = table[(table["survived"] == True) & table["dissipated_p"].notna()]  # noqa: E712
    runs = known[known["method"].isin([*OWN_SUPG, RK3.name])]
    printed = table[table["method"].isin([PRINTED.name, PAPER_COLUMN.name])]
    made = int((printed["dissipated_p"] < -ROUND_OFF).sum())
    beside = f"as printed {len(printed) - made} of {len(printed)}" if len(printed) else ""
    return _counted(
        "the self-adjoint D(p) makes no energy", runs, runs["dissipated_p"] >= -ROUND_OFF, partial,
        "make none", beside, where="self-adjoint settings",
    )  # fmt: skip


def step_does_not_matter(table: pd.DataFrame, partial: str) -> Claim:
    """At CFL 0.5 and 0.8 as much energy is kept as usually within ``SAME``, and none diverges."""
    kept = table[table["answer_is"] != SEED_LEFT].pivot_table(
        index="case", columns="method", values="energy_kept"
    )
    change, diverged = pd.Series(dtype=float), 0
    if {SUPG.name, *OTHER_STEPS} <= set(kept):
        kept = kept.dropna(subset=[SUPG.name, *OTHER_STEPS])
        change = kept[[*OTHER_STEPS]].sub(kept[SUPG.name], axis=0).abs().max(axis=1)
        diverged = int((select(table, verdict=DIVERGED)["method"].isin(OTHER_STEPS)).sum())
    said = f"energy kept differs by at most {change.max():.4f}, {diverged} runs diverge"
    return Claim.counted(
        "results do not depend on the step up to CFL 0.8", int((change <= SAME).sum()),
        len(change) + diverged, incomplete=partial, wanted=f"at most {SAME}, none diverges",
        said=said if len(change) else "-", where=", ".join(OTHER_STEPS),
    )  # fmt: skip


def _short(table: pd.DataFrame) -> pd.DataFrame:
    return table[~_is_long(table)]


def _is_long(table: pd.DataFrame) -> pd.Series[bool]:
    """Cases that only a few methods run."""
    return table["case"].str.startswith((LONG_COLUMN, FAST_COLUMN))


HARD_CLAIMS: tuple[Callable[[pd.DataFrame, str], Claim], ...] = (
    default_holds_its_shape, default_is_sound, default_keeps_its_energy, default_at_200,
    default_at_300, positions_hold, long_columns_are_sound, every_case_has_a_method,
    one_method_for_all, all_survive, seeds_decay, tension_is_stable, pressure_term_smooths,
    stabilisation_smooths, damping_makes_no_energy, step_does_not_matter,
)  # fmt: skip


# --- report -------------------------------------------------------------------------------------


def hard_figure(results: Results) -> Figure:
    """Every short case with every method."""
    table = _short(results.tables["table"])
    return overview(table, {method.name: method.name for method in METHODS})


def long_figure(results: Results) -> Figure:
    """The long columns, and the fastest on a finer lattice."""
    table = results.tables["table"]
    long = table[_is_long(table)]
    return overview(long, {method.name: method.name for method in LONG_METHODS})


def variants_figure(results: Results) -> Figure:
    """Self-adjoint SUPG and what one change makes of it."""
    table = results.tables["table"]
    names = [variant.name for variant in VARIANTS]
    ours = table[table["case"].isin(table[table["method"].isin(names)]["case"])]
    labels = {name: name.removeprefix(f"{SUPG.name}, ") for name in names}
    return overview(ours, {SUPG.name: SUPG.name} | labels)


def words(tables: Tables) -> Mapping[str, Any]:
    """Criteria, failures and thresholds."""
    table, spectrum = tables["table"], tables["spectrum"]
    spectrum = spectrum.assign(growth=spectrum["max_g"] - 1.0)
    bad = table[~table["verdict"].isin([SOUND, ABSENT])]
    scanned = scans(spectrum)
    growing = spectrum[(spectrum["scan"] != "larger") & (spectrum["mode"] != "none")]
    columns = [case.problem for case in CASES if isinstance(case.problem, Column)]
    return {
        "published": Column(),
        "paper": PAPER_COLUMN.label,
        "fastest": f"{max(column.angular_velocity for column in columns):g}",
        "stiffest": f"{max(column.poisson_ratio for column in columns):g}",
        "softest": min(column.poisson_ratio for column in columns),
        "long_time": LONG,
        "sound_unseen": select(table, verdict=SOUND)["unseen_rms"].max(),
        "neutral": NEUTRAL,
        "criteria": CRITERIA,
        "thresholds": {name: limit - 1.0 for name, limit in LIMITS.items()},
        "default": PACKAGE.name,
        "failures": bad[["case", "method", "verdict", "why", "where"]],
        "failures_of_default": select(bad, method=PACKAGE.name),
        "short": _short(table),
        "long": table[_is_long(table)],
        "variants": table[table["method"].isin([variant.name for variant in VARIANTS])],
        "cases": dict(tuple(table.groupby("case", sort=False))),
        "maps": select(tables["spectrum_growth"], scan="map"),
        "scans": dict(tuple(scanned.groupby("base", sort=False))),
        "bases": select(scanned, scan="base"),
        "larger": select(spectrum, scan="larger"),
        "spectra": len(spectrum[spectrum["scan"] != "larger"]),
        "growing": dict(tuple(growing.groupby("mode"))),
        "waves": waves,
    }


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--part``: only one half of the study."""
    parser.add_argument(
        "--part", choices=("both", "hard", "spectrum"), default="both", help="default: %(default)s"
    )


STUDY = Study(
    name="stability",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={
        "hard_cases": hard_figure,
        "long_columns": long_figure,
        "hard_case_variants": variants_figure,
        "vibration": waves.vibration_figure,
        "spectrum_map": map_figure,
        "spectrum_limits": limits_figure,
        "default_limits": default_limits_figure,
    },
    words=words,
    arguments=arguments,
    warm_up=warm_up,
    text=Path(__file__).with_name("stability.md"),
    description="Hard cases in time and the spectrum of one step, for every method.",
)
