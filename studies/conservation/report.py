"""The document of the conservation study, made from its tables and frames alone."""

from __future__ import annotations

import pandas as pd

from sphsolid import PF
from sphsolid.defaults import default_cfl, default_integrator, default_stabilisation
from sphsolid.scenes import l_shaped_block
from studies.conservation.cube_report import cube_section
from studies.conservation.figures import (
    drift_figure,
    ledger_figure,
    momenta_figure,
    sequence_figure,
)
from studies.conservation.tables import FORMATS, named, table_of
from studies.conservation.verdicts import PARTLY_SMOOTH, SMOOTH, undeformed_impulse
from studies.convergence.cases import said
from studies.convergence.figures import select
from studies.harness.front import Results
from studies.report.document import Block, Bullets, Document, Figure, Paragraph, Section, Table
from studies.report.standard_sections import subtitle, what_failed, what_was_run

_BLOCK = {
    "formulation": "form.", "secondary": "sec.", "operator": "operator", "spacing": "dx [m]",
    "linear": "|p|", "angular_free": "L after 5 s", "angular_step": "L, one step",
    "impulse_gap": "L(5 s) - impulse", "energy_kept": "E/E(5 s)", "dissipated": "dissip./work",
    "rest": "rest/work", "left_over": "left over/work",
    "integrator": "integrator", "noise": "noise", "outcome": "outcome",
}  # fmt: skip


