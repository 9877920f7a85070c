"""Which operator on which cloud?  ``python -m studies.clouds``.

``Literal``, ``Consistent`` and ``SummationByParts`` with SUPG, and the package default, on
lattices, disorder, tetrahedra and mesh files: orders and errors on the swinging cube, momenta and
set-up of free bodies of other shapes, the energy budget without stabilisation, the CFL number that
a free cube allows, and what the choices inside ``SummationByParts`` are worth. With ``--cloud``
(also of ``studies.convergence``) only the swinging cube on the clouds named.
"""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import sphsolid as sph
from sphsolid.defaults import H_OVER_DX_BY_PARTS, default_cfl, default_integrator
from sphsolid.errors import require
from studies.clouds.choice import KINDS, cloud_of, label_of
from studies.clouds.runs import (
    CFL,
    RECOVERED,
    SHAPES,
    STEPS,
    Setting,
    conservation,
    cube,
    energy,
    spectrum,
)
from studies.engine.plotting import Curve, convergence_panel, outside_legend, panels
from studies.engine.study import Case, Claim, Results, Row, Study, Tables, main, parse
from studies.measures.swinging_cube import FAMILIES, INSTANTS, LARGEST_GRADIENT, SCENES
from studies.measures.tables import select
from studies.methods import PACKAGE, PAPER, SUPG, UNSTABILISED, Method

BY_PARTS, NO_FIELDS = sph.SummationByParts(), sph.Displacement()
OPERATORS: dict[str, Method] = {
    "Literal": SUPG.but(operator=sph.Literal(), line=":", marker="v"),
    "Consistent": SUPG.but(operator=sph.Consistent(), line="--", marker="s"),
    "SummationByParts": SUPG.but(operator=BY_PARTS),
}
#: Poisson's ratios at which the package default is run, by the name that the tables have for it.
#: Near incompressibility the wave begins moving: see the report.
MOVING = f"{PACKAGE.name}, nu 0.495, moving start"
DEFAULTS = {PACKAGE.name: 0.3, MOVING: 0.495}
#: All of them, by that name.
METHODS: dict[str, Method] = OPERATORS | {
    name: PACKAGE if nu == 0.3 else PACKAGE.but(name=name, line="--", marker="D")
    for name, nu in DEFAULTS.items()
}
#: Clouds of the comparison and the cells along an edge of their last level.
COMPARED = {
    "lattice": 16, "jitter:0.1": 16, "jitter:0.2": 32, "jitter:0.4": 32, "jitter:0.8": 16,
    "tet": 32, "hex:studies/meshes/cube_hex_8.msh": 16, "tet:studies/meshes/cube_tet_8.msh": 16,
}  # fmt: skip
#: Clouds that only the package default is run on, in the same way.
BY_DEFAULT = {"scattered:0.4": 32}
#: Last level of the other operators, and the clouds of the short form.
OTHERS_LAST, SHORT_FORM = 16, ("lattice", "jitter:0.4", "tet")
#: Clouds whose spectrum is taken.
SPECTRA = ("lattice", "jitter:0.2", "jitter:0.4", "jitter:0.8", "tet")
#: One choice inside ``SummationByParts`` changed at a time.
VARIANTS: dict[str, Mapping[str, Any]] = {
    "start compatible": {"initial_strain": sph.Compatible()},
    "start given": {"initial_strain": sph.Given()},
    **{
        f"tolerance {tolerance:g}": {"operator": sph.SummationByParts(tolerance=tolerance)}
        for tolerance in (1.0e-6, 1.0e-2)
    },
    **{
        f"epsilon {epsilon:g}": {"operator": sph.SummationByParts(epsilon=epsilon)}
        for epsilon in (1.0e3, 1.0, 0.1, 0.02, 0.01)
    },
    **{f"h/dx {ratio:g}": {"h_over_dx": ratio} for ratio in (0.9, 1.0, 1.1, 1.2)},
}
#: Relative cost of a set-up at the same number of particles.
_SET_UP = {"Literal": 0.1, "Consistent": 0.6, "SummationByParts": 6.0}
#: Cells per side of every level, and of the last one where none is named.
LEVELS = (4, 8, 16, 32, 64)
FINEST, FINEST_QUICK = 32, 8

