"""The section of the conservation report about the spinning cube."""

from __future__ import annotations

import numpy as np
import pandas as pd

from studies.conservation.figures import cube_figure
from studies.conservation.measures import DEFAULTS
from studies.conservation.tables import named, table_of
from studies.convergence.figures import select
from studies.harness.front import Results
from studies.report.document import Figure, Paragraph, Section

_WORDS = ("method", "formulation", "secondary", "operator", "weighting", "integrator")


def cube_section(results: Results) -> Section:
    """Text, figure and tables."""
    cube = results.tables["cube"]
    runs = named(cube, *_WORDS)
    bare = (cube["projection"] == "none") & (cube["method"] == "SUPG-SPH")
    runs.loc[bare, "run"] += ", no projection"
    columns = {
        "run": "run", "h_over_dx": "h/dx", "spacing": "dx [m]", "spin": "spin", "cfl": "CFL",
        "steps": "steps", "angular_total": "L drift", "linear_total": "p drift",
        "energy_kept": "E/E0", "dissipated": "dissip.", "rest": "rest", "left_over": "left over",
        "outcome": "outcome", "lost_at": "lost at [s]",
    }  # fmt: skip
    words = named(results.tables["orders"], *_WORDS)
    orders = {
        "run": "run", "spacing": "dx [m]", "order": "order in dt",
        "order_left_over": "order, left over",
        "cfl": "least CFL", "rest": "rest there", "left_over": "left over there",
    }  # fmt: skip
    return Section(
        "The spinning cube",
        [
            Paragraph(_cube_text(cube, results.tables["orders"])),
            Figure(
                "Left: what the ledger leaves over against the CFL number, {p,F} SUPG-SPH-H1 "
                "as printed, consistent, support 1.8 dx, with the paper's two stages and with two "
                "other integrators, and with the defaults of the package (finite elements: their "
                "own CFL number, which bounds a step of another rule). Right: energies; dotted: "
                "the total of a run of the two stages with the small support at CFL 0.3, where "
                "they make energy.",
                cube_figure(cube, results.tables["cube_history"], results.out / "cube"),
            ),
            table_of(
                "Order in the step of the rest, and of rest and work of the projection together.",
                words,
                orders,
            ),
            table_of(
                "All runs of the cube: ten turns. Drifts as shares of the natural scales, energies "
                "of the initial energy; spin in rad/s. Left over: rest and work of the projection "
                "together. Each Runge-Kutta stage projects at positions that differ by dt^2 from "
                "those that F has come to; that work is not physical and the integrator returns "
                "it.",
                runs,
                columns,
            ),
        ],
    )


def _cube_text(cube: pd.DataFrame, orders: pd.DataFrame) -> str:
    ladder = select(cube, group="ladder", cfl=0.3)
    starts = "; ".join(
        f"{row.L_z:.2f} at 1/{1.0 / row.spacing:.0f}"
        for row in ladder.sort_values("spacing", ascending=False).itertuples()
    )
    rests = "; ".join(
        f"{row.rest:.1e} at 1/{1.0 / row.spacing:.0f}"
        for row in ladder.sort_values("spacing", ascending=False).itertuples()
    )
    mine = select(orders, group="ladder")["order"]
    text = (
        "The exact cube has 19,250 kg m^2/s and 1.0106e6 J; the discrete one has lumped masses at "
        f"its vertices, hence 1 + 2 h^2 times that: L_z = {starts}. What is kept is that number. "
        "Its edges move at about the shear wave speed: the cube swells and pulsates. The largest "
        f"rest of the ledger at CFL 0.3 is {rests} of the initial energy. It falls "
        f"with the step to the power {mine.min():.1f} to {mine.max():.1f}: with n steps of dt "
        "a two-stage "
        "Runge-Kutta scheme gives n (w dt)^4 / 4 of its energy to an undamped oscillation of "
        "frequency w, so dt^3 in a given time. A bound such as 1e-6 is a matter of the step, and "
        "of how fast the body turns."
    )
    text += _verlet_text(cube, orders)
    grown = cube[(cube["outcome"] != "kept") & (cube["method"] != "B-bar FEM")]
    if len(grown):
        worst = grown["rest"].replace(np.inf, np.nan).max()
        counts = ", ".join(
            f"{len(part)} with {name}" for name, part in grown.groupby("integrator", sort=False)
        )
        text += (
            f" {len(grown)} of {int((cube['method'] != 'B-bar FEM').sum())} runs did not keep "
            f"their energy ({counts}; rest up to {worst:.2g} of the initial energy): the two-stage "
            "scheme lets fast undamped modes grow, by (w dt)^4 / 8 a step in amplitude. Their "
            "momenta are kept all the same."
        )
    return text


def _verlet_text(cube: pd.DataFrame, orders: pd.DataFrame) -> str:
    """What position Verlet leaves over: a swing of ``dt^2`` that does not add up over the steps."""
    usual = select(cube, method=DEFAULTS, group="defaults", formulation="{p,F}")
    fitted = select(orders, integrator="position Verlet")["order"]
    if not len(usual) or not len(fitted):
        return ""
    largest = "; ".join(
        f"{row.rest:.1e} ({row.rest_end:+.1e} at the end) at 1/{1.0 / row.spacing:.0f}, CFL "
        f"{row.cfl:g}"
        for row in usual.sort_values(["spacing", "cfl"], ascending=False).itertuples()
    )
    return (
        " Position Verlet keeps the energy of a shadow problem, so what is left over is an "
        "oscillation of size dt^2 that does not accumulate; with the defaults the largest is "
        f"{largest}. It falls with the step to the power {fitted.min():.1f} to {fitted.max():.1f}."
    )
