"""The paper's three claims beside others' methods, the package default, and what all must keep."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd

from studies.comparison.contenders import (
    AGREEING,
    BARE,
    DEFAULT,
    JSTS,
    PAPERS,
    PETROV,
    PRINTED,
)
from studies.comparison.tables import FOLDED, MEASURES, papers_column
from studies.engine.claims import Claim
from studies.engine.results import Tables
from studies.measures.tables import select
from studies.stability.judgement import SOUND
from studies.twisting_column.outside import NAME as OUTSIDE
from studies.twisting_column.outside import has_limit, twist_sequence
from studies.twisting_column.runs import lattice

COMMAND = "python -m studies.comparison"
#: "Comparable" is at most so many times the error; drift of a momentum over its scale.
COMPARABLE, DRIFT = 1.5, 1.0e-12
#: Asked of the twist of four meshes at 0.1 s: how far the finest ones are from each other, and
#: their limits from that of the code outside.
AGREE, LIMIT = 0.02, 0.01


def claims(tables: Tables) -> list[Claim]:
    """The paper's first, then the default, conservation and the hard cases."""
    return [
        *_of_accuracy(tables["table"]), *_of_cost(tables["cost"]), *_of_petrov(tables),
        *_of_the_default(tables["table"]), *_of_conservation(tables["spin"]),
        *_of_agreement(papers_column(tables["runs"])), *_of_soundness(tables["runs"]),
    ]  # fmt: skip


def errors(table: pd.DataFrame, name: str) -> Mapping[str, float]:
    """The errors of a method at equal particles, by their words."""
    own = select(table, method=name)
    return {
        words: float(own[column].iloc[0]) if len(own) else math.nan
        for column, words in MEASURES.items()
    }


def ratios(table: pd.DataFrame, name: str, over: str) -> dict[str, float]:
    """Errors of a method over those of another, where both are known."""
    one, other = errors(table, name), errors(table, over)
    found = {words: value / other[words] for words, value in one.items()}
    return {words: value for words, value in found.items() if not math.isnan(value)}


def _kept(table: pd.DataFrame, names: Sequence[str]) -> dict[str, bool]:
    """By the words of a measure: whether the positions of none of these methods had folded."""
    own = table[table["method"].isin(list(names))]
    return {
        words: not (column in FOLDED and bool(own[FOLDED[column]].astype(bool).any()))
        for column, words in MEASURES.items()
    }


def compared(what: str, table: pd.DataFrame, name: str, over: str, **more: Any) -> Claim:
    """A claim on the ratios of errors; where one of both folded it does not hold."""
    found, kept = ratios(table, name, over), _kept(table, (name, over))
    sound = {words: kept[words] for words in found}
    return Claim(what, found, sound=sound, where=COMMAND, **more)


def _of_accuracy(table: pd.DataFrame) -> Iterator[Claim]:
    for own in (PAPERS, PRINTED):
        yield compared(
            "1. SUPG-SPH is more accurate than JST-SPH at equal particles: error of JST over that "
            f"of {own.name}",
            table, JSTS.name, own.name, comparison=">", asked=1.0, source="paper", format=".2f",
        )  # fmt: skip


def added(cost: pd.DataFrame, name: str) -> dict[str, float]:
    """Seconds a step that a dissipation adds to its own method without it, by lattice."""
    found = {}
    for cells in sorted(cost["cells"].unique()):
        own, bare = (
            select(cost, method=one, cells=cells)["step_s"] for one in (name, BARE[name].name)
        )
        if len(own) and len(bare):
            found[f"column 1/{cells}"] = float(own.iloc[0] - bare.iloc[0])
    return found


