"""Figures of the convergence study, each made from its main table."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd

from studies.report.plotting import (
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
#: The formulations nearly coincide: large open markers behind, small full ones in front.
_NESTED: dict[str, dict[str, Any]] = {
    "{p,F}": {"markersize": 9.5, "markerfacecolor": "none"},
    "{p,F,J}": {"markersize": 6.5, "markerfacecolor": "none"},
    "{p,F,H,J}": {"markersize": 3.0},
}


def _largest(table: pd.DataFrame) -> tuple[list[float], list[float]]:
    """Spacings and the largest component error at each."""
    largest = table.groupby("h")["error"].max()
    return largest.index.tolist(), largest.tolist()


def _curve(label: str, table: pd.DataFrame, look: dict[str, Any]) -> Curve:
    h, error = _largest(table)
    return Curve(label, h, error, look)


def select(table: pd.DataFrame, **wanted: Any) -> pd.DataFrame:
    """Rows whose columns have the wanted values."""
    for column, value in wanted.items():
        table = table[table[column] == value]
    return table


def _scenes_by_fields(
    table: pd.DataFrame,
    curves_of: Callable[[pd.DataFrame], list[Curve]],
    stem: Path,
    legend_columns: int,
) -> Path:
    """Scenes and families from left to right, momentum above stress, nu = 0.3."""
    figure, axes = panels(2, 4, width=2.9, height=2.7)
    for column, (scene, family) in enumerate(_PANELS):
        for row, field in enumerate(_FIELD):
            part = select(table, scene=scene, family=family, field=field, nu=0.3)
            convergence_panel(
                axes[row, column],
                curves_of(part),
                title=f"{scene}, {family}: {_FIELD[field]}",
                y_label="relative L2 error [-]" if column == 0 else "",
                x_label="spacing h [m]" if row == 1 else "",
            )
    outside_legend(figure, axes.flat, columns=legend_columns)
    return save_figure(figure, stem)


def operators_figure(table: pd.DataFrame, stem: Path) -> Path:
    """{p,F} SUPG-SPH-H1 by operator beside the classical methods; gives ``stem``."""
    basic = {"formulation": "{p,F}", "secondary": "H1", "projection": "local", "xi_F": 0.0}

    def curves(part: pd.DataFrame) -> list[Curve]:
        return [
            _curve(
                label,
                select(part, **which, **(basic if which["method"] == "SUPG-SPH" else {})),
                look,
            )
            for label, which, look in _COMPARED
        ]

    return _scenes_by_fields(table, curves, stem, legend_columns=5)


def formulations_figure(table: pd.DataFrame, stem: Path) -> Path:
    """Every formulation and choice of secondary points, ``Consistent``; gives ``stem``."""
    shown = {"method": "SUPG-SPH", "operator": "Consistent", "projection": "local", "xi_F": 0.0}

    def curves(part: pd.DataFrame) -> list[Curve]:
        groups = select(part, **shown).groupby(["formulation", "secondary"], sort=False)
        return [
            _curve(
                f"{formulation} {secondary}",
                runs,
                method_look(str(formulation), secondary=str(secondary))
                | _NESTED[str(formulation)],
            )
            for (formulation, secondary), runs in groups
        ]

    return _scenes_by_fields(table, curves, stem, legend_columns=6)


def incompressible_figure(table: pd.DataFrame, stem: Path) -> Path:
    """All methods at nu = 0.499; gives ``stem``."""
    figure, axes = panels(1, 2, width=3.6, height=3.0)
    for ax, field in zip(axes.flat, _FIELD, strict=True):
        part = select(table, nu=0.499, field=field)
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
