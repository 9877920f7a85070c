"""Does the method converge, and at which order?  ``python -m studies.convergence``.

The swinging cube by the package default, by self-adjoint SUPG, by the paper's scheme with every
formulation, choice of secondary points and operator, by displacement SPH and by B-bar elements: in
the linear limit and at large strain, both families of exact solutions, and near incompressibility.
With ``--cloud`` it hands over to ``studies.clouds``.
"""

from __future__ import annotations

import argparse
import importlib
import itertools
import math
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

import sphsolid as sph
from sphsolid.defaults import (
    H_OVER_DX_LATTICE,
    default_cfl,
    default_integrator,
    default_operator,
)
from sphsolid.errors import require
from sphsolid.scenes import Box
from studies.engine.plotting import Curve, convergence_panel, outside_legend, panels
from studies.engine.study import Case, Claim, Results, Row, Study, Tables, run_study
from studies.measures import folding
from studies.measures.order import order_table
from studies.measures.swinging_cube import (
    FAMILIES,
    INSTANTS,
    LARGEST_GRADIENT,
    LINEAR_AMPLITUDE,
    MOVING,
    SCENES,
    cube_scene,
    period_errors_of,
)
from studies.measures.tables import select
from studies.methods import B_BAR, DISPLACEMENT, METHODS, PACKAGE, SUPG, Method
from studies.methods import PAPER as REGISTERED

NU, NEARLY_INCOMPRESSIBLE = 0.3, 0.499
#: Beside it the package default and the elements: where most rubber is, and nearer still.
RUBBER, NEARER = 0.495, 0.4999
#: The paper's factor of the time-integrated residual with H1 (its Fig. 4).  The study's own runs
#: use none: it costs the stress near boundaries its order, which these rows show.
PAPER_XI_F = 0.1
#: The paper's ``tau_p`` over the step, used near incompressibility.
PAPER_TAU_P = 0.1
CFL = 0.3

PAPER = REGISTERED.but(
    name="paper", label="paper", formulation=sph.PF(), operator=sph.Consistent()
)
LITERAL = PAPER.but(
    label="paper, operator as printed", line=":", marker="v", operator=sph.Literal()
)
FORCE_ONLY = PAPER.but(
    label="paper, consistent in the force only", line="--", marker="^",
    operator=sph.Consistent(use="force"),
)  # fmt: skip
#: Displacement SPH with the paper's integrator and CFL number.
CLASSICAL = DISPLACEMENT.but(
    name="displacement SPH, TVD-RK2", integrator=sph.TVDRK2(), cfl=CFL, operator=sph.Consistent(),
    angular_momentum=sph.NoProjection(),
)  # fmt: skip
CLASSICAL_LITERAL = CLASSICAL.but(
    label="displacement SPH, TVD-RK2, operator as printed", line=":", operator=sph.Literal()
)
#: What is compared first, in the report and in README.md.
HEADLINE = (PACKAGE, SUPG, PAPER, LITERAL, FORCE_ONLY, CLASSICAL, CLASSICAL_LITERAL, B_BAR)

_LOOKS: dict[str, dict[str, str]] = {"{p,F,J}": {"marker": "^"}, "{p,F,H,J}": {"marker": "o"}}


MIXED = (sph.PF(), sph.PFJ(), sph.PFHJ())


def mixed(base: Method, formulations: Sequence[Any] = MIXED) -> list[Method]:
    """The same with every formulation and choice of secondary points."""
    made = []
    for formulation, secondary in itertools.product(formulations, (sph.H1(), sph.H6())):
        changes: dict[str, Any] = {} if formulation == sph.PF() else {"formulation": formulation}
        look = _LOOKS.get(formulation.name, {})
        if secondary == sph.H6():
            changes["secondary"], look = secondary, look | {"line": "--"}
        made.append(base.but(**look, **changes) if changes else base)
    return made


