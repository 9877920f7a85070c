"""Tables of the pages on stability and on operators, as functions of the reports.

Each gives nothing (``None``) where a report lacks what it needs; the page then has no such table.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from studies.measures.tables import select

if TYPE_CHECKING:
    from studies.pages.reports import Reports

#: How the names of cases begin that only a few methods run.
_LONG = ("long column", "fast column")
#: What the studies call a row whose stress was recovered; alone, or behind the variant that it is.
_RECOVERED = "recovered stress"
#: Parts of the study of spectra that have figures or tables of their own.
_ELSEWHERE = ("map", "limits", "larger")


def limits(reports: Reports) -> pd.DataFrame | None:
    """CFL numbers of tenfold growth in 1000 (in 50) steps: a row for each Poisson's ratio."""
    found = reports["stability"].table(
        "limits", "integrator", "formulation", "nu", "cfl_slow", "cfl_fast"
    )
    if found is None or len(found) == 0:
        return None
    said = [f"{slow:.2f} ({fast:.2f})"
            for slow, fast in zip(found["cfl_slow"], found["cfl_fast"], strict=True)]  # fmt: skip
    named = found.assign(setting=found["integrator"] + ", " + found["formulation"], said=said)
    wide = named.pivot_table(index="nu", columns="setting", values="said", aggfunc="first")
    ordered = wide[list(dict.fromkeys(named["setting"]))].fillna("–")
    return ordered.rename_axis(columns=None).reset_index()


def growth(reports: Reports) -> pd.DataFrame | None:
    """What grows in a free block, one choice changed at a time."""
    found = reports["stability"].table(
        "spectrum", "scan", "base", "variant", "body", "size", "nu", "cfl", "max_g", "mode",
        "cfl_slow", "cfl_fast",
    )  # fmt: skip
    if found is None:
        return None
    shown = select(found[~found["scan"].isin(_ELSEWHERE)], body="free")
    return shown.assign(growth=shown["max_g"] - 1.0)


def hard_map(reports: Reports, *, long: bool) -> pd.DataFrame | None:
    """Cases against methods: the share of the energy that is left, and what became of the run.

    ``long`` chooses the long columns.  Of the short cases only methods are shown that were put to
    most of them: variants of one method are compared in the report.
    """
    found = reports["stability"].table(
        "table", "case", "method", "energy_kept", "unseen_rms", "verdict", "why"
    )
    if found is None:
        return None
    part = found[found["case"].str.startswith(_LONG) == long]
    cases = list(dict.fromkeys(part["case"]))
    counts = part.groupby("method", sort=False)["case"].nunique()
    methods = [str(name) for name, count in counts.items() if 4 * count > 3 * len(cases)]
    if not cases or not methods:
        return None
    said = {(row["case"], row["method"]): _outcome(row) for row in part.to_dict("records")}
    return pd.DataFrame(
        [{"case": case} | {name: said.get((case, name), "–") for name in methods}
         for case in cases]
    )  # fmt: skip


def _outcome(row: dict[str, object]) -> str:
    """``0.975``, ``0.640, folded``, ``diverged``."""
    from studies.stability.judgement import ABSENT, DIVERGED, SOUND, USELESS

    verdict, kept = row["verdict"], row["energy_kept"]
    if verdict == ABSENT:
        return "–"
    # Earlier reports had another word for it.
    if verdict not in (SOUND, USELESS) or not isinstance(kept, float):
        return DIVERGED
    text = f"{kept:.3f}" if kept >= 0.01 else f"{kept:.0e}"
    if verdict != USELESS:
        return text
    return f"{text}, folded" if "folded" in str(row["why"]) else f"{text}, useless"


def hard_short(reports: Reports) -> pd.DataFrame | None:
    """The hard cases that every method is put to."""
    return hard_map(reports, long=False)


def hard_long(reports: Reports) -> pd.DataFrame | None:
    """The long columns."""
    return hard_map(reports, long=True)


def pulse(reports: Reports) -> pd.DataFrame | None:
    """A velocity pulse a few spacings wide."""
    return reports["stability"].table("pulse", "method", "nu", "energy_left", "error", "lag")


def variants(reports: Reports) -> pd.DataFrame | None:
    """One choice of the consistent operator changed at a time."""
    return reports["operators"].table(
        "table", "variant", "slope_p", "slope_P", "p_x_17", "P_xx_17", "twist_4x19x4",
        "energy_4x19x4", "pressure_99_6x31x6",
    )  # fmt: skip


def by_parts(reports: Reports) -> pd.DataFrame | None:
    """One choice inside ``SummationByParts`` changed at a time, on the finest level it was run."""
    levels = reports["clouds"].table("levels", "variant", "h", "p_x", "P_xx", "slope_p", "slope_P")
    effort = reports["clouds"].table("setup", "variant", "h", "neighbours", "iterations")
    if levels is None or effort is None:
        return None
    names = levels["variant"].fillna("").astype(str)
    own = levels[(names != "") & ~names.str.endswith(_RECOVERED)]
    known = effort[effort["variant"].notna()][["variant", "h", "neighbours", "iterations"]]
    both = own.merge(known, on=["variant", "h"], how="left")
    if len(both) == 0:
        return None
    # The finest level that has all of them: some were run on finer ones.
    count = both.groupby("h")["variant"].nunique()
    return select(both, h=count[count == count.max()].index.min())


def recovery(reports: Reports) -> pd.DataFrame | None:
    """Stress of ``SummationByParts`` at large strain, of the particles and recovered."""
    needed = ("cloud", "operator", "formulation", "scene", "family", "variant", "h", "P_xx",
              "slope_P")  # fmt: skip
    levels = reports["clouds"].table("levels", *needed)
    if levels is None:
        return None
    usual = select(levels, operator="SummationByParts", formulation="{p,F}", scene="manufactured",
                   family="A+B+C=0")  # fmt: skip
    plain, fits = usual[usual["variant"].isna()], select(usual, variant=_RECOVERED)
    both = plain.merge(fits, on=["cloud", "h"], suffixes=("", "_recovered"))
    # The last refinement of each cloud.
    return both.sort_values("h").groupby("cloud", sort=False).head(1).sort_values("cloud")


def cloud_limits(reports: Reports) -> pd.DataFrame | None:
    """CFL numbers of tenfold growth in 1000 steps by cloud, and the least distance there."""
    return reports["clouds"].table("spectrum", "cloud", "operator", "h_min_over_dx", "slow")
