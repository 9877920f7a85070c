"""Where does the time of a step go, and how far is it from what the machine can do?

``python -m studies.speed`` times whole steps (all stages, time-step control, boundary conditions)
and single passes on the swinging cube, counts what they must compute and move, and measures the
machine's bandwidth and arithmetic in the same run.  Timings are minima of repeats on a shared
machine: compare the rows of one run, not runs of different days.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

import sphsolid as sph
from studies.engine.plotting import panels
from studies.engine.provenance import cores
from studies.engine.study import Case, Claim, Results, Row, Study, Tables
from studies.measures.tables import select
from studies.methods import B_BAR, DISPLACEMENT, PACKAGE, PAPER, SUPG, UNSTABILISED, Method
from studies.speed.timings import column, in_turns, machine_speed, plain, start_up, step

PF, PFJ, PFHJ, PLAIN = FORMULATIONS = (sph.PF(), sph.PFJ(), sph.PFHJ(), sph.Displacement())
DEFAULT, OWN_SUPG, PAPERS = PACKAGE, SUPG.but(formulation=PFJ), PAPER.but(formulation=PFJ)
RK3 = OWN_SUPG.but(integrator=sph.SSPRK3())
#: The paper's column has intrinsic times of its own.
ON_COLUMN = (
    DEFAULT,
    OWN_SUPG,
    RK3,
    PAPERS.but(xi_F=0.1, tau_p=sph.OfStep(0.1)),
)
#: CPU milliseconds a particle for 0.1 s of the 6x31x6 column with a tuned C++ SPH code: 790 steps
#: at 1.4 microseconds, losing 18 % of the energy.
OTHERS_COLUMN = 1.1
JITTER, MORE_JITTER = 0.2, 0.4
#: Asked of the default: a particle-step over an element-step of B-bar in the same run, by cells
#: along an edge; nanoseconds on jitter 0.4 with all threads; share of what the machine can do;
#: all threads over one; bytes a particle on a lattice.
OVER_ELEMENTS = {8: 1.2, 16: 0.85, 32: 0.6, 64: 0.6}
#: Cells along an edge on which all methods take turns.
USUAL = 32
ON_DISORDER, SHARE, THREADS_OVER_ONE, BYTES = 300.0, 0.5, 1.8, 400.0
COLUMNS = {
    "table": [
        "method", "cloud", "storage", "integrator", "cfl", "neighbours", "cells", "particles",
        "threads", "ns_per_particle_step", "ns_per_particle_crossing", "bytes_per_particle",
        "flops_per_particle", "traffic_per_particle", "roofline_share", "setup_s",
    ],
    "passes": [
        "method", "cloud", "cells", "particles", "threads", "pass", "ns_per_particle",
        "flops_per_particle", "traffic_per_particle", "roofline_share",
    ],
    "turns": ["method", "cells", "particles", "threads", "ns_per_particle_step", "spread"],
    "machine": ["threads", "bandwidth", "flops"],
    "column": [
        "method", "integrator", "particles", "steps", "evaluations", "cpu_s",
        "cpu_ms_per_particle", "energy_kept", "survived", "folded",
    ],
    "plain": ["particles", "ns_plain", "ns_compiled", "ratio"],
    "start": ["cold_s", "warm_s"],
}  # fmt: skip
KINDS = {"table": "step", "passes": "pass", "turns": "turn"}


def options() -> list[Method]:
    """Formulation x stabilisation x projection: what each option costs."""
    listed = []
    for fields in FORMULATIONS:
        bare = DISPLACEMENT if fields == PLAIN else UNSTABILISED.but(formulation=fields)
        own = SUPG.but(formulation=fields)
        printed = own.but(weighting=sph.AsPrinted())
        damped = [own.but(tau_p=sph.OfStep(0.1))] if fields in (PFJ, PFHJ) else []
        off = sph.NoProjection()
        listed += [bare, bare.but(angular_momentum=off), printed, own]
        listed += [own.but(angular_momentum=off), *damped]
        listed.append(own.but(secondary=sph.H6()))
    return listed


def _step(method: Method, cells: int, threads: int, jitter: float = 0.0) -> Case:
    key = f"{method.name} 1/{cells} {threads} thread(s)" + (f" jitter {jitter}" if jitter else "")
    arguments = {"method": method, "jitter": jitter, "cells": cells, "threads": threads}
    return Case(key, step, arguments, 1.0 + (cells / 32) ** 3)


def _turns(cells: int, counts: Sequence[int]) -> Case:
    methods = (DEFAULT, B_BAR, PAPERS, OWN_SUPG) if cells == USUAL else (DEFAULT, B_BAR)
    arguments = {"methods": methods, "cells": cells, "threads": tuple(counts)}
    return Case(f"in turns 1/{cells}", in_turns, arguments, 2.0 + (cells / 32) ** 3)


def cases(given: argparse.Namespace) -> list[Case]:
    """33^3 on one and all threads; the full form adds options, sizes, disorder and the column."""
    most = given.threads
    counts = sorted({1, most})
    listed = [Case(f"machine {n}", machine_speed, {"threads": n}, 0.5) for n in counts]
    first = (DEFAULT, OWN_SUPG, PAPERS, B_BAR)
    listed += [_step(method, 32, n) for n in counts for method in first]
    listed += [_turns(cells, counts) for cells in ([USUAL] if given.quick else OVER_ELEMENTS)]
    if given.quick:
        return listed
    listed += [_step(method, 32, most) for method in options() if method != OWN_SUPG]
    listed.append(_step(RK3, 32, most))
    listed += [
        _step(method, cells, n)
        for cells in OVER_ELEMENTS if cells != 32 for method in (DEFAULT, B_BAR) for n in counts
    ]  # fmt: skip
    listed += [_step(DEFAULT, 32, n, jitter) for jitter in (JITTER, MORE_JITTER) for n in counts]
    listed += [_step(method, 32, n, JITTER) for method in (OWN_SUPG, PAPERS) for n in counts]
    listed += [_step(OWN_SUPG, cells, most) for cells in (22, 64, 100)]
    listed.append(_step(PAPERS, 64, most))
    listed += [Case("plain 1/24", plain, {"cells": 24}), Case("start-up", start_up, {}, 2.0)]
    return listed + [
        Case(f"column {method.name}", column, {"method": method, "cells": 5})
        for method in ON_COLUMN
    ]


def warm_up(given: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel of the study."""
    methods = (DEFAULT, OWN_SUPG.but(tau_p=sph.OfStep(0.1)), PAPERS, B_BAR)
    listed = [_step(method, 2, given.threads) for method in methods]
    return [*listed, _step(DEFAULT, 2, given.threads, MORE_JITTER)]