BY_OPERATOR = {base.name: mixed(base) for base in (LITERAL, PAPER, FORCE_ONLY)}
NEAR = mixed(PAPER.but(tau_p=sph.OfStep(PAPER_TAU_P)), (sph.PFJ(), sph.PFHJ()))
WITH_XI_F = [base.but(xi_F=PAPER_XI_F) for base in (LITERAL, PAPER, FORCE_ONLY)]
UNPROJECTED = [method.but(angular_momentum=sph.NoProjection()) for method in WITH_XI_F[1:]]
#: What is alike in formulation and secondary points: {p,F} and H1.
ALONE = {
    PACKAGE.name: [PACKAGE],
    SUPG.name: [SUPG],
    PAPER.name: [PAPER, WITH_XI_F[1], UNPROJECTED[0]],
    FORCE_ONLY.name: [FORCE_ONLY, WITH_XI_F[2], UNPROJECTED[1]],
}
LINEAR_KERNEL = PAPER.but(operator=sph.Literal(gradient="linear_kernel"))

#: The package default with lattice differences of every order, whichever of them it chooses.
BY_ORDER = {
    order: PACKAGE.but(
        name=f"{PACKAGE.name}, order {order}", operator=sph.LatticeDifference(order=order)
    )
    for order in (2, 4, 6)
}
#: Every other registered method, to 17^3: a new one needs no line here.
OTHERS = tuple(each for each in METHODS.values() if each not in (*HEADLINE, REGISTERED))
FINEST_OTHERS = 16
#: Orders beyond that of position Verlet need another integrator.
WITH_RKN4 = {order: BY_ORDER[order].but(integrator=sph.SymplecticRKN4()) for order in (4, 6)}

SETTING = ["scene", "nu", "family", "method"]
FAMILY = [*SETTING, "field", "component"]
COLUMNS = [*FAMILY, "h", "particles", "steps", "error", "wall_s", *folding.COLUMNS]
_FIELD = {"p": "momentum", "P": "stress"}
SUMMARY = [*SETTING, "h_finest"]
SUMMARY += [
    name.format(field) for field in _FIELD
    for name in ("slope_{}_last", "slope_{}_fitted", "error_{}_h16", "error_{}_finest")
]  # fmt: skip
SUMMARY += ["wall_s_finest", "folded"]
#: Cells per side of every level, and of the last one where none is named.
LEVELS = (4, 8, 16, 32, 64)
FINEST, FINEST_QUICK = 32, 16
#: Asked at nu = 0.3: slopes of momentum and stress, errors of p_x and P_xx at 17^3 in the linear
#: limit, A+B+C=0.
ASKED = {
    PACKAGE.name: (1.95, 1.90, 2.6e-3, 1.0e-2),
    SUPG.name: (1.95, 1.65, 2.6e-3, 1.0e-2),
    PAPER.name: (1.95, 1.65, 2.6e-3, 1.0e-2),
    FORCE_ONLY.name: (1.95, 1.90, 2.6e-3, 5.5e-3),
}
_SECOND_ORDER = {NU: (4.5e-3, 1.1e-2), RUBBER: (4.5e-3, 1.3e-2)}
#: Asked of the lattice differences where the wave begins moving, A+B+C=0: slopes of momentum and
#: stress, and by Poisson's ratio their largest component errors at 17^3.  Order six is asked for
#: nothing with position Verlet.
ASKED_OF_ORDER: dict[str, tuple[tuple[float, float], dict[float, tuple[float, float]]]] = {
    PACKAGE.name: ((1.95, 1.9), _SECOND_ORDER),
    BY_ORDER[2].name: ((1.95, 1.9), _SECOND_ORDER),
    BY_ORDER[4].name: ((2.5, 2.5), {NU: (3.0e-4, 1.0e-3), RUBBER: (2.0e-4, 1.0e-3)}),
    WITH_RKN4[4].name: ((2.9, 2.9), {}),
    WITH_RKN4[6].name: ((4.0, 4.0), {}),
}
#: Asked of every slope of the elements and at nu = 0.499, and of p_x there.
SLOPE, ERROR_NEAR = 1.95, 3.2e-3


