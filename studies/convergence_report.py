"""Figures and document of the convergence study, made from its tables alone."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd

from studies.document import Bullets, Document, Figure, Paragraph, Section, Table
from studies.front import Results
from studies.plotting import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    VERMILION,
    Curve,
    convergence_panel,
    method_look,
    outside_legend,
    panels,
    save_figure,
)
from studies.standard_sections import subtitle, what_failed, what_was_run

#: What the main figure compares: {p,F} SUPG-SPH-H1 by operator, and the two classical methods.
_COMPARED: list[tuple[str, dict[str, str], dict[str, Any]]] = [
    (
        "SUPG-SPH, Literal",
        {"method": "SUPG-SPH", "operator": "Literal"},
        {"color": VERMILION, "marker": "o", "markerfacecolor": "white"},
    ),
    (
        "SUPG-SPH, Consistent (default)",
        {"method": "SUPG-SPH", "operator": "Consistent"},
        {"color": BLUE, "marker": "o"},
    ),
    (
        "SUPG-SPH, Consistent in the force only",
        {"method": "SUPG-SPH", "operator": "Consistent(force)"},
        {"color": GREEN, "marker": "s", "linestyle": "--"},
    ),
    (
        "displacement SPH, Literal",
        {"method": "displacement SPH", "operator": "Literal"},
        {"color": ORANGE, "marker": "X", "linestyle": ":"},
    ),
    (
        "B-bar FEM",
        {"method": "B-bar FEM"},
        {"color": BLACK, "marker": "D", "linestyle": "-."},
    ),
]
_PANELS = [
    ("linear", "A+B+C=0"), ("linear", "A=B=C"),
    ("manufactured", "A+B+C=0"), ("manufactured", "A=B=C"),
]  # fmt: skip
_FIELD = {"p": "momentum", "P": "stress"}
_SHORT = {
    "formulation": "formulation", "secondary": "sec.", "operator": "operator",
    "slope_p_last": "slope p", "slope_P_last": "slope P",
    "error_p_h16": "error p, 1/16", "error_P_h16": "error P, 1/16",
    "error_p_finest": "error p, finest", "error_P_finest": "error P, finest",
    "wall_s_finest": "wall s",
}  # fmt: skip
_FORMATS = {
    "xi_F": "g",
    "slope_p_last": ".2f", "slope_P_last": ".2f", "error_p_h16": ".2e", "error_P_h16": ".2e",
    "error_p_finest": ".2e", "error_P_finest": ".2e", "wall_s_finest": ".1f",
}  # fmt: skip


#: The formulations nearly coincide: large open markers behind, small full ones in front.
_NESTED: dict[str, dict[str, Any]] = {
    "{p,F}": {"markersize": 9.5, "markerfacecolor": "none"},
    "{p,F,J}": {"markersize": 6.5, "markerfacecolor": "none"},
    "{p,F,H,J}": {"markersize": 3.0},
}


def _select(table: pd.DataFrame, **wanted: Any) -> pd.DataFrame:
    for column, value in wanted.items():
        table = table[table[column] == value]
    return table


def _largest(table: pd.DataFrame) -> tuple[list[float], list[float]]:
    """Spacings and the largest component error at each."""
    largest = table.groupby("h")["error"].max()
    return largest.index.tolist(), largest.tolist()


def _curve(label: str, table: pd.DataFrame, look: dict[str, Any]) -> Curve:
    h, error = _largest(table)
    return Curve(label, h, error, look)


def _operators_figure(table: pd.DataFrame, stem: Path) -> Path:
    figure, axes = panels(2, 4, width=2.9, height=2.7)
    for column, (scene, family) in enumerate(_PANELS):
        for row, field in enumerate(_FIELD):
            part = _select(table, scene=scene, family=family, field=field, nu=0.3)
            curves = []
            for label, which, look in _COMPARED:
                runs = _select(part, **which)
                if which["method"] == "SUPG-SPH":
                    runs = _select(
                        runs, formulation="{p,F}", secondary="H1", projection="local", xi_F=0.0
                    )
                curves.append(_curve(label, runs, look))
            convergence_panel(
                axes[row, column],
                curves,
                title=f"{scene}, {family}: {_FIELD[field]}",
                y_label="relative L2 error [-]" if column == 0 else "",
                x_label="spacing h [m]" if row == 1 else "",
            )
    outside_legend(figure, axes.flat, columns=5)
    return save_figure(figure, stem)


def _formulations_figure(table: pd.DataFrame, stem: Path) -> Path:
    figure, axes = panels(2, 4, width=2.9, height=2.7)
    for column, (scene, family) in enumerate(_PANELS):
        for row, field in enumerate(_FIELD):
            part = _select(
                table, scene=scene, family=family, field=field, nu=0.3, method="SUPG-SPH",
                operator="Consistent", projection="local", xi_F=0.0,
            )  # fmt: skip
            curves = [
                _curve(
                    f"{formulation} {secondary}",
                    runs,
                    method_look(str(formulation), secondary=str(secondary))
                    | _NESTED[str(formulation)],
                )
                for (formulation, secondary), runs in part.groupby(
                    ["formulation", "secondary"], sort=False
                )
            ]
            convergence_panel(
                axes[row, column],
                curves,
                title=f"{scene}, {family}: {_FIELD[field]}",
                y_label="relative L2 error [-]" if column == 0 else "",
                x_label="spacing h [m]" if row == 1 else "",
            )
    outside_legend(figure, axes.flat, columns=6)
    return save_figure(figure, stem)


def _incompressible_figure(table: pd.DataFrame, stem: Path) -> Path:
    figure, axes = panels(1, 2, width=3.6, height=3.0)
    for ax, field in zip(axes.flat, _FIELD, strict=True):
        part = _select(table, nu=0.499, field=field)
        curves = []
        for (method, formulation, secondary), runs in part.groupby(
            ["method", "formulation", "secondary"], sort=False
        ):
            words = (str(method), str(formulation), str(secondary))
            label = " ".join(word for word in words if word not in ("-", "displacement"))
            look = method_look(
                str(formulation if method == "SUPG-SPH" else method), secondary=str(secondary)
            ) | _NESTED.get(str(formulation), {})
            curves.append(_curve(label, runs, look))
        convergence_panel(ax, curves, title=f"nu = 0.499, A+B+C=0: {_FIELD[field]}")
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)


def _slopes_table(results: Results, scene: str, family: str, nu: float) -> Table:
    frame = _select(results.tables["summary"], scene=scene, family=family, nu=nu)
    columns = [
        "method", "formulation", "secondary", "operator", "projection", "xi_F", "slope_p_last",
        "slope_P_last", "error_p_h16", "error_P_h16", "error_p_finest", "error_P_finest",
        "wall_s_finest",
    ]  # fmt: skip
    finest = frame["h_finest"].min() if len(frame) else float("nan")
    return Table(
        f"{scene}, {family}, nu = {nu:g}: slopes of the last refinement (the worst of the three "
        "momentum and of the nine stress components) and the largest component errors at "
        f"h = 1/16 and at the finest h (1/{1 / finest:.0f} at best); wall seconds of the finest "
        "run, set-up included, one thread beside other runs.",
        frame[columns],
        formats=_FORMATS,
        headings=_SHORT,
    )


def _verdicts(results: Results) -> Iterable[tuple[str, str, float, float, str]]:
    """Requirement, where, measured, wanted, verdict."""
    summary = results.tables["summary"]
    sph = _select(summary, method="SUPG-SPH", nu=0.3, projection="local", xi_F=0.0)
    asked = [
        ("momentum slope, Consistent", sph, "Consistent", "slope_p_last", 1.95),
        ("momentum slope, Consistent(force)", sph, "Consistent(force)", "slope_p_last", 1.95),
        ("stress slope, Consistent", sph, "Consistent", "slope_P_last", 1.65),
        ("stress slope, Consistent(force)", sph, "Consistent(force)", "slope_P_last", 1.90),
    ]
    for what, frame, operator, column, wanted in asked:
        part = _select(frame, operator=operator)
        if len(part) and part[column].notna().any():
            worst = part.loc[part[column].idxmin()]
            where = (
                f"{worst['scene']}, {worst['family']}, {worst['formulation']} "
                f"{worst['secondary']}"
            )
            yield what, where, worst[column], wanted, _verdict(worst[column] >= wanted)
    literal = _select(sph, operator="Literal")
    if len(literal):
        best = literal["slope_P_last"].max()
        yield "best stress slope, Literal", "all", best, float("nan"), "reported"
    for method, nu in (("B-bar FEM", 0.3), ("B-bar FEM", 0.499)):
        part = _select(summary, method=method, nu=nu)
        for column, name in (("slope_p_last", "momentum"), ("slope_P_last", "stress")):
            if len(part):
                worst_slope = part[column].min()
                yield (
                    f"{name} slope, {method}, nu {nu:g}", "all", worst_slope, 1.95,
                    _verdict(worst_slope >= 1.95),
                )  # fmt: skip
    yield from _error_verdicts(results.tables["table"])
    near = _select(summary, method="SUPG-SPH", nu=0.499)
    if len(near):
        worst = near.loc[near["slope_p_last"].idxmin()]
        yield (
            "momentum slope, nu 0.499", f"{worst['formulation']} {worst['secondary']}",
            worst["slope_p_last"], 1.95, _verdict(worst["slope_p_last"] >= 1.95),
        )  # fmt: skip


def _error_verdicts(table: pd.DataFrame) -> Iterable[tuple[str, str, float, float, str]]:
    """Errors at 17^3, linear limit, A+B+C=0, against what was asked."""
    part = _select(table, scene="linear", family="A+B+C=0", h=1.0 / 16.0, method="SUPG-SPH")
    basic = _select(part, nu=0.3, formulation="{p,F}", secondary="H1")
    asked = [
        ("Consistent", "p", "x", 2.6e-3),
        ("Consistent(force)", "p", "x", 2.6e-3),
        ("Consistent", "P", "xx", 1.0e-2),
        ("Consistent(force)", "P", "xx", 5.5e-3),
    ]
    for operator, field, component, wanted in asked:
        runs = _select(basic, operator=operator, field=field, component=component)
        for row in runs.sort_values(["projection", "xi_F"], ascending=False).itertuples():
            where = "no projection" if row.projection == "none" else "projected"
            yield (
                f"{field}_{component} at 17^3, {operator}", f"{where}, xi_F {row.xi_F:g}",
                row.error, wanted, _verdict(row.error <= wanted),
            )  # fmt: skip
    near = _select(part, nu=0.499, field="p", component="x")
    for row in near.itertuples():
        yield (
            "p_x at 17^3, nu 0.499", f"{row.formulation} {row.secondary}", row.error, 3.2e-3,
            _verdict(row.error <= 3.2e-3),
        )  # fmt: skip


def _verdict(holds: bool) -> str:
    return "met" if holds else "not met"


def _at_17(results: Results) -> Table:
    """Errors of {p,F} H1 at 17^3 in the linear limit, family A+B+C=0."""
    part = _select(results.tables["table"], scene="linear", family="A+B+C=0", nu=0.3)
    part = part[(part["h"] == 1.0 / 16.0)]
    wanted = part[
        ((part["formulation"] == "{p,F}") & (part["secondary"] == "H1"))
        | (part["method"] != "SUPG-SPH")
    ]
    wide = wanted.assign(
        name=wanted["field"] + "_" + wanted["component"]
    ).pivot_table(
        index=["method", "operator", "projection", "xi_F"],
        columns="name",
        values="error",
        sort=False,
    )[["p_x", "p_z", "P_xx", "P_zz", "P_xy", "P_xz"]].reset_index()  # fmt: skip
    return Table(
        "Errors at 17^3 particles, linear limit, A+B+C=0, nu = 0.3, {p,F} SUPG-SPH-H1 and the "
        "classical methods.",
        wide,
        formats=dict.fromkeys(["p_x", "p_z", "P_xx", "P_zz", "P_xy", "P_xz"], ".2e")
        | {"xi_F": "g"},
    )


def _verdict_table(results: Results) -> Table:
    frame = pd.DataFrame(
        list(_verdicts(results)), columns=["what", "worst case", "measured", "asked", "verdict"]
    )
    # Slopes are read with two decimals, errors in powers of ten: one column of text serves both.
    for column in ("measured", "asked"):
        frame[column] = [
            "–" if value != value else (f"{value:.2f}" if value > 0.05 else f"{value:.2e}")
            for value in frame[column]
        ]
    return Table(
        "What was asked of the study and what it gave: the worst slope of the last refinement "
        "over all components, families, scenes, formulations and secondary points, and errors at "
        "17^3 particles in the linear limit, A+B+C=0, of {p,F} SUPG-SPH-H1.",
        frame,
    )


def report(results: Results) -> Document:
    """Figures ``convergence``, ``formulations``, ``incompressible`` and the document."""
    table = results.tables["table"]
    main = _operators_figure(table, results.out / "convergence")
    formulations = _formulations_figure(table, results.out / "formulations")
    near = _incompressible_figure(table, results.out / "incompressible")
    settings = results.tables["summary"][["scene", "family", "nu"]].drop_duplicates()
    return Document(
        title="The swinging cube: order of convergence of SUPG-SPH and of B-bar FEM",
        subtitle=subtitle(results.run),
        abstract=(
            "The mixed total-Lagrangian SUPG-SPH method of Lee et al. (2017) is run on a standing "
            "wave with a known solution, in the linear limit and, with manufactured loads, at "
            "displacement gradients of 0.2. Taken literally, its equations do not converge at "
            "second order: near the boundary the force of a uniform stress is wrong by a fixed "
            "share. With a gradient changed as little as possible so that the discrete divergence "
            "theorem holds, momentum converges at second order and stress at nearly that, with "
            "force and gradient still adjoint. An explicit B-bar finite element on the same "
            "problem statement is the reference."
        ),
        sections=[
            Section(
                "The verdict",
                [_verdict_table(results), _at_17(results)],
            ),
            Section(
                "What is measured",
                [
                    Paragraph(
                        "Error of a component: root mean square over the 12 instants "
                        "(k + 1/2) T / 12 of one period of the L2 norm of the error, divided by a "
                        "fixed scale: for momentum the norm of the largest component's amplitude, "
                        "for stress mu pi U0 / sqrt(8). The same scale serves every component. A "
                        "single instant is no measure: fitted slopes jump with the phase error."
                    ),
                    Bullets(
                        [
                            "`linear`: amplitude 1e-7 m, exact for linear elasticity; "
                            "`manufactured`: largest principal displacement gradient 0.2, body "
                            "force and tractions that make the motion exact for the full "
                            "neo-Hookean solid.",
                            "`Literal`: eqs. (30) and (32) as printed. `Consistent` (default): "
                            "least change of the gradient that satisfies the divergence theorem, "
                            "used for strain and force, which stay adjoint. `Consistent(force)`: "
                            "in the force alone.",
                            "tau_F = dt; xi_F = 0, and for {p,F} H1 the paper's 0.1 beside it; "
                            "tau_p = 0.1 dt at nu = 0.499, else 0. CFL 0.3, Wendland C2, support "
                            "1.54 spacings. B-bar FEM: CFL 0.6, stress at centroids.",
                            "`projection`: local angular-momentum projection of the stresses.",
                        ]
                    ),
                ],
            ),
            Section(
                "By operator",
                [
                    Figure(
                        "Largest component error of {p,F} SUPG-SPH-H1 by operator, of "
                        "displacement SPH and of B-bar FEM. nu = 0.3.",
                        main,
                    )
                ],
            ),
            Section(
                "By formulation",
                [
                    Figure(
                        "Largest component error of every formulation and choice of secondary "
                        "points, Consistent operator, nu = 0.3. The three formulations differ by "
                        "less than a marker; H6 is dashed.",
                        formulations,
                    )
                ],
            ),
            Section(
                "Near incompressibility",
                [Figure("nu = 0.499, linear limit, A+B+C=0.", near, width=0.8)],
            ),
            Section(
                "All slopes and errors",
                [
                    _slopes_table(results, row.scene, row.family, row.nu)
                    for row in settings.itertuples()
                ],
            ),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )
