"""The parts of the default, each varied alone: ``python -m studies.restraint``.

How stiff and how viscous the restraint is, and which Jacobian the volumetric energy sees, on
columns, a punch, a free vibration and the cube with a known solution.  What stiffens pairs under
pressure acts off lattices: it is varied on a pressed cube and on one with a known solution.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import sphsolid as sph
from sphsolid.defaults import H_OVER_DX_RESTRAINED
from sphsolid.errors import Diverged
from sphsolid.scenes import Box, Constraint, Scene
from sphsolid.scheme.term import TermOption
from studies.engine.plotting import panels
from studies.engine.study import Case, Claim, Results, Row, Study, Tables, run_study
from studies.measures import folding
from studies.measures.swinging_cube import MOVING, cube_scene, period_errors_of
from studies.methods import PACKAGE, SUPG, Method
from studies.stability.hard_problems import Column, Problem, Punch
from studies.stability.waves import vibration

#: What is varied, its values, and which of them the default has.
STIFFNESSES = (10.0, 20.0, 40.0, 80.0, 200.0, 800.0)
VISCOSITIES = (0.0, 0.005, 0.01, 0.02, 0.04)
HELD = (0.1, 1.0, 100.0)
COMPRESSED = (0.0, 0.1, 0.2, 0.4, 0.8)
#: Smoothing lengths over the spacing, off lattices.
SUPPORTS = (0.9, 1.0, 1.1, 1.2)
#: What presses on a cube of disordered particles, over the shear modulus, and its discretisation.
PRESSURES = (2.0, 4.0, 8.0)
PRESSED_BODY, PRESSED_SPACING, PRESSED_STEPS = Box(jitter=0.3), 0.2, 200
#: Cells a metre of the disordered cube with a known solution.
DISORDERED_BODY, DISORDERED = Box(jitter=0.4), (8, 16)
#: A factor in the stiffness over which nothing needs to be tuned.
ASKED_RANGE = 20.0
#: Cells a metre of the cube and of the block that vibrates.
CUBE, BLOCK = 16, 8


@dataclass(frozen=True)
class HardRun:
    """A problem, and how many cells a metre it is run with."""

    problem: Problem
    cells: int


HARD = {
    "column nu 0.3, 1/4": HardRun(Column(poisson_ratio=0.3, end_time=0.2), 4),
    "column nu 0.495, 1/4": HardRun(Column(end_time=0.2), 4),
    "column 200 rad/s, 1/5": HardRun(Column(200.0), 5),
    "punch, initial": HardRun(Punch(held=False), 20),
    "punch, held": HardRun(Punch(held=True), 20),
}
NUS = (0.3, 0.495)


def variants() -> dict[tuple[str, str], Method]:
    """By what is varied and its value, the default among them under each."""
    restraints = {
        ("stiffness", f"{c:g}"): sph.Restraint(stiffness=sph.Quartic(c)) for c in STIFFNESSES
    } | {
        ("stiffness", "none"): sph.Restraint(stiffness=sph.NoStiffness()),
        ("stiffness", "elastic"): sph.Restraint(stiffness=sph.Elastic()),
    } | {
        ("viscosity", f"{v:g}"): sph.Restraint(viscosity=v) for v in VISCOSITIES
    } | {
        ("viscosity", "0.02 in every step"): sph.Restraint(spaced=False)
    }
    dilatations: dict[tuple[str, str], TermOption] = {
        ("dilatation", "own"): sph.OwnDilatation(),
        ("dilatation", "order 1"): sph.FilteredDilatation(order=1),
        ("dilatation", "order 2"): sph.FilteredDilatation(),
    } | {
        ("dilatation", f"order 2, beta {beta:g}"): sph.FilteredDilatation(beta=beta)
        for beta in HELD
    }
    made = {key: PACKAGE.but(stabilisation=option) for key, option in restraints.items()}
    return made | {key: PACKAGE.but(dilatation=option) for key, option in dilatations.items()}


def off_lattices() -> dict[str, Method]:
    """By the share of the compressive stress that stiffens a pair."""
    return {
        f"{c:g}": PACKAGE.but(stabilisation=sph.Restraint(stiffness=sph.Quartic(compressed=c)))
        for c in COMPRESSED
    }


def supports() -> dict[str, Method]:
    """By the smoothing length over the spacing: how many neighbours a particle has."""
    return {f"{h:g}": PACKAGE.but(h_over_dx=h) for h in SUPPORTS}


#: The default's own value of each part.
DEFAULT = {"stiffness": "40", "viscosity": "0.02", "dilatation": "order 2"}


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """Every variant on every problem; the short form has the default's values and one more each."""
    listed = []
    for (part, value), method in variants().items():
        if options.quick and value not in (*DEFAULT.values(), "none", "own"):
            continue
        named = {"part": part, "value": value, "method": method}
        for problem in list(HARD)[:1] if options.quick else HARD:
            key = f"{problem}: {part} {value}"
            listed.append(Case(key, run_hard, named | {"problem": problem}, cost=2.0))
        for nu in () if options.quick else NUS:
            listed.append(
                Case(f"vibration nu {nu:g}: {part} {value}", run_vibration, named | {"nu": nu})
            )
            listed.append(Case(f"cube nu {nu:g}: {part} {value}", run_cube, named | {"nu": nu}))
    for value, method in (off_lattices() | {SUPG.name: SUPG}).items():
        named = {"part": "compressed", "value": value, "method": method}
        for pressure in PRESSURES[-1:] if options.quick else PRESSURES:
            key = f"pressed by {pressure:g} mu: compressed {value}"
            listed.append(Case(key, run_pressed, named | {"pressure": pressure}))
    disordered = {"compressed": off_lattices(), "h/dx": supports()}
    for part, methods in disordered.items() if not options.quick else ():
        for (value, method), nu, cells in itertools.product(methods.items(), NUS, DISORDERED):
            named = {"part": part, "value": value, "method": method, "nu": nu, "cells": cells}
            key = f"disordered cube nu {nu:g}: {part} {value}, {cells}"
            listed.append(Case(key, run_cube, named | {"body": DISORDERED_BODY}))
    return listed


def run_pressed(*, part: str, value: str, method: Method, pressure: float) -> list[Row]:
    """What is left of the kinetic energy of noise in a nearly incompressible cube that is held."""
    rubber = sph.NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.495, density=1000.0)
    side = (1.0 - pressure * rubber.mu / rubber.kappa) ** (1.0 / 3.0)
    held = tuple(Constraint(f"{axis}{end}", "normal") for axis in "XYZ" for end in "-+")
    sim = method.simulation(
        Scene(
            "pressed", PRESSED_BODY, rubber, 1.0,
            initial_displacement=lambda X: X * (side - 1.0),
            initial_velocity=lambda X: 1.0e-6 * np.random.default_rng(0).normal(size=X.shape),
            constraints=held,
        ),
        spacing=PRESSED_SPACING,
    )  # fmt: skip
    row: Row = {"kind": "pressed", "part": part, "value": value, "pressure": pressure}
    start = sim.snapshot().kinetic_energy
    try:
        for _ in range(PRESSED_STEPS):
            sim.advance(sim.stable_time_step())
    except Diverged:
        return [row | {"kept": math.inf}]
    return [row | {"kept": sim.snapshot().kinetic_energy / start}]


def run_hard(*, part: str, value: str, method: Method, problem: str) -> list[Row]:
    """Whether positions hold, the energy that is left and the range of the particles' ``J``."""
    hard = HARD[problem]
    row = hard.problem.row(method, 1.0 / hard.cells)
    return [{"kind": "hard", "part": part, "value": value, "problem": problem} | row]


def run_vibration(*, part: str, value: str, method: Method, nu: float) -> list[Row]:
    """Frequency and damping of the clamped block's lowest mode."""
    (row,) = vibration(method=method, nu=nu, cells=BLOCK)
    return [row | {"kind": "vibration", "part": part, "value": value}]


def run_cube(
    *, part: str, value: str, method: Method, nu: float, cells: int = CUBE, body: Box | None = None
) -> list[Row]:
    """Errors at large strain over one period, with a wave that begins moving."""
    scene = cube_scene(MOVING[1], "A+B+C=0", poisson_ratio=nu)
    scene = scene if body is None else replace(scene, body=body)
    sim = method.simulation(scene, spacing=1.0 / cells)
    try:
        errors = period_errors_of(sim)
    except Diverged:
        errors = {}
    found = {
        f"error_{field}": max(
            (error for name, error in errors.items() if name.startswith(f"{field}_")),
            default=math.nan,
        )
        for field in ("p", "P")
    }
    kind = "cube" if body is None else "disordered"
    named = {"kind": kind, "part": part, "value": value, "nu": nu, "cells": cells}
    return [named | found | folding.folding(sim)]


HARD_COLUMNS = [
    "part", "value", "problem", "survived", *folding.COLUMNS, "energy_kept", "J_min", "J_max",
    "noise", "answer", "steps",
]  # fmt: skip
VIBRATION_COLUMNS = ["part", "value", "nu", "frequency_error", "damping_ratio", "energy_left"]
CUBE_COLUMNS = ["part", "value", "nu", "cells", "error_p", "error_P", *folding.COLUMNS]
PRESSED_COLUMNS = ["value", "pressure", "kept"]