#: Slopes of the worst component of the last refinement asked of ``SummationByParts``: of momentum,
#: of stress, and the goal of stress.
MOMENTUM_SLOPE, STRESS_SLOPE, STRESS_GOAL = 1.9, 1.5, 1.9
#: Errors at 17^3 in the linear limit, and the goal for stress.
MOMENTUM_ERROR, STRESS_ERROR, STRESS_ERROR_GOAL = 7.0e-3, 4.0e-2, 2.0e-2
#: Asked of the package default on any cloud at either Poisson's ratio, linear and at large strain:
#: slopes of momentum and stress and the goal of the latter; errors at 17^3 of jitter 0.4.
DEFAULT_SLOPES, DEFAULT_GOAL = (1.95, 1.85), 1.9
DEFAULT_ERRORS = {0.3: (4.6e-3, 1.3e-2), 0.495: (4.6e-3, 1.7e-2)}
#: Drift of momenta over their scale, and power of ``dt`` of the residual of the energy budget.
DRIFT, ENERGY_SLOPE = 1.0e-12, 1.95
#: Clouds that the slopes and errors are asked of; other clouds are reported.
ASKED = ("jitter 0.2", "jitter 0.4", "tet")
ASKED_OF_DEFAULT = (*ASKED, "scattered 0.4")

SETTING = ["cloud", "operator", "formulation", "scene", "family"]
_ABOUT = [
    "particles", "secondary", "neighbours", "least_neighbours", "h_min_over_dx", "change",
    "iterations", "C0", "C1", "D0", "SBP", "volume", "setup_s",
]  # fmt: skip
#: Kind of row -> its table and columns.
_KINDS: dict[str, tuple[str, list[str]]] = {
    "error": ("table", [*SETTING, "variant", "field", "component", "h", "particles", "steps",
                        "error", "step_ms"]),
    "set-up": ("setup", ["cloud", "operator", "variant", "h", *_ABOUT]),
    "conservation": ("conservation", ["shape", "cloud", "operator", "outcome", "steps",
                                      "linear_drift", "angular_drift", *_ABOUT, "step_ms", "why"]),
    "energy": ("energy", ["cloud", "operator", "integrator", "h", "particles", "steps", "dt",
                          "dt_over_stable", "residual"]),
    "spectrum": ("spectrum", ["cloud", "operator", "h", "particles", "h_min_over_dx",
                              "decades_at_default", "strict", "slow", "fast", "refused"]),
    "unsound": ("unsound", [*SETTING, "variant", "h", "steps", "why"]),
}  # fmt: skip
_LEVEL = [
    *SETTING, "variant", "h", "particles", "p_x", "P_xx", "error_p", "error_P", "slope_p",
    "slope_P", "mean_slope_P",
]  # fmt: skip
_FIELDS = {"error_p": "momentum", "error_P": "stress"}
#: Figures by scene and formulation: ``orders_linear_pF`` and so on.
ORDERS = {
    f"orders_{scene}_{formulation.name.strip('{}').replace(',', '')}": (scene, formulation.name)
    for scene, formulation in product(SCENES, (sph.PF(), sph.PFJ()))
}