def _of_cost(cost: pd.DataFrame) -> Iterator[Claim]:
    jst, supg = added(cost, JSTS.name), added(cost, PAPERS.name)
    yield Claim(
        "2. SUPG-SPH saves the cost of harmonic and biharmonic operators: what JST adds to a step "
        "over what SUPG adds",
        {where: jst[where] / supg[where] for where in jst if where in supg}, ">", 1.0,
        source="paper", where=COMMAND, format=".2f",
    )  # fmt: skip
    whole = {
        f"column 1/{cells}": _step(cost, JSTS.name, cells) / _step(cost, PAPERS.name, cells)
        for cells in sorted(cost["cells"].unique())
    }
    yield Claim(
        "the whole step of JST-SPH over that of SUPG-SPH, each with its kernel", whole,
        where=COMMAND, format=".2f",
    )  # fmt: skip


def _step(cost: pd.DataFrame, name: str, cells: int) -> float:
    own = select(cost, method=name, cells=cells)["step_s"]
    return float(own.iloc[0]) if len(own) else math.nan


def _of_petrov(tables: Tables) -> Iterator[Claim]:
    yield compared(
        "3. its accuracy is comparable to that of PG-FEM: error of SUPG-SPH over that of PG-FEM",
        tables["table"], PAPERS.name, PETROV.name, comparison="<=", asked=COMPARABLE,
        source="paper", format=".2f",
    )  # fmt: skip


def _of_the_default(table: pd.DataFrame) -> Iterator[Claim]:
    """Against each method of the paper; its own numbers are in the tables."""
    for other in (PAPERS, JSTS, PETROV):
        what = f"4. {DEFAULT.name} beside them: its error over that of {other.name}"
        yield compared(what, table, DEFAULT.name, other.name, format=".2g")


def _of_conservation(spin: pd.DataFrame) -> Iterator[Claim]:
    for kind in ("linear", "angular"):
        own = spin[["method", f"{kind}_drift"]]
        drifts = dict(zip(own["method"], own[f"{kind}_drift"].astype(float), strict=True))
        if not drifts:
            continue
        above = {name: value for name, value in drifts.items() if not value <= DRIFT}
        largest = max(drifts.values(), key=lambda value: math.inf if value != value else value)
        said = f"{len(drifts) - len(above)} of {len(drifts)}; largest {largest:.1e}"
        said += "".join(f"; {name} {value:.1e}" for name, value in above.items())
        yield Claim(
            f"{kind} momentum of a free spinning cube drifts by at most {DRIFT:g} of its scale",
            drifts, "<=", DRIFT, where=COMMAND, said=said,
        )  # fmt: skip


def _of_agreement(columns: pd.DataFrame) -> Iterator[Claim]:
    """Meshes that share nothing but the scene come to one twist, and to that of another code."""
    found = {
        one.name: twist_sequence(columns, one.name)
        for one in AGREEING
        if has_limit(columns, one.name)
    }
    if len(found) < 2:
        return
    finest = {name: float(each.twist[-1]) for name, each in found.items()}
    middle = 0.5 * (max(finest.values()) + min(finest.values()))
    listed = ", ".join(
        f"{name} {finest[name]:.3f} on {lattice(each.cells[-1])}" for name, each in found.items()
    )
    spread = (max(finest.values()) - min(finest.values())) / middle
    yield Claim(
        "twist of the column at 0.1 s on the finest meshes, largest less smallest", spread, "<=",
        AGREE, where=COMMAND, said=f"{100.0 * spread:.1f}%: {listed} rad", format=".0%",
    )  # fmt: skip
    limits = {name: abs(each.limit_error) for name, each in found.items()}
    listed = ", ".join(
        f"{name} {100.0 * each.limit_error:+.2f}% ± {100.0 * each.limit_within:.2f}"
        for name, each in found.items()
    )
    yield Claim(
        f"limit of that twist against {OUTSIDE}", limits, "<=", LIMIT, where=COMMAND, said=listed,
        format=".0%",
    )  # fmt: skip


def _of_soundness(runs: pd.DataFrame) -> Iterator[Claim]:
    """How many of the default's runs in time were of use; the first table counts all methods'."""
    own = select(runs, method=DEFAULT.name)
    if len(own):
        hold = own["verdict"] == SOUND
        yield Claim.counted(
            f"runs of {DEFAULT.name} that are sound", int(hold.sum()), len(own),
            where=", ".join(own["case"][~hold]) or COMMAND,
        )  # fmt: skip