def tables(rows: list[Row]) -> Tables:
    """``table``: a row a variant; ``hard``, ``vibration`` and ``cube`` have a row a run."""
    frame = pd.DataFrame(rows, columns=None if rows else ["kind"])

    def of(kind: str, columns: list[str]) -> pd.DataFrame:
        return frame[frame["kind"] == kind].reindex(columns=columns).reset_index(drop=True)

    hard, waves, cubes = (
        of("hard", HARD_COLUMNS), of("vibration", VIBRATION_COLUMNS), of("cube", CUBE_COLUMNS)
    )  # fmt: skip
    summary = []
    for part, value in variants():
        own = hard[(hard["part"] == part) & (hard["value"] == value)]
        if not len(own):
            continue
        row: Row = {
            "part": part, "value": value, "default": DEFAULT[part] == value, "runs": len(own),
            "sound": int(folding.sound(own).sum()),
            "not_sound": ", ".join(own["problem"][~folding.sound(own)]),
        }  # fmt: skip
        for nu in NUS:
            wave = waves[(waves["part"] == part) & (waves["value"] == value) & (waves["nu"] == nu)]
            cube = cubes[(cubes["part"] == part) & (cubes["value"] == value) & (cubes["nu"] == nu)]
            row |= {
                f"frequency_{nu:g}": wave["frequency_error"].mean(),
                f"damping_{nu:g}": wave["damping_ratio"].mean(),
                f"error_p_{nu:g}": cube["error_p"].mean(),
                f"error_P_{nu:g}": cube["error_P"].mean(),
            }  # fmt: skip
        summary.append(row)
    return {
        "table": pd.DataFrame(summary), "hard": hard, "vibration": waves, "cube": cubes,
        "pressed": of("pressed", PRESSED_COLUMNS), "disordered": of("disordered", CUBE_COLUMNS),
    }  # fmt: skip


def claims(tables: Tables) -> list[Claim]:
    """Over which factor of the stiffness as many runs are sound as with the default."""
    table = tables["table"]
    stiff = table[(table["part"] == "stiffness") & ~table["value"].isin(["none", "elastic"])]
    if len(stiff) < 2:
        return []
    own = int(stiff["sound"][stiff["default"]].iloc[0])
    values = stiff["value"].astype(float)
    at = float(DEFAULT["stiffness"])
    good = values[stiff["sound"] >= own]
    worse = values[stiff["sound"] < own]
    low = good[good > worse[worse < at].max()] if (worse < at).any() else good
    span = low[low < worse[worse > at].min()] if (worse > at).any() else low
    found = [
        Claim(
            "the stiffness of the restraint needs no tuning: factor over which as many runs are "
            f"sound as with {PACKAGE.name}",
            float(span.max() / span.min()), ">=", ASKED_RANGE, where=PACKAGE.name,
        )
    ]  # fmt: skip
    for part, value in (("stiffness", "none"), ("viscosity", "0"), ("dilatation", "own")):
        rows = table[(table["part"] == part) & (table["value"] == value)]
        if len(rows):
            row = rows.iloc[0]
            what = f"sound runs of {row['runs']} with {part} {value}"
            found.append(Claim(what, float(row["sound"]), where=row["not_sound"], format=".0f"))
    pressed = tables["pressed"]
    for value in (f"{sph.Quartic().compressed:g}", "0"):
        rows = pressed[pressed["value"] == value]
        if len(rows):
            row = rows.loc[rows["kept"].idxmax()]
            what = "kinetic energy of noise that a pressed cube of disordered particles"
            claim = Claim(
                f"{what} keeps, compressed = {value}", float(row["kept"]),
                where=f"{row['pressure']:g} mu",
            )  # fmt: skip
            found.append(claim if value == "0" else replace(claim, comparison="<=", asked=1.0))
    return found


def map_figure(results: Results) -> Figure:
    """Sound runs, frequency and stress errors by the value of each part."""
    table = results.tables["table"]
    figure, axes = panels(1, 3, width=3.0)
    for ax, part in zip(axes.flat, DEFAULT, strict=True):
        own = table[table["part"] == part]
        places = np.arange(len(own))
        for nu, style in zip(NUS, ("o-", "s--"), strict=True):
            ax.plot(places, own[f"error_P_{nu:g}"], style, color="C0", label=f"stress, nu {nu:g}")
            errors = own[f"frequency_{nu:g}"].abs()
            ax.plot(places, errors, style, color="C1", label=f"frequency, nu {nu:g}")
        # One word a line, and the order once: long values lie beside each other otherwise.
        labels = [
            f"{sound}/{runs}\n" + ("(default)\n" if default else "") + "\n".join(
                str(value).removeprefix("order 2, ").split(" ")
            )
            for value, sound, runs, default in zip(
                own["value"], own["sound"], own["runs"], own["default"], strict=True
            )
        ]
        ax.set(title=part, yscale="log", xticks=places)
        ax.set_xticklabels(labels, fontsize=5.0)
    axes.flat[0].set_ylabel("relative error")
    # Between the curves of this panel, which are level.
    axes.flat[0].legend(fontsize=5.5, loc="lower center", bbox_to_anchor=(0.5, 0.14))
    return figure


def words(tables: Tables) -> dict[str, Any]:
    """How fine the cube and the block are, and the smoothing length of the default."""
    return {"cube": CUBE, "block": BLOCK, "restrained": H_OVER_DX_RESTRAINED}


STUDY = Study(
    name="restraint",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={"map": map_figure},
    words=words,
    text=Path(__file__).with_suffix(".md"),
    description="The parts of the default, each varied alone.",
)

if __name__ == "__main__":
    run_study(STUDY)