def _cube(
    cloud: str, level: int, operator: str, settings: Sequence[Setting], variant: str = ""
) -> Case:
    cells = cloud_of(cloud).cells(level)
    nu = DEFAULTS.get(operator, 0.3)
    # Undeformed p-wave speed over s-wave speed: how many more steps a period takes.
    steps = 1.0 if nu == 0.3 else 5.2
    step = "" if cloud.startswith("points") else f" level {level}"
    return Case(
        f"cube {label_of(cloud)}{step} {operator} {variant}".strip(),
        cube,
        {"cloud": cloud, "level": level, "settings": list(settings), "variant": variant,
         "method": METHODS[operator].but(**VARIANTS.get(variant, {})),
         "label": operator if operator in DEFAULTS else "", "poisson_ratio": nu,
         "moving": operator == MOVING},
        cost=(steps * len(settings) * cells**4 / 16 + _SET_UP.get(operator, 6.0) * cells**3.5)
        / 16**3,
    )  # fmt: skip


def _settings(families: Sequence[str] = FAMILIES[:1], operator: str = "") -> list[Setting]:
    mixed = (sph.PF(), sph.PFJ())
    return list(product(SCENES, families, (NO_FIELDS,) if operator in DEFAULTS else mixed))


def _finest(options: argparse.Namespace) -> int:
    usual = FINEST_QUICK if options.quick else FINEST
    return usual if options.finest is None else int(options.finest)


def named(options: argparse.Namespace) -> Iterator[Case]:
    """All operators on the clouds of the command line, to the same level."""
    families = FAMILIES if options.both_families else FAMILIES[:1]
    for cloud in options.cloud:
        for level in cloud_of(cloud).levels(_finest(options)):
            for operator in (*OPERATORS, PACKAGE.name):
                yield _cube(cloud, level, operator, _settings(families, operator))


def _comparison(options: argparse.Namespace) -> Iterator[Case]:
    for cloud, last in COMPARED.items():
        if options.quick and cloud not in SHORT_FORM:
            continue
        chosen = cloud_of(cloud)
        for operator in OPERATORS:
            finest = last if operator == BY_PARTS.name else min(last, OTHERS_LAST)
            for level in chosen.levels(min(finest, _finest(options))):
                # In the linear limit the formulations agree to three digits.
                fine = chosen.cells(level) > 24
                settings = [
                    setting for setting in _settings()
                    if not (fine and setting[0] == "linear" and setting[2] == sph.PFJ())
                ]  # fmt: skip
                yield _cube(cloud, level, operator, settings)
    for cloud, last in (COMPARED | BY_DEFAULT).items():
        if options.quick and cloud not in SHORT_FORM:
            continue
        for operator in DEFAULTS:
            for level in cloud_of(cloud).levels(min(last, _finest(options))):
                yield _cube(cloud, level, operator, _settings(operator=operator))


def _variants(quick: bool) -> Iterator[Case]:
    """One choice inside ``SummationByParts`` changed at a time, on ``jitter:0.4``."""
    settings = _settings()[:1]
    for variant in list(VARIANTS)[: 2 if quick else None]:
        for level in (4, 8) if quick else (8, 16):
            yield _cube("jitter:0.4", level, BY_PARTS.name, settings, variant)
    if not quick:
        # Whether a wider support lifts the order of the stress shows at the last level only.
        yield _cube("jitter:0.4", 32, BY_PARTS.name, settings, "h/dx 1.1")


def _others(quick: bool) -> Iterator[Case]:
    """Free bodies, energy budgets, spectra."""
    by_operator = {name: method.but(formulation=sph.PF()) for name, method in OPERATORS.items()}
    for shape, clouds in SHAPES.items():
        for cloud, (operator, method) in product(clouds, by_operator.items()):
            if quick and (shape != "cube" or operator == "Consistent"):
                continue
            arguments: Row = {"cloud": cloud, "method": method, "operator": operator}
            yield Case(
                f"free {shape} {cloud} {operator}", conservation, arguments | {"shape": shape},
                cost=0.5 * (1.0 + _SET_UP[operator]),
            )  # fmt: skip
    for cloud, integrator in product(("jitter:0.4", "tet"), (sph.TVDRK2(), sph.PositionVerlet())):
        yield energy_case(cloud, integrator, 4 if quick else 8)
    for cloud in SPECTRA[:2] if quick else SPECTRA:
        for operator, method in by_operator.items():
            arguments = {"cloud": cloud, "method": method, "operator": operator}
            yield Case(
                f"spectrum {label_of(cloud)} {operator}", spectrum,
                arguments | {"level": 2 if quick else 4}, cost=3.0,
            )  # fmt: skip