def run_cube(
    *, method: Method, scene: str, family: str, poisson_ratio: float, cells: int
) -> list[Row]:
    """Twelve rows, one per component of momentum and stress."""
    started = time.perf_counter()
    sim = method.simulation(
        cube_scene(scene, family, poisson_ratio=poisson_ratio), spacing=1.0 / cells
    )
    errors = period_errors_of(sim)
    common = {
        "scene": scene, "nu": poisson_ratio, "family": family, "method": method.name,
        "h": 1.0 / cells, "particles": (cells + 1) ** 3, "steps": sim.step,
        "wall_s": time.perf_counter() - started, **folding.folding(sim),
    }  # fmt: skip
    return [
        common | {"field": name.split("_")[0], "component": name.split("_")[1], "error": error}
        for name, error in errors.items()
    ]


def _case(method: Method, cells: int, scene: str, family: str, nu: float = NU) -> Case:
    # Undeformed p-wave speed over s-wave speed: how many more steps a period takes.
    stiffer = {NU: 1.0, RUBBER: 5.2, NEARLY_INCOMPRESSIBLE: 11.5, NEARER: 36.0}
    cost = cells**4 * stiffer[nu] * (0.55 if family == "A=B=C" else 1.0)
    cost *= 1.6 if scene.startswith("manufactured") else 1.0
    usual = dict.fromkeys((PACKAGE.name, *(each.name for each in BY_ORDER.values())), 0.2) | {
        **dict.fromkeys((each.name for each in WITH_RKN4.values()), 0.4),
        SUPG.name: 0.3, CLASSICAL.name: 0.6, CLASSICAL_LITERAL.name: 0.6,
        B_BAR.name: 0.6,
    }  # fmt: skip
    cost *= 2.3 if "H6" in method.name else usual.get(method.name, 1.0)
    arguments = {
        "method": method, "scene": scene, "family": family, "poisson_ratio": nu, "cells": cells,
    }  # fmt: skip
    return Case(f"{scene} nu {nu:g} {family} {method.name} 1/{cells}", run_cube, arguments, cost)


def of_level(cells: int, quick: bool) -> Iterator[Case]:
    """All runs at ``h = 1/cells``, nu = 0.3; the short form keeps a cross of the full table."""
    for scene, family in itertools.product(SCENES, FAMILIES):
        methods = list(HEADLINE)
        if not quick:
            methods += [*itertools.chain(*BY_OPERATOR.values()), *WITH_XI_F]
        elif scene == "linear":
            methods += BY_OPERATOR[PAPER.name]
        for method in dict.fromkeys(methods):
            yield _case(method, cells, scene, family)
    for method in (*UNPROJECTED, LINEAR_KERNEL):
        yield _case(method, cells, "linear", "A+B+C=0")


def nearly_incompressible(cells: int, near: Sequence[Method]) -> Iterator[Case]:
    """The linear limit at nu = 0.499, where displacement methods lock or ring."""
    for method in (PACKAGE, SUPG, *near, CLASSICAL, B_BAR):
        yield _case(method, cells, "linear", "A+B+C=0", NEARLY_INCOMPRESSIBLE)


def of_rubber(cells: int) -> Iterator[Case]:
    """At nu = 0.495 and both scenes, at 0.4999 to 17^3; the orders with a moving start."""
    for method, scene in itertools.product((PACKAGE, SUPG, B_BAR), SCENES):
        yield _case(method, cells, scene, "A+B+C=0", RUBBER)
    differences = (PACKAGE, *BY_ORDER.values(), *WITH_RKN4.values(), B_BAR)
    for method, scene, nu in itertools.product(differences, MOVING, (NU, RUBBER)):
        yield _case(method, cells, scene, "A+B+C=0", nu)
    for method in (PACKAGE, SUPG, B_BAR):
        if cells <= 16:
            yield _case(method, cells, "linear", "A+B+C=0", NEARER)


def of_others(cells: int) -> Iterator[Case]:
    """Every other registered method, in the linear limit and at large strain, A+B+C=0."""
    if cells <= FINEST_OTHERS:
        for scene, method in itertools.product(SCENES, OTHERS):
            yield _case(method, cells, scene, "A+B+C=0")


