"""The document of the punch study, made from its tables and frames."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from sphsolid import PFJ
from sphsolid.defaults import default_cfl, default_integrator, default_stabilisation
from sphsolid.scenes import punch
from studies.convergence.cases import said
from studies.convergence.figures import select
from studies.harness.front import Results
from studies.punch.cases import PRESSES
from studies.punch.figures import INDEPENDENT, height_figure, noise_figure, profile_figure
from studies.punch.methods import FEM
from studies.punch.pictures import (
    READINGS,
    Nothing,
    comparison_picture,
    evolution_picture,
    sequence_picture,
)
from studies.punch.verdicts import verdict_table
from studies.report.document import Block, Bullets, Document, Figure, Paragraph, Section, Table
from studies.report.folding import has_folded
from studies.report.standard_sections import subtitle, what_failed, what_was_run

_FORMATS = {
    "top_low": ".4f", "top_high": ".4f", "noise_mean": ".3f", "noise_late": ".3f",
    "low_MPa": ".2f", "high_MPa": ".2f", "J_min": ".3f", "J_max": ".3f", "rms_mm": ".1f",
    "same_mm": ".1f", "finest_mm": ".1f", "cpu_s": ".2f", "ns_none": ".0f", "ns_H1": ".0f",
    "ns_H6": ".0f", "terms_ratio": ".1f", "step_ratio": ".1f", "energy_kept": ".3f",
    "energy_D_p": ".3f", "energy_D_J": ".3f", "energy_rest": ".4f", "floor_impulse": ".0f",
    "press_impulse": ".0f",
}  # fmt: skip
_HEADINGS = {
    "top_low": "low, m", "top_high": "high, m", "low_MPa": "p 1 %", "high_MPa": "p 99 %",
    "noise_mean": "noise", "noise_late": "later", "rms_mm": "rms", "same_mm": "same",
    "finest_mm": "finest", "cpu_s": "CPU s", "terms_ratio": "terms H6/H1",
    "step_ratio": "step H6/H1", "energy_kept": "kept", "energy_D_p": "D(p)",
    "energy_D_J": "D(J)", "energy_rest": "rest", "floor_impulse": "floor N s",
    "press_impulse": "punch N s",
}  # fmt: skip


def _scaled(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(
        low_MPa=1e-6 * table["pressure_1"],
        high_MPa=1e-6 * table["pressure_99"],
        rms_mm=1e3 * table["top_rms"],
        same_mm=1e3 * table["profile_same"],
        finest_mm=1e3 * table["profile_finest"],
    )


def _shape_table(table: pd.DataFrame, press: str) -> Table:
    finest = select(table, press=press, method=FEM).sort_values("cells")["lattice"]
    return Table(
        f"{press}: the top face and percentiles of the pressure by volume [MPa] at 15 ms; "
        "noise, mean to 15 ms and later; "
        "difference [mm] of the range of the top from the finest B-bar "
        f"({finest.iloc[-1] if len(finest) else 'not run'}; root mean square over the records "
        "to 15 ms) and of the top edge at 15 ms from B-bar on the same and the finest lattice, "
        "the largest.",
        _scaled(select(table, press=press))[
            ["method", "operator", "lattice", "top_low", "top_high", "low_MPa", "high_MPa",
             "noise_mean", "noise_late", "rms_mm", "same_mm", "finest_mm"]
        ],
        formats=_FORMATS,
        headings=_HEADINGS,
    )  # fmt: skip


def _account_table(table: pd.DataFrame, press: str) -> Table:
    return Table(
        f"{press}: range of J; energy at the end as a share of what was supplied (energy at the "
        "start and work of the punch), what D(p) and D(J) did, and the rest, which is the time "
        "integrator's; impulse of floor and punch at 15 ms; steps; processor time with the "
        "account, records and pictures. More columns in table.csv.",
        select(table, press=press)[
            ["method", "operator", "lattice", "J_min", "J_max", "energy_kept", "energy_D_p",
             "energy_D_J", "energy_rest", "floor_impulse", "press_impulse", "steps", "cpu_s"]
        ],
        formats=_FORMATS,
        headings=_HEADINGS,
    )  # fmt: skip


def _lost_table(table: pd.DataFrame) -> list[Block]:
    lost = table[~table["survived"].astype(bool)]
    if len(lost) == 0:
        return [Paragraph(f"None of the {len(table)} runs was lost before its end.")]
    columns = ["press", "method", "operator", "lattice", "lost_at", "lost_where", "reason"]
    return [Table("Runs that were lost: when, where (undeformed) and why.", lost[columns])]


def _folded_table(table: pd.DataFrame) -> list[Block]:
    folded = table[has_folded(table)]
    if len(folded) == 0:
        return [Paragraph(f"The positions of none of the {len(table)} runs folded.")]
    columns = ["press", "method", "operator", "lattice", "folded_at"]
    caption = "Runs whose positions folded, and from when [s]: what they give later is of no use."
    return [Table(caption, folded[columns], formats={"folded_at": ".4f"})]


def _picture(made: Path | Nothing, caption: str) -> list[Block]:
    return [] if isinstance(made, Nothing) else [Figure(caption, made)]


def report(results: Results) -> Document:
    """Figures and the document."""
    table, out = results.tables["table"], results.out
    noise = noise_figure(results, out / "noise")
    profile = profile_figure(results, out / "profile")
    height = height_figure(results, out / "height")
    lattice = table.sort_values("cells")["lattice"].iloc[0] if len(table) else "-"
    return Document(
        title="The punch test: pressure and shape near incompressibility",
        subtitle=subtitle(results.run),
        abstract=(
            "A block of rubber (nu = 0.499) in a box is pressed on half of its top, as in "
            "section 8.2 of Lee et al. (2017). The paper does not say which region, nor whether "
            "the velocity is an initial value or held; both are run. Displacement SPH, the mixed "
            "method without and with its SUPG terms, the operator as printed and the consistent "
            "one stand beside B-bar finite elements on the same lattices and finer ones."
        ),
        sections=[
            Section("The verdict", [
                verdict_table(results.tables), *_lost_table(table), *_folded_table(table),
            ]),
            Section("What is run", _what_is_run()),
            Section("Pressure", [*_pressure(results, lattice), _noise(noise)]),
            Section(
                "H1 and H6",
                [
                    *_picture(
                        comparison_picture(results, out / "comparison"),
                        "At 15 ms, after Fig. 11: initial velocity (left) and held (right); "
                        "pressure of particles and of elements alike as means over cells. The "
                        "paper has JST-SPH in the place of the finite elements.",
                    ),
                    Table(
                        "What a step costs, nanoseconds a particle, one thread, the three timed "
                        "in turn and the fastest taken: {p,F,H,J} without secondary particles, "
                        "with H1 and with H6. Terms: what H6 adds over what H1 adds.",
                        results.tables["cost"],
                        formats=_FORMATS | {"tau_p": "g"},
                        headings=_HEADINGS,
                    ),
                ],
            ),
            Section("Shape", _shape(profile, height)),
            Section("Large distortion", _sequence(results, lattice)),
            Section(
                "All runs",
                [
                    block
                    for press in PRESSES
                    if (table["press"] == press).any()
                    for block in (_shape_table(table, press), _account_table(table, press))
                ],
            ),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )


def _what_is_run() -> list[Block]:
    return [
        Bullets(
            [
                "Published: 1 x 0.1 x 0.5 m (X, Y, Z), rollers on all faces but the top, velocity "
                "10 m/s downward, E = 1 MPa, nu = 0.499, rho0 = 1000, CFL 0.3, lattices 21x11x3 "
                "and 41x21x4 (X, Z, Y), comparison at 15 ms, tau_F = 0.5 dt, xi_F = 0 (H6) or 0.1 "
                "(H1), tau_p = 0 or 0.1 dt.",
                "Ours: `initial`: the half X <= 0.5 m over the whole height starts with the "
                "velocity. `held`: X <= 0.5 m of the top face keeps it and slides under the "
                "punch. `initial, top face only` gives it to the particles of the top face, a "
                "momentum that vanishes with the spacing; `held, sticking` does not slide. End at "
                "30 ms. gamma = kappa and alpha = mu in eq. (27), which the paper leaves to the "
                "user near these values.",
                "Ours: Wendland C2 with the default support; `support 2 dx` is the cubic spline "
                "with h = dx. `by default` rows leave integrator, CFL number and stabilisation but "
                f"tau_p to the package: {_of_the_package()}. All others name the paper's TVD-RK2 "
                "and CFL 0.3, with D(p) weighted as printed. {p,F,J} H1 with tau_F 1 has xi_F = "
                "0, with tau_F 0 xi_F = 0.1.",
                "JST-SPH, with which the paper compares at both lattices, is not implemented "
                "here; nothing is said about it.",
                "Noise is the high-frequency share of the pressure, in the direction where it is "
                "largest: 1 for a checkerboard, 0.1 for a sine of ten spacings.",
                f"Independent hexahedral FE at 15 ms: top face in {list(INDEPENDENT['initial'])} "
                f"m (initial) and {list(INDEPENDENT['held'])} m (held).",
            ]
        )
    ]


def _of_the_package() -> str:
    material, integrator = punch().material, default_integrator()
    cfl = default_cfl(integrator)
    chosen = default_stabilisation(PFJ(), material)
    weighting = "self-adjoint" if chosen.is_self_adjoint else "printed"
    return (
        f"{integrator.name} at CFL {cfl:g}, {weighting} weighting of D(p), tau_F = "
        f"{said(chosen.tau_F)}, xi_F = {chosen.xi_F:g}"
    )


def _pressure(results: Results, lattice: str) -> list[Block]:
    found: list[Block] = []
    for press, operator in (("initial", "Consistent"), ("initial", "Literal"), *(
        (press, "Consistent") for press in READINGS[1:]
    )):  # fmt: skip
        stem = results.out / f"evolution_{press}_{operator}".lower()
        found += _picture(
            evolution_picture(results, press, operator, stem),
            f"After Fig. 10: {press}, {operator} operator, {lattice}. Pressure, positive in "
            "tension, as the particles have it: a mean over cells would hide its fluctuations.",
        )
    return found


def _noise(figure: Path) -> Block:
    return Figure(
        "Above: mean pressure noise over tau_p. Below: noise over time, consistent operator.",
        figure,
    )


def _shape(profile: Path, height: Path) -> list[Block]:
    return [
        Paragraph(
            "The block rings: a standing wave of volume, undamped in the finite elements, moves "
            "the top by millimetres within half a millisecond. The height at one instant is "
            "therefore a harsh measure; the root mean square over all records to 15 ms is given "
            "beside it. D(p) with gamma = kappa takes energy from that wave and from the motion "
            "near the jump of the initial velocity, less on finer lattices."
        ),
        Figure(
            "Above: the top edge at 15 ms; dashed, the range of the independent FE. Below: the "
            "height of its points less that of the finest B-bar; grey, 4 mm.",
            profile,
        ),
        Figure(
            "The lowest height of the top face and the energy over time, coarsest lattice, and "
            "the lowest height at 15 ms over the spacing; dashed, the independent FE.",
            height,
        ),
    ]


def _sequence(results: Results, lattice: str) -> list[Block]:
    found: list[Block] = []
    end = results.tables["table"]["until"].max()
    if not end > 0.015:
        found.append(Paragraph("The short form ends at 15 ms."))
    for press in READINGS:
        found += _picture(
            sequence_picture(results, press, results.out / f"sequence_{press}"),
            f"After Fig. 12: {press}, {lattice}, {{p,F,H,J}} SUPG-SPH-H1 and B-bar FEM, pressure "
            "of both as means over cells. There is no self-contact: where the block folds over it "
            "passes through itself.",
        )
    return found