def energy_case(cloud: str, integrator: Any, level: int) -> Case:
    """The budget without stabilisation and projection."""
    method = UNSTABILISED.but(
        formulation=sph.PF(), operator=BY_PARTS, angular_momentum=sph.NoProjection(),
        integrator=integrator,
    )  # fmt: skip
    arguments = {"cloud": cloud, "level": level, "method": method}
    return Case(f"energy budget {cloud} {integrator.name}", energy, arguments, cost=2.0)


def cases(options: argparse.Namespace) -> list[Case]:
    """The whole comparison, or the cube on the clouds that ``--cloud`` names."""
    require(
        _finest(options) in LEVELS,
        f"--finest {options.finest}: choose one of {', '.join(map(str, LEVELS))}",
    )
    require(
        bool(options.cloud) or not options.both_families,
        "--both-families is for the clouds that --cloud names: name one, or leave it out",
    )
    labels = [label_of(cloud) for cloud in options.cloud]
    require(len(set(labels)) == len(labels), f"--cloud: {labels} are not all different")
    if options.cloud:
        return list(named(options))
    return [*_comparison(options), *_variants(options.quick), *_others(options.quick)]


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel."""
    return [
        *(
            _cube("jitter:0.4", 4, operator, _settings(operator=operator))
            for operator in (*OPERATORS, PACKAGE.name)
        ),
        *(energy_case("jitter:0.4", each, 4) for each in (sph.TVDRK2(), sph.PositionVerlet())),
    ]


def tables(rows: list[Row]) -> Tables:
    """``table``: an error a row; ``levels``: errors and slopes; and the other kinds of rows."""
    made = {
        name: pd.DataFrame([row for row in rows if row["kind"] == kind], columns=columns)
        for kind, (name, columns) in _KINDS.items()
    }
    return made | {"levels": levels(made["table"]), "energy": with_slopes(made["energy"])}


def unvaried(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows without a ``variant``: an empty text is read back from CSV as nothing."""
    return frame[frame["variant"].isna() | (frame["variant"] == "")]


def levels(errors: pd.DataFrame) -> pd.DataFrame:
    """One row a level of every setting: largest errors, slopes from the level before.

    ``slope_p`` and ``slope_P``: that of the worst component; ``mean_slope_P`` that of the root
    mean square of all stress components.  ``nan`` on the first level.
    """
    rows = []
    settings = [*SETTING, "variant"]
    for key, group in errors.groupby(settings, sort=False, dropna=False):
        by_level = {
            float(h): part.set_index(part["field"] + "_" + part["component"])["error"]
            for h, part in group.groupby("h")
        }
        sizes = group.groupby("h")["particles"].first()
        spacings = sorted(by_level, reverse=True)
        slopes = {spacings[0]: (math.nan, math.nan, math.nan)}
        for coarse, fine in pairwise(spacings):
            slopes[fine] = _slopes(by_level[coarse], by_level[fine], coarse / fine)
        for h in spacings:
            error = by_level[h]
            momentum = error.index.str.startswith("p_")
            values = (h, int(sizes[h]), error["p_x"], error["P_xx"], error[momentum].max(),
                      error[~momentum].max(), *slopes[h])  # fmt: skip
            rows.append((*key, *values))
    return pd.DataFrame(rows, columns=_LEVEL)