def cases(options: argparse.Namespace) -> list[Case]:
    """Every run of the study, coarse levels first."""
    usual = FINEST_QUICK if options.quick else FINEST
    finest = usual if options.finest is None else options.finest
    require(finest in LEVELS, f"--finest {finest}: choose one of {list(LEVELS)}")
    with_H1 = [method for method in NEAR if "H6" not in method.name]
    listed: list[Case] = []
    for cells in (level for level in LEVELS if level <= finest):
        listed += of_level(cells, options.quick)
        if cells <= (8 if options.quick else 16):
            listed += nearly_incompressible(cells, with_H1 if options.quick else NEAR)
        elif not options.quick:
            listed += nearly_incompressible(cells, with_H1)
        if not options.quick:
            listed += [*of_rubber(cells), *of_others(cells)]
    return listed


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel of the study."""
    methods = (PACKAGE, SUPG, NEAR[-1], B_BAR)
    return [_case(method, 2, "manufactured", "A=B=C", NEARLY_INCOMPRESSIBLE) for method in methods]


def tables(rows: list[Row]) -> Tables:
    """``table``: one row per run and component; ``orders``: one per refinement and component."""
    table = pd.DataFrame(rows, columns=COLUMNS)
    orders = order_table(table, by=FAMILY)
    return {"table": table, "orders": orders, "summary": summarise(table, orders)}


def summarise(table: pd.DataFrame, orders: pd.DataFrame) -> pd.DataFrame:
    """One row per method and scene: worst slope and worst error over the components."""
    rows = []
    for key, group in orders.groupby(SETTING, sort=False) if len(table) else ():
        row: Row = dict(zip(SETTING, key, strict=True))
        runs = table[(table[SETTING] == pd.Series(row)).all(axis=1)]
        row["h_finest"] = runs["h"].min()
        for field in _FIELD:
            part = group[group["field"] == field]
            row[f"slope_{field}_last"] = part["order_last"].min()
            row[f"slope_{field}_fitted"] = part["order_fitted"].min()
            errors = runs[runs["field"] == field].groupby("h")["error"].max()
            row[f"error_{field}_h16"] = errors.get(1.0 / 16.0)
            row[f"error_{field}_finest"] = errors.iloc[0]
        row["wall_s_finest"] = runs[runs["h"] == row["h_finest"]]["wall_s"].max()
        row["folded"] = bool(folding.has_folded(runs).any())
        rows.append(row)
    return pd.DataFrame(rows, columns=SUMMARY)


def headline(summary: pd.DataFrame) -> pd.DataFrame:
    """One row per method of :data:`HEADLINE` at nu = 0.3.

    ``slope_p, slope_P`` are the worst over both scenes and families, ``p_linear`` to
    ``P_manufactured`` the largest component errors at the finest spacing, A+B+C=0.
    """
    rows = []
    summary = _displaced(summary)
    for method in HEADLINE:
        runs = select(summary, nu=NU, method=method.name)
        if len(runs) == 0:
            # Registered after this report was made.
            continue
        row = {"method": method.label}
        row |= {f"slope_{field}": runs[f"slope_{field}_last"].min() for field in _FIELD}
        error = select(runs, family="A+B+C=0").set_index("scene")
        for scene, field in itertools.product(SCENES, _FIELD):
            row[f"{field}_{scene}"] = error[f"error_{field}_finest"].get(scene, math.nan)
        rows.append(row)
    return pd.DataFrame(rows)


def claims(tables: Tables) -> list[Claim]:
    """What was asked of slopes and errors; the worst run of each kind decides."""
    displaced = _displaced(tables["summary"])
    summary = {nu: select(displaced, nu=nu) for nu in (NU, NEARLY_INCOMPRESSIBLE)}
    at_17 = select(tables["table"], scene="linear", family="A+B+C=0", h=1.0 / 16.0)
    slopes, errors = [], []
    for name, (p, P, p_x, P_xx) in ASKED.items():
        own = {PACKAGE.name: [PACKAGE], SUPG.name: [SUPG]}
        runs = _of(summary[NU], own.get(name) or BY_OPERATOR[name])
        slopes += [_slope(runs, name, "p", p), _slope(runs, name, "P", P)]
        for component, limit in (("x", p_x), ("xx", P_xx)):
            runs = select(_of(at_17, ALONE[name]), nu=NU, component=component)
            errors += [_error(row, limit) for row in runs.to_dict("records")]
    best = _of(summary[NU], BY_OPERATOR[LITERAL.name])["slope_P_last"].max()
    slopes.append(Claim(f"best stress slope, {LITERAL.name}", float(best), format=".2f"))
    for nu, runs in summary.items():
        elements = select(runs, method=B_BAR.name)
        slopes += [_slope(elements, f"{B_BAR.name}, nu {nu:g}", field, SLOPE) for field in _FIELD]
    near = select(at_17, nu=NEARLY_INCOMPRESSIBLE, component="x")
    errors += [_error(row, ERROR_NEAR) for row in _of(near, [PACKAGE]).to_dict("records")]
    for name, methods in ((SUPG.name, [SUPG]), (PAPER.name, NEAR)):
        errors += [_error(row, ERROR_NEAR) for row in _of(near, methods).to_dict("records")]
        runs = _of(summary[NEARLY_INCOMPRESSIBLE], methods)
        slopes.append(_slope(runs, f"{name}, nu {NEARLY_INCOMPRESSIBLE:g}", "p", SLOPE))
    slopes += _default_slopes(tables["summary"])
    errors += _default_errors(tables["summary"])
    return [claim for claim in (*slopes, *errors) if claim is not None]


def _default_slopes(summary: pd.DataFrame) -> Iterator[Claim | None]:
    """Of the package default and its orders, the worst of the scenes with a moving start."""
    moving = summary[summary["scene"].isin(MOVING)]
    for name, (slopes, _) in ASKED_OF_ORDER.items():
        for nu in (NU, RUBBER):
            runs = select(moving, method=name, nu=nu)
            for field, asked in zip(_FIELD, slopes, strict=True):
                yield _slope(runs, f"{name}, moving start, nu {nu:g}", field, asked)
    near = select(summary, method=PACKAGE.name, nu=NEARLY_INCOMPRESSIBLE)
    for field, asked in zip(_FIELD, ASKED_OF_ORDER[PACKAGE.name][0], strict=True):
        yield _slope(near, f"{PACKAGE.name}, nu {NEARLY_INCOMPRESSIBLE:g}", field, asked)


def _default_errors(summary: pd.DataFrame) -> Iterator[Claim]:
    """The largest component errors at 17^3, and stress over that of the elements."""
    linear = select(summary, scene="linear", family="A+B+C=0")
    moving = summary[summary["scene"].isin(MOVING)]
    for name, (_, errors) in ASKED_OF_ORDER.items():
        for row in select(moving, method=name).to_dict("records"):
            for field, asked in zip(_FIELD, errors.get(row["nu"], ()), strict=False):
                if not math.isnan(row[f"error_{field}_h16"]):
                    yield Claim(
                        f"largest error of {_FIELD[field]} at 17^3, nu {row['nu']:g}",
                        row[f"error_{field}_h16"], "<=", asked, where=f"{name}, {row['scene']}",
                        sound=not row["folded"], format=".2e",
                    )  # fmt: skip
    stress = linear.pivot_table(index="nu", columns="method", values="error_P_h16")
    if {PACKAGE.name, B_BAR.name} <= set(stress):
        for nu, ratio in (stress[PACKAGE.name] / stress[B_BAR.name]).dropna().items():
            what = f"error of stress at 17^3 over that of elements, nu {nu:g}"
            yield Claim(what, float(ratio), where=PACKAGE.name, format=".2f")


def _displaced(summary: pd.DataFrame) -> pd.DataFrame:
    """The runs that begin as in the paper."""
    return summary[summary["scene"].isin(SCENES)]


def _of(runs: pd.DataFrame, methods: Sequence[Method]) -> pd.DataFrame:
    return runs[runs["method"].isin([method.name for method in methods])]


def _slope(runs: pd.DataFrame, what: str, field: str, asked: float) -> Claim | None:
    column = f"slope_{field}_last"
    if not runs[column].notna().any():
        return None
    worst = runs.loc[runs[column].idxmin()]
    return Claim(
        f"{_FIELD[field]} slope, {what}", float(worst[column]), ">=", asked, format=".2f",
        where=f"{worst['scene']}, {worst['family']}, {worst['method']}",
        sound=not runs["folded"].any(),
    )  # fmt: skip


def _error(row: Mapping[str, Any], asked: float) -> Claim:
    return Claim(
        f"{row['field']}_{row['component']} at 17^3, nu {row['nu']:g}", row["error"], "<=", asked,
        where=row["method"], sound=not row["folded"], format=".2e",
    )  # fmt: skip


#: Curves that nearly coincide: those below are wide and pale with large open markers, so that what
#: is drawn over them hides nothing.
_BELOW: dict[str, dict[str, Any]] = {
    PAPER.name: {"linewidth": 4.2, "alpha": 0.45, "markersize": 11.0, "zorder": 2.0},
    SUPG.name: {"linewidth": 2.6, "alpha": 0.6, "markersize": 8.0, "zorder": 2.1},
    FORCE_ONLY.name: {"linewidth": 1.3, "markersize": 8.0, "zorder": 2.2},
    B_BAR.name: {"linewidth": 1.1, "markersize": 5.5, "zorder": 2.3},
    PACKAGE.name: {"linewidth": 1.1, "markersize": 3.6, "zorder": 2.4},
}


def _curves(
    part: pd.DataFrame, methods: Sequence[Method], nested: bool, layered: bool = False
) -> list[Curve]:
    """Largest component error; ``nested`` open markers show curves that nearly coincide.

    ``layered``: the same by width, as :data:`_BELOW` says.
    """
    curves = []
    for method in methods:
        largest = select(part, method=method.name).groupby("h")["error"].max()
        look = method.look
        if method.line == ":" or nested:
            look |= {"markerfacecolor": "white" if method.line == ":" else "none"}
        if nested:
            look |= {"markersize": {"s": 9.5, "^": 6.5, "o": 3.0}.get(method.marker, 4.8)}
        if layered and method.name in _BELOW:
            look |= _BELOW[method.name]
            look |= {} if method == PACKAGE else {"markerfacecolor": "none"}
        curves.append(Curve(method.label, largest.index.tolist(), largest.tolist(), look))
    return curves


def scenes_figure(results: Results, methods: Sequence[Method], nested: bool) -> Figure:
    """Scenes and families from left to right, momentum above stress, nu = 0.3."""
    figure, axes = panels(2, 4, width=2.9, height=3.1)
    for column, (scene, family) in enumerate(itertools.product(SCENES, FAMILIES)):
        for row, (field, word) in enumerate(_FIELD.items()):
            part = select(results.tables["table"], scene=scene, family=family, field=field, nu=NU)
            convergence_panel(
                axes[row, column],
                _curves(part, methods, nested, layered=not nested),
                title=f"{scene}, {family}: {word}",
                y_label="relative L2 error [-]" if column == 0 else "",
                x_label="spacing h [m]" if row == 1 else "",
            )
    outside_legend(figure, axes.flat, columns=4)
    return figure


def others_figure(results: Results) -> Figure:
    """Every other registered method beside the default and the elements, nu = 0.3, A+B+C=0."""
    figure, axes = panels(2, 2, width=3.7, height=3.3)
    for column, scene in enumerate(SCENES):
        for row, (field, word) in enumerate(_FIELD.items()):
            part = select(
                results.tables["table"], scene=scene, family="A+B+C=0", field=field, nu=NU
            )
            part = part[part["h"] >= 1.0 / FINEST_OTHERS]
            shown = [each for each in OTHERS if (part["method"] == each.name).any()]
            convergence_panel(
                axes[row, column],
                _curves(part, [PACKAGE, B_BAR, *shown], nested=False),
                title=f"{scene}: {word}",
                y_label="" if column else "relative L2 error [-]",
                x_label="spacing h [m]" if row else "",
            )
    outside_legend(figure, axes.flat, columns=3)
    return figure


def incompressible_figure(results: Results) -> Figure:
    """All methods at nu = 0.499."""
    figure, axes = panels(1, 2, width=3.6, height=3.0)
    for ax, (field, word) in zip(axes.flat, _FIELD.items(), strict=True):
        part = select(results.tables["table"], nu=NEARLY_INCOMPRESSIBLE, field=field)
        curves = [
            *_curves(part, [PACKAGE, SUPG, CLASSICAL, B_BAR], nested=False, layered=True),
            *_curves(part, NEAR, nested=True),
        ]
        convergence_panel(ax, curves, title=f"nu = {NEARLY_INCOMPRESSIBLE:g}, A+B+C=0: {word}")
    outside_legend(figure, axes.flat, columns=2)
    return figure


def words(tables: Tables) -> Mapping[str, Any]:
    """Settings, the first table, errors by component and the slopes of every scene."""
    table, summary = tables["table"], tables["summary"]
    part = select(table, scene="linear", family="A+B+C=0", nu=NU)
    level = part["h"][part["h"] >= 1.0 / 16.0].min()
    part = _of(part[part["h"] == level], [*HEADLINE, *WITH_XI_F, *UNPROJECTED, LINEAR_KERNEL])
    part = part.assign(name=part["field"] + "_" + part["component"])
    components = ["p_x", "p_z", "P_xx", "P_zz", "P_xy", "P_xz"]
    return {
        "headline": headline(summary),
        "side": f"{1.0 / select(summary, nu=NU)['h_finest'].min() + 1.0:.0f}",
        "components": part.pivot_table("error", "method", "name", sort=False)
        .reindex(columns=components).reset_index(),
        "component_side": f"{1.0 / level + 1.0:.0f}",
        "settings": [
            (*key, runs) for key, runs in summary.groupby(["scene", "family", "nu"], sort=False)
        ],
        "instants": INSTANTS, "amplitude": LINEAR_AMPLITUDE, "gradient": LARGEST_GRADIENT,
        "others": [each.name for each in OTHERS], "nu": NU, "near": NEARLY_INCOMPRESSIBLE,
        "rubber": RUBBER, "nearer": NEARER, "xi_F": PAPER_XI_F, "tau_p": PAPER_TAU_P,
        "cfl": CFL, "package_cfl": default_cfl(default_integrator()),
        "integrator": default_integrator().name,
        "default_operator": default_operator(Box().mesh(0.125), restrained=True).name,
        "support": H_OVER_DX_LATTICE * sph.WendlandC2().support,
    }  # fmt: skip


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--finest``: the last refinement."""
    parser.add_argument(
        "--finest", type=int, help="cells per side of the last level "
        f"(default {FINEST}, {FINEST_QUICK} with --quick)",
    )  # fmt: skip


STUDY = Study(
    name="convergence",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={
        "convergence": partial(scenes_figure, methods=HEADLINE, nested=False),
        "formulations": partial(scenes_figure, methods=BY_OPERATOR[PAPER.name], nested=True),
        "incompressible": incompressible_figure,
        "others": others_figure,
    },
    shown=("convergence",),
    words=words,
    text=Path(__file__).with_suffix(".md"),
    summary=lambda tables: headline(tables["summary"]).to_string(
        index=False, float_format=lambda value: f"{value:.3g}"
    ),
    arguments=arguments,
    warm_up=warm_up,
    description="Convergence of SUPG-SPH, displacement SPH and B-bar FEM on the swinging cube. "
    "With --cloud jitter:J, tet, hex:FILE, tet:FILE or points:FILE[,SURFACE]: all operators on "
    "that cloud instead (options: python -m studies.clouds --help).",
)

if __name__ == "__main__":
    if any(word.split("=")[0] == "--cloud" for word in sys.argv[1:]):
        # By name, so that a change of that study is none of this one's sources.
        sys.exit(importlib.import_module("studies.clouds").run(sys.argv[1:]))
    run_study(STUDY)