def tables(rows: list[Row]) -> Tables:
    """``table`` of steps, ``passes``, ``turns``, ``machine``, ``column``, ``plain``, ``start``."""
    everything = pd.DataFrame(rows, columns=None if rows else ["kind"])
    found = {}
    for name, columns in COLUMNS.items():
        part = select(everything, kind=KINDS.get(name, name)).reindex(columns=columns)
        found[name] = part.reset_index(drop=True)
    for name, timed in (("table", "ns_per_particle_step"), ("passes", "ns_per_particle")):
        found[name]["roofline_share"] = 1.0e9 * _needs(found[name], found["machine"]) / (
            found[name][timed]
        )
    return found


def _needs(table: pd.DataFrame, machine: pd.DataFrame) -> pd.Series:
    """Seconds a particle that the machine itself would need for the traffic or the arithmetic."""
    speed = machine.set_index("threads")
    traffic = table["traffic_per_particle"] / table["threads"].map(speed["bandwidth"])
    return traffic.combine(table["flops_per_particle"] / table["threads"].map(speed["flops"]), max)


#: What claims call them.
_NAMES = {PAPERS: "the paper's", OWN_SUPG: "self-adjoint SUPG", DEFAULT: "the default"}


def claims(tables: Tables) -> list[Claim]:
    """What was aimed at; what was not run is left out."""
    return [claim for claim in _aims(tables) if not math.isnan(float(claim.measured))]  # type: ignore[arg-type]


def _aims(tables: Tables) -> Iterator[Claim]:
    steps = tables["table"]
    most = int(steps["threads"].max()) if len(steps) else 1

    def least(method: Method, column: str = "ns_per_particle_step", **wanted: Any) -> float:
        rows = select(steps, **({"method": method.name, "threads": most} | wanted))
        return float(rows[column].min())

    def in_turn(method: Method, cells: int, threads: int) -> float:
        rows = select(tables["turns"], method=method.name, cells=cells, threads=threads)
        return float(rows["ns_per_particle_step"].min())

    aim = partial(Claim, format=".4g")
    disorder, more = (f"jitter {jitter:g}" for jitter in (JITTER, MORE_JITTER))
    usual: dict[str, Any] = {"cloud": "lattice", "cells": 32}
    for cells in (32, 64):
        size, here = f"{cells + 1}^3", usual | {"cells": cells}
        what = "a particle-step of {}, lattice " + size
        yield aim(what.format("the paper's"), least(PAPERS, **here), "<=", 400, unit="ns")
        for method in (DEFAULT, OWN_SUPG):
            yield aim(what.format(_NAMES[method]), least(method, **here), unit="ns")
        yield aim(f"an element-step, B-bar {cells}^3", least(B_BAR, **here), "<=", 500, unit="ns")
    what = f"a particle-step of the paper's, {disorder}"
    yield aim(what, least(PAPERS, cloud=disorder), "<=", 800, unit="ns")
    sizes = select(steps, method=OWN_SUPG.name, threads=most, cloud="lattice")
    each = sizes.groupby("particles")["ns_per_particle_step"].min()
    if len(each) > 2:
        what = f"spread of the cost a particle, {each.index.min():.0f} to {each.index.max():.0f}"
        yield aim(what, float(each.max() / each.min() - 1.0), "<=", 0.25)
    for cloud, asked in (("lattice", 1500.0), (disorder, 4000.0)):
        held = least(PAPERS, "bytes_per_particle", cloud=cloud)
        yield aim(f"bytes a particle, {cloud}", held, "<=", asked)
    for method, name in _NAMES.items() if most > 1 else ():
        gain = in_turn(method, USUAL, 1) / in_turn(method, USUAL, most)
        yield aim(f"{most} threads over one, {name} step", gain, ">=", THREADS_OVER_ONE)
    for count, (cells, asked) in itertools.product(
        sorted({1, most}, reverse=True), OVER_ELEMENTS.items()
    ):
        what = f"particle-step of the default over element-step, {cells + 1}^3, {count} thread(s)"
        yield aim(what, in_turn(DEFAULT, cells, count) / in_turn(B_BAR, cells, count), "<=", asked)
    what = f"a particle-step of the default, {more}"
    yield aim(what, least(DEFAULT, cloud=more), "<=", ON_DISORDER, unit="ns")
    if "roofline_share" in steps:
        share = select(steps, method=DEFAULT.name, threads=most, **usual)["roofline_share"].max()
        yield aim("share of what the machine can do, the default step, 33^3", share, ">=", SHARE)
    held = least(DEFAULT, "bytes_per_particle", **usual)
    yield aim("bytes a particle of the default, lattice", held, "<=", BYTES)
    for row in tables["column"].itertuples():
        by_default = getattr(row, "method", "") == DEFAULT.name
        which = DEFAULT.name if by_default else row.integrator
        what = f"CPU time a particle of the column, {which}"
        yield aim(what, float(row.cpu_ms_per_particle), "<", OTHERS_COLUMN, unit="ms")
    for row in tables["start"].itertuples():
        for cache, took, asked in (("cold", row.cold_s, 60.0), ("warm", row.warm_s, 3.0)):
            what = f"first step of a process, {cache} cache"
            yield aim(what, float(took), "<", asked, unit="s")