def _slopes(coarse: pd.Series, fine: pd.Series, ratio: float) -> tuple[float, float, float]:
    """Worst of momentum, worst of stress, and of the mean stress."""
    by_component = np.log(coarse / fine) / math.log(ratio)
    momentum = by_component.index.str.startswith("p_")
    mean = [math.sqrt(float((part[~momentum] ** 2).mean())) for part in (coarse, fine)]
    return (
        float(by_component[momentum].min()),
        float(by_component[~momentum].min()),
        math.log(mean[0] / mean[1]) / math.log(ratio),
    )


def with_slopes(budget: pd.DataFrame) -> pd.DataFrame:
    """The budget with the power of ``dt`` at which the residual fell from the row before."""
    fell, shorter = (
        np.log(budget[name]).groupby([budget["cloud"], budget["integrator"]], sort=False).diff()
        for name in ("residual", "dt")
    )
    return budget.assign(slope=fell / shorter)


def claims(tables: Tables) -> list[Claim]:
    """What was asked of the operators; of clouds that nothing was asked of the numbers alone."""
    plain = unvaried(tables["levels"])
    fits = select(tables["levels"], variant=RECOVERED)
    found = []
    for where, last in _last(plain):
        found += [
            _claim("momentum slope, manufactured", where, last, "slope_p", MOMENTUM_SLOPE),
            _claim("stress slope, manufactured", where, last, "slope_P", STRESS_SLOPE, STRESS_GOAL),
        ]
    for where, last in _last(fits):
        what = "recovered stress slope, manufactured"
        found.append(_claim(what, where, last, "slope_P", STRESS_GOAL))
    linear = at_17(select(plain, operator=BY_PARTS.name, scene="linear", family=FAMILIES[0]))
    for row in linear.to_dict("records"):
        where = f"{row['cloud']}, {row['formulation']}, {row['particles']:.0f} particles"
        found += [
            _claim("p_x, linear limit", where, row, "p_x", MOMENTUM_ERROR),
            _claim("P_xx, linear limit", where, row, "P_xx", STRESS_ERROR, STRESS_ERROR_GOAL),
        ]
    others = [*_energy(tables["energy"]), *_kept(tables["conservation"])]
    return [*found, *_of_the_default(plain), *_lattice(plain), *others]


def _of_the_default(plain: pd.DataFrame) -> Iterator[Claim]:
    """Slopes of the last refinement over both scenes, and the largest errors at 17^3."""
    for name, nu in DEFAULTS.items():
        runs = select(plain, operator=name)
        for cloud in ASKED_OF_DEFAULT:
            last = [
                part.loc[part["h"].idxmin()]
                for _, part in select(runs, cloud=cloud).groupby("scene", sort=False)
            ]
            for field, asked, goal in (("p", DEFAULT_SLOPES[0], math.nan),
                                       ("P", DEFAULT_SLOPES[1], DEFAULT_GOAL)):  # fmt: skip
                slopes = {row["scene"]: float(row[f"slope_{field}"]) for row in last}
                if not slopes or all(map(math.isnan, slopes.values())):
                    continue
                what = f"{_FIELDS[f'error_{field}']} slope of the {_said(name, nu)}"
                if math.isnan(goal):
                    yield Claim(what, slopes, ">=", asked, where=cloud, format=".2f")
                    continue
                yield Claim(
                    what, slopes, ">=", goal, where=cloud, in_part=asked, format=".2f",
                    wanted=f"{asked:.2f}, goal {goal:.2f}",
                )  # fmt: skip
        at = at_17(select(runs, cloud="jitter 0.4", scene="linear", family=FAMILIES[0]))
        for row in at.to_dict("records"):
            for (column, word), asked in zip(_FIELDS.items(), DEFAULT_ERRORS[nu], strict=True):
                yield Claim(
                    f"largest error of {word} of the {_said(name, nu)}, linear limit",
                    float(row[column]), "<=", asked, format=".2e",
                    where=f"jitter 0.4, {row['particles']:.0f} particles",
                )  # fmt: skip