def report(results: Results) -> Document:
    """All figures and the document."""
    return Document(
        title="What is kept: the L-shaped block and the spinning cube",
        subtitle=subtitle(results.run),
        abstract=(
            "Lee et al. (2017), section 8.1: a free L-shaped block of disordered particles, kicked "
            "by two opposite tractions, must keep zero linear momentum at all times and its "
            "angular momentum once the tractions have ended, with a smooth pressure. Every "
            "formulation, both kinds of secondary particles and both operators are run for 20 s, "
            "with the local projection of the stresses and without, beside B-bar finite elements "
            "on the same mesh. A spinning cube tests the energy ledger: each term has a column of "
            "its own, and what is left over is the error of the time integrator."
        ),
        sections=[
            _verdict_section(results),
            _setting_section(),
            _momentum_section(results),
            _pressure_section(results),
            _energy_section(results),
            _changes_section(results),
            cube_section(results),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )


def _verdict_section(results: Results) -> Section:
    frame = results.tables["verdicts"]
    columns = {
        "claim": "claim", "where": "decided by", "measured": "measured", "wanted": "wanted",
        "verdict": "verdict",
    }  # fmt: skip
    paper = frame[frame["source"] == "paper"]
    asked = frame[frame["source"] == "asked"]
    return Section(
        "Verdicts",
        [
            table_of("What the paper claims, and the worst run that decides it.", paper, columns),
            table_of("What was asked beyond the paper.", asked, columns),
        ],
    )


def _setting_section() -> Section:
    return Section(
        "What is published and what is our choice",
        [
            Bullets(
                [
                    "Published: geometry, E = 50046 Pa, nu = 0.3, rho0 = 1000 kg/m^3, CFL 0.3, "
                    "{p,F} SUPG-SPH-H6 with tau_F = dt and xi_F = 0, 388 disordered particles; the "
                    "tractions by reference to earlier papers.",
                    "Ours: the disordered arrangement itself (vertices of a mesh, each moved by up "
                    "to a tenth of the spacing in each direction; 425 is the number nearest to "
                    "388), smoothing function and support (Wendland C2, 1.8 dx), the end of the "
                    "run (20 s), tau_p = 0. `Package defaults` are ours too: "
                    f"{_of_the_package()}. The spinning cube is not in the paper.",
                    "Drifts are shares of the natural scales sum V |p| and sum V |x| |p| at the "
                    "same instant. `Pressure noise` is the share of the pressure that alternates "
                    "from neighbour to neighbour, averaged over the records after 5 s: 1 for a "
                    "checkerboard, 0.25 for a wave of six spacings, 0.1 for one of ten. It is "
                    "taken at the particles, for finite elements at the centroids, where the "
                    "methods evaluate the law. Smooth: at most "
                    f"{SMOOTH:g} times that of finite elements on the same mesh; in part: "
                    f"{PARTLY_SMOOTH:g} times.",
                    "`Outcome`: kept; lost (the solution became invalid); energy made (what "
                    "the ledger leaves over, the time integrator's share, exceeds one percent at "
                    "the end); "
                    "ledger open (as much is missing).",
                ]
            )
        ],
    )


def _of_the_package() -> str:
    material = l_shaped_block().material
    integrator = default_integrator()
    cfl = default_cfl(integrator)
    chosen = default_stabilisation(PF(), material)
    weighting = "self-adjoint" if chosen.is_self_adjoint else "printed"
    return (
        f"{integrator.name} at CFL {cfl:g}, SUPG-{chosen.secondary.name} with {weighting} "
        f"weighting of D(p), tau_F = {said(chosen.tau_F)} whatever the step, xi_F = "
        f"{chosen.xi_F:g}"
    )


def _momentum_section(results: Results) -> Section:
    table, history = results.tables["table"], results.tables["history"]
    columns = {
        name: _BLOCK[name]
        for name in ("spacing", "formulation", "secondary", "operator", "integrator", "linear",
                     "angular_free", "impulse_gap", "outcome")
    }  # fmt: skip
    blocks: list[Block] = [
        Figure(
            "Both momenta over time, {p,F} SUPG-SPH-H6. The paper's Fig. 7 shows the same: angular "
            "momentum grows with the tractions and stays.",
            momenta_figure(history, results.out / "momenta"),
        ),
        Figure(
            "Angular momentum that no traction gave, with the projection and without, {p,F} "
            "SUPG-SPH-H6, and with the defaults. Dotted line: 1e-12.",
            drift_figure(history, results.out / "drift"),
            width=0.8,
        ),
        table_of(
            "With the projection. `|p|`: the largest share of linear momentum at any time.",
            table[table["group"].isin(["all", "defaults"])],
            columns,
        ),
    ]
    bare = select(table, group="no projection")
    if len(bare):
        blocks.append(table_of("Without it, for contrast.", bare, columns))
    blocks += [Paragraph(_impulse_text(table)), _impulse_table(table)]
    return Section("Momenta of the L-shaped block", blocks)


def _impulse_text(table: pd.DataFrame) -> str:
    estimate = undeformed_impulse()
    numbers = ", ".join(f"{value:.4g}" for value in estimate)
    return (
        f"With the arms of the undeformed body the tractions would give ({numbers}) kg m^2/s. The "
        "block turns and bends while they act, so their arms change; at a thousandth of the load "
        "the estimate is met. The traction itself keeps its direction (dead load)."
    )


def _impulse_table(table: pd.DataFrame) -> Table:
    runs = table[
        table["group"].isin(["all", "elements", "small load", "defaults"])
        & table["formulation"].isin(["{p,F}", "-"])
        & (table["secondary"].isin(["H6", "-"]) | (table["group"] == "defaults"))
    ].copy()
    for axis, value in zip("xyz", undeformed_impulse(), strict=True):
        runs[f"{axis}"] = runs[f"L_{axis}"] / (value * runs["load"])
    columns = {
        "method": "method", "operator": "operator", "spacing": "dx [m]", "load": "load",
        "L_x": "L_x", "L_y": "L_y", "L_z": "L_z", "x": "x / est.", "y": "y / est.",
        "z": "z / est.",
    }  # fmt: skip
    formats = FORMATS | dict.fromkeys(("L_x", "L_y", "L_z"), ".4e") | dict.fromkeys("xyz", ".4f")
    return Table(
        "Angular momentum at 5 s [kg m^2/s], and over the undeformed-arm estimate.",
        runs[list(columns)],
        formats=formats,
        headings=columns,
    )


def _pressure_section(results: Results) -> Section:
    table = results.tables["table"]
    spacings = sorted(select(table, group="elements")["spacing"].unique(), reverse=True)
    blocks: list[Block] = []
    for number, spacing in enumerate(spacings):
        particles = int(select(table, group="elements", spacing=spacing)["particles"].iloc[0])
        if not len(select(table, group="all", spacing=spacing, operator="Literal")):
            continue
        blocks.append(
            Figure(
                f"Pressure, positive in tension, {{p,F}} SUPG-SPH-H6 and B-bar FEM on the same "
                f"{particles} points (as the paper's Fig. 8), both as means over "
                "cells. Each panel is centred on its body.",
                sequence_figure(results.out, results.out / f"sequence_{number + 1}", spacing),
            )
        )
    runs = table[
        table["group"].isin(["all", "elements", "disorder", "defaults"])
        & table["formulation"].isin(["{p,F}", "-"])
        & (table["secondary"].isin(["H6", "-"]) | (table["group"] == "defaults"))
    ].sort_values(["spacing", "jitter", "method", "operator"], ascending=[False, True, True, True])
    columns = {
        "method": "method", "operator": "operator", "spacing": "dx [m]", "jitter": "disorder",
        "noise": "noise", "pressure_1": "p 1 % [Pa]", "pressure_99": "p 99 % [Pa]",
        "J_min": "J min", "J_max": "J max",
    }  # fmt: skip
    formats = FORMATS | {"pressure_1": ".0f", "pressure_99": ".0f", "J_min": ".3f",
                          "J_max": ".3f"}  # fmt: skip
    blocks.append(
        Table(
            "Pressure after 5 s: noise averaged over time; extremes over time of its percentiles "
            "by volume and of J. Disorder: the shares of the spacing within which particles were "
            "moved.",
            runs[list(columns)],
            formats=formats,
            headings=columns,
        )
    )
    return Section("Pressure of the L-shaped block", blocks)


def _energy_section(results: Results) -> Section:
    table = results.tables["table"]
    columns = {
        name: _BLOCK[name]
        for name in ("spacing", "formulation", "secondary", "operator", "integrator",
                     "energy_kept", "dissipated", "rest", "left_over")
    }  # fmt: skip
    runs = table[table["group"].isin(["all", "elements", "defaults"])]
    return Section(
        "Energy of the L-shaped block",
        [
            Figure(
                "The ledger of {p,F} SUPG-SPH-H6 as in the paper and consistent, and of {p,F} with "
                "the defaults; 425 particles. Below: sizes on a log axis.",
                ledger_figure(results.tables["history"], results.out / "ledger"),
            ),
            table_of(
                "Energy at the end over that at 5 s; dissipation of the stabilisation and rest of "
                "the ledger over the work of the tractions.",
                runs,
                columns,
            ),
        ],
    )


def _changes_section(results: Results) -> Section:
    table = results.tables["table"]
    runs = table[table["group"].isin(["changed", "long"])]
    if not len(runs):
        return Section("Changes of the setting", [Paragraph("Not part of the short form.")])
    lost = runs[runs["outcome"] != "kept"]
    runs = named(runs, "method", "formulation", "secondary", "operator", "weighting", "integrator")
    columns = {
        "run": "run", "h_over_dx": "h/dx", "cfl": "CFL", "tau_F": "tau_F", "xi_F": "xi_F",
        "tau_p": "tau_p", "until": "to [s]", "angular_free": "L drift",
        "energy_kept": "E/E(5 s)", "dissipated": "dissip.", "rest": "rest", "noise": "noise",
        "outcome": "outcome", "lost_at": "lost at [s]",
    }  # fmt: skip
    return Section(
        "Changes of the setting",
        [
            Paragraph(
                "From the paper's setting one choice is changed at a time, with either operator "
                "(tau_F = 0: no stabilisation at all). Dissipation and rest over the work of the "
                f"tractions. {len(runs) - len(lost)} of {len(runs)} runs end with their "
                "energy; momenta are kept by the others too: that says nothing about stability."
            ),
            table_of("425 particles, disorder 0.2.", runs, columns),
        ],
    )