def passes_figure(results: Results) -> Figure:
    """Bars of the passes of self-adjoint SUPG on all threads, and what the machine would need."""
    table = results.tables["passes"]
    figure, axes = panels(1, 1, width=6.4, height=2.6)
    ax: Any = axes[0, 0]
    shown = select(table, method=OWN_SUPG.name, cloud="lattice", threads=table["threads"].max())
    shown = shown[shown["cells"] == 32].drop_duplicates("pass")[::-1]
    if len(shown) == 0:
        ax.text(0.5, 0.5, "not run", transform=ax.transAxes, ha="center", va="center")
        return figure
    y, time, share = range(len(shown)), shown["ns_per_particle"], shown["roofline_share"]
    ax.barh(y, time, color=OWN_SUPG.colour, height=0.6, label="measured")
    ax.barh(y, time * share, color="0.3", height=0.6, label="the machine's limit")
    ax.set_yticks(list(y), list(shown["pass"]))
    ax.set(xlabel="ns a particle", xlim=(0.0, 1.3 * float(time.max())))
    for place, value, part in zip(y, time, share, strict=True):
        ax.text(value, place, f"  {value:.0f} ns, {part:.0%}", va="center", fontsize=8)
    ax.legend(loc="lower right")
    return figure


def words(tables: Tables) -> Mapping[str, Any]:
    """What is met, and the parts of the tables that the report shows."""
    steps, passes, machine = tables["table"], tables["passes"], tables["machine"]
    asked = [claim for claim in claims(tables) if claim.comparison != "reported"]
    missed = [claim.what for claim in asked if claim.verdict != "met"]
    names = [method.name for method in (DEFAULT, OWN_SUPG, *options())]
    most = steps["threads"].max()
    chosen = select(steps[steps["method"].isin(names)], cloud="lattice", cells=32, threads=most)
    units = {"bandwidth": machine["bandwidth"] / 1e9, "flops": machine["flops"] / 1e9}
    main = [DEFAULT.name, OWN_SUPG.name, RK3.name, PAPERS.name, B_BAR.name]
    crossing = select(steps, cloud="lattice", cells=32, threads=most).set_index("method")["cfl"]
    return {
        "asked": len(asked), "missed": missed, "options": chosen.drop_duplicates("method"),
        "main": steps[steps["method"].isin(main)], "speed": machine.assign(**units),
        "alone": select(passes[passes["method"].isin(main)], cells=32),
        "threads": most, "particles": 33**3, "other_cost": OTHERS_COLUMN,
        "longer": crossing.get(OWN_SUPG.name, math.nan) / crossing.get(PAPERS.name, math.nan),
        "nu": 0.495, "default": DEFAULT.name,
    }  # fmt: skip


def arguments(parser: argparse.ArgumentParser) -> None:
    """Timings run one at a time with all cores."""
    parser.set_defaults(jobs=1, threads=cores())


STUDY = Study(
    name="speed",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={"passes": passes_figure},
    words=words,
    text=Path(__file__).with_name("speed.md"),
    arguments=arguments,
    warm_up=warm_up,
    description="Cost of a step and of its passes, against the machine; each timing runs alone.",
)