def _said(name: str, nu: float) -> str:
    return name if name == MOVING else f"{name}, nu {nu:g}"


def _last(runs: pd.DataFrame) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Where, and the row of the finest level, of ``SummationByParts`` at large strain."""
    wanted = select(runs, operator=BY_PARTS.name, scene="manufactured")
    for (cloud, formulation), part in wanted.groupby(["cloud", "formulation"], sort=False):
        last = part[part["h"] == part["h"].min()].iloc[0].to_dict()
        if not pd.isna(last["slope_P"]):
            yield f"{cloud}, {formulation}, to {last['particles']:.0f} particles", last


def _claim(
    what: str, where: str, row: Mapping[str, Any], column: str, asked: float, goal: float = math.nan
) -> Claim:
    """A slope that is at least, or an error that is at most, what was asked; the goal beyond it.

    What is asked but not the goal is met in part.
    """
    form = ".2f" if column.startswith("slope") else ".2e"
    value = float(row[column])
    if row["cloud"] not in ASKED:
        return Claim(what, value, where=where, format=form)
    comparison: Any = ">=" if column.startswith("slope") else "<="
    if math.isnan(goal):
        return Claim(what, value, comparison, asked, where=where, format=form)
    wanted = f"{asked:{form}}, goal {goal:{form}}"
    return Claim(
        what, value, comparison, goal, where=where, in_part=asked, wanted=wanted, format=form
    )


def at_17(runs: pd.DataFrame) -> pd.DataFrame:
    """Rows of the level nearest to ``h = 1/16``, of the clouds that come within a fifth of it."""
    return runs[(runs["h"] * 16.0).between(1.0 / 1.2, 1.2)]


def _lattice(plain: pd.DataFrame) -> Iterator[Claim]:
    part = at_17(select(plain, cloud="lattice", scene="linear", formulation=sph.PF().name))
    errors = part.set_index("operator")
    if {"Consistent", BY_PARTS.name} <= set(errors.index):
        for name in ("p_x", "P_xx"):
            ratio = errors.loc[BY_PARTS.name, name] / errors.loc["Consistent", name]
            what = f"{name}, SummationByParts over Consistent"
            yield Claim(what, float(ratio), where="lattice, {p,F}, 17^3", format=".2f")


def _energy(budget: pd.DataFrame) -> Iterator[Claim]:
    for (cloud, integrator), runs in budget.groupby(["cloud", "integrator"], sort=False):
        yield Claim(
            "energy budget, power of dt", float(runs["slope"].min()), ">=", ENERGY_SLOPE,
            where=f"{cloud}, {integrator}, no stabilisation", format=".2f",
        )  # fmt: skip


def _kept(frame: pd.DataFrame) -> Iterator[Claim]:
    for operator, runs in frame.groupby("operator", sort=False):
        kept = select(runs, outcome="kept")
        for kind in ("linear", "angular") if len(kept) else ():
            worst = kept.loc[kept[f"{kind}_drift"].idxmax()]
            yield Claim(
                f"{kind} momentum, {operator}", float(worst[f"{kind}_drift"]), "<=", DRIFT,
                where=f"worst of {len(kept)} bodies: {worst['shape']}, {worst['cloud']}",
            )  # fmt: skip
        for row in runs[runs["outcome"] != "kept"].itertuples():
            what = f"a body {row.outcome if row.outcome != 'refused' else 'is refused'}, {operator}"
            yield Claim(what, math.nan, "<=", DRIFT, where=f"{row.shape}, {row.cloud}")


def _look(operator: str) -> dict[str, Any]:
    white = {"markerfacecolor": "white"} if operator == "Literal" else {}
    return METHODS[operator].look | white


def orders_figure(results: Results, *, scene: str, formulation: str) -> Figure:
    """Largest component error over spacing by operator: a pair of panels a cloud.

    The package default has no fields to choose and is in every figure.
    """
    shown = select(unvaried(results.tables["levels"]), scene=scene, family=FAMILIES[0])
    shown = shown[shown["formulation"].isin([formulation, NO_FIELDS.name])]
    clouds = list(dict.fromkeys(shown["cloud"]))
    require(len(clouds) > 0, f"levels.csv has no {scene} runs of {formulation}; run the study")
    across = min(4, len(clouds))
    blocks = -(-len(clouds) // across)
    figure, axes = panels(2 * blocks, across, width=2.9, height=2.7)
    for place in range(blocks * across):
        block, column = divmod(place, across)
        for row, (name, field) in enumerate(_FIELDS.items()):
            ax = axes[2 * block + row, column]
            if place >= len(clouds):
                ax.set_axis_off()
                continue
            convergence_panel(
                ax,
                [
                    Curve(str(operator), part["h"].tolist(), part[name].tolist(), _look(operator))
                    for operator, part in select(shown, cloud=clouds[place]).groupby(
                        "operator", sort=False
                    )
                ],
                title=f"{clouds[place]}: {field}",
                y_label="relative L2 error [-]" if column == 0 else "",
                x_label="spacing h [m]" if row == 1 else "",
            )
    outside_legend(figure, axes.flat, columns=3)
    return figure


def disorder_figure(results: Results) -> Figure:
    """Error on 17^3 particles over the jitter, linear limit, {p,F} and the package default."""
    part = select(
        unvaried(results.tables["levels"]), scene="linear", family=FAMILIES[0], h=1.0 / 16.0
    )
    part = part[part["formulation"].isin([sph.PF().name, NO_FIELDS.name])]
    part = part[part["cloud"].str.startswith(("lattice", "jitter"))]
    jitter = part["cloud"].str.removeprefix("jitter ").replace("lattice", "0").astype(float)
    part = part.assign(moved=100.0 * jitter / 2.0).sort_values("moved")
    figure, axes = panels(1, 2, width=3.4, height=2.9)
    for ax, (name, field) in zip(axes.flat, _FIELDS.items(), strict=True):
        for operator in METHODS:
            runs = select(part, operator=operator)
            ax.plot(runs["moved"], runs[name], label=operator, **_look(operator))
        ax.set_yscale("log")
        ax.set(
            title=f"17^3, linear limit: {field}",
            xlabel="particles moved by up to [% of spacing]",
            ylabel="relative L2 error [-]",
        )
    outside_legend(figure, axes.flat, columns=3)
    return figure


def energy_figure(results: Results) -> Figure:
    """The residual of the energy budget over the step."""
    budget = results.tables["energy"]
    figure, axes = panels(1, 1, width=3.8, height=3.0)
    ax = axes[0, 0]
    colours = {"TVD-RK2": PAPER.colour, default_integrator().name: SUPG.colour}
    for (cloud, integrator), runs in budget.groupby(["cloud", "integrator"], sort=False):
        disorder = str(cloud).startswith("jitter")
        ax.plot(
            1.0e6 * runs["dt"], runs["residual"], label=f"{integrator}, {cloud}",
            color=colours[str(integrator)], marker="o" if disorder else "^",
            linestyle="-" if disorder else "--",
        )  # fmt: skip
    ends = budget["dt"].min(), budget["dt"].max()
    level = 0.5 * float(budget["residual"].min()) / ends[0] ** 2
    ax.plot([1.0e6 * dt for dt in ends], [level * dt**2 for dt in ends], color="0.55",
            linestyle=":", linewidth=0.8, label="dt²")  # fmt: skip
    ax.set_xscale("log")
    ax.set_yscale("log")
    ticks = sorted({round(1.0e6 * dt, 3) for dt in budget["dt"]})
    ax.set_xticks(ticks, [f"{tick:.0f}" for tick in ticks], minor=False)
    ax.minorticks_off()
    ax.set(xlabel="time step [µs]", ylabel="largest residual / energy [-]",
           title="energy budget, no stabilisation")  # fmt: skip
    outside_legend(figure, axes.flat, columns=2)
    return figure


def words(tables: Tables) -> Mapping[str, Any]:
    """Tables as the report shows them, and settings."""
    plain, fits = unvaried(tables["levels"]), select(tables["levels"], variant=RECOVERED)
    keys = [*SETTING, "h"]
    stress = ["P_xx", "error_P", "slope_P"]
    both = fits[[*keys, *stress]].merge(
        plain[[*keys, *stress]], on=keys, suffixes=("_recovered", "")
    )
    varied = tables["levels"].drop(plain.index).drop(fits.index)
    effort = tables["setup"][["variant", "h", "neighbours", "change", "iterations", "setup_s"]]
    return {
        "orders": [(name, *ORDERS[name]) for name in ORDERS],
        "shown": set(zip(plain["scene"], plain["formulation"], strict=True)),
        "has_disorder": bool(select(plain, cloud="lattice", h=1.0 / 16.0).shape[0]),
        "settings": [
            (*key, runs) for key, runs in plain.groupby(["scene", "family"], sort=False)
        ],
        "recovered": both[
            both["formulation"].isin([sph.PF().name, NO_FIELDS.name])
            & (both["operator"] != "Literal")
        ],
        "varied": varied.assign(
            made=varied["variant"].str.removesuffix(f", {RECOVERED}")
        ).merge(effort.rename(columns={"variant": "made"}), on=["made", "h"], how="left"),
        "setup": unvaried(tables["setup"]),
        "default": PACKAGE.name, "other_nu": max(DEFAULTS.values()),
        "instants": INSTANTS, "gradient": LARGEST_GRADIENT, "steps": STEPS, "drift": DRIFT,
        "epsilon": BY_PARTS.epsilon, "tolerance": BY_PARTS.tolerance,
        "support": H_OVER_DX_BY_PARTS, "integrator": default_integrator().name,
        "cfl": default_cfl(default_integrator()), "largest_cfl": CFL[-1],
    }  # fmt: skip


def summary(tables: Tables) -> str:
    """Errors and slopes of every level, without the variants."""
    frame = unvaried(tables["levels"]).drop(columns=["variant", "mean_slope_P"])
    return frame.to_string(index=False, float_format=lambda value: f"{value:.3g}")


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--cloud``, ``--finest``, ``--both-families``."""
    parser.add_argument(
        "--cloud", action="append", default=[], metavar="CLOUD",
        help=f"only the swinging cube on this cloud: {KINDS}; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--finest", type=int, help="cells per side of the last level "
        f"(default {FINEST}, {FINEST_QUICK} with --quick)",
    )  # fmt: skip
    parser.add_argument(
        "--both-families", action="store_true", help="with --cloud: A=B=C beside A+B+C=0"
    )


STUDY = Study(
    name="clouds",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={
        "disorder": disorder_figure,
        "energy": energy_figure,
        **{
            name: partial(orders_figure, scene=scene, formulation=formulation)
            for name, (scene, formulation) in ORDERS.items()
        },
    },
    shown=("orders_manufactured_pF",),
    words=words,
    text=Path(__file__).with_name("clouds.md"),
    summary=summary,
    arguments=arguments,
    warm_up=warm_up,
    description="Operators on lattices, disorder, tetrahedra, mesh files and points.",
)


def run(given: Sequence[str]) -> int:
    """From the command line; results of named clouds go to a folder of their own."""
    options, argv = parse(STUDY, given), list(given)
    if options.cloud and not any(word.split("=")[0] == "--out" for word in given):
        labels = (label_of(cloud) for cloud in options.cloud)
        names = (re.sub(r"[^A-Za-z0-9.]+", "-", label).strip("-") for label in labels)
        argv += ["--out", f"{'out' if options.quick else 'reports'}/clouds-{'+'.join(names)}"]
    return main(STUDY, argv)
