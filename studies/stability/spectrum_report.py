"""The spectral sections of the stability report, made from the tables."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from studies.harness.results import Tables
from studies.report.document import Bullets, Figure, Paragraph, Section, Table
from studies.stability.spectrum_figures import (
    default_limits_figure,
    growth_maps,
    limits_figure,
)
from studies.stability.spectrum_growth import LIMITS

_FORMATS = {
    "max_g - 1": ".1e", "decades": ".2f", "frequency": ".2f",
    "cfl_strict": ".2f", "cfl_slow": ".2f", "cfl_fast": ".2f",
}  # fmt: skip
_HEADINGS = {
    "max_g - 1": "max |g| - 1", "decades": "decades in 1000 steps", "frequency": "w dx / c_p",
    "mode": "grows", "mode_beyond": "grows beyond", "cfl_strict": "CFL, no growth",
    "cfl_slow": "CFL, x10 in 1000", "cfl_fast": "CFL, x10 in 50",
}  # fmt: skip
_COLUMNS = [
    "variant", "body", "cfl_strict", "cfl_slow", "cfl_fast", "max_g - 1", "decades", "mode",
    "frequency", "mode_beyond",
]  # fmt: skip


def spectrum_sections(tables: Tables, out: Path) -> list[Section]:
    """What was asked, the maps, the limits, what grows; figures are written to ``out``."""
    limits, growth = tables["spectrum"], tables["spectrum_growth"]
    limits = limits.assign(**{"max_g - 1": limits["max_g"] - 1.0})
    sections = [_question()]
    maps = growth_maps(growth, out)
    if maps is not None:
        caption = (
            "Growth of the fastest mode in one step over CFL and h/dx. Dark: none. Thin line: "
            "tenfold in 1000 steps, thick line: tenfold in 50. The rows of h/dx are not equally "
            "spaced."
        )
        sections.append(Section("Growth over support and step", [Figure(caption, maps)]))
    drawn = limits_figure(limits, out)
    if drawn is not None:
        caption = (
            "Largest CFL number up to which nothing grows tenfold in 1000 steps (open) and in 50 "
            "(filled), one choice changed at a time on a free block. On the left: at every CFL."
        )
        blocks: list[Figure | Table] = [Figure(caption, drawn)]
        scans = limits[~limits["scan"].isin(["map", "larger", "limits"])]
        for base, part in scans.groupby("base", sort=False):
            caption = f"Limits, and what grows at the default CFL number; base {base}."
            blocks.append(_table(part, caption))
        sections.append(Section("Stability limits, one choice at a time", blocks))
    if len(tables["limits"]):
        caption = (
            "Stability limits of the default stabilisation and support on a free block, by "
            "integrator and Poisson's ratio; dotted: the default CFL number."
        )
        figure = Figure(caption, default_limits_figure(tables["limits"], out))
        caption = "The same in numbers. Without tau_p {p,F} and {p,F,J} have one spectrum."
        table = Table(caption, tables["limits"], formats=_FORMATS, headings=_HEADINGS)
        sections.append(Section("Limits of the default settings", [figure, table]))
    larger = limits[limits["scan"] == "larger"]
    if len(larger):
        columns = ["variant", "body", "size", "cfl", "max_g - 1", "decades", "mode", "frequency"]
        caption = "A larger body at the default CFL number."
        table = Table(caption, larger[columns], formats=_FORMATS, headings=_HEADINGS)
        sections.append(Section("A larger body", [table]))
    sections.append(Section("What grows", [Bullets(_findings(limits))]))
    return sections


def _table(part: pd.DataFrame, caption: str) -> Table:
    return Table(caption, part[_COLUMNS], formats=_FORMATS, headings=_HEADINGS)


def _question() -> Section:
    return Section(
        "Spectrum of one step",
        [
            Paragraph(
                "One step about a uniform state at rest is a linear map; `max |g|` is the largest "
                "modulus of its eigenvalues, rigid motions and neutral modes (g = 1 within 1e-5) "
                "left out. Blocks are dense; plane waves in the interior are a von Neumann "
                "analysis with the stored stencil. CFL is dt c_p / h_min, h_min the smallest "
                "distance of two particles."
            ),
            Paragraph(
                "TVD-RK2 lets an undamped oscillation w grow by (w dt)^4 / 8 a step, and damping "
                "that is not a positive form can feed slow modes, so three limits are given: no "
                "growth (|g| - 1 at most "
                f"{LIMITS['strict'] - 1:.0e}), tenfold in 1000 steps ({LIMITS['slow'] - 1:.1e}), "
                f"tenfold in 50 steps ({LIMITS['fast'] - 1:.1e}). F - F_x never changes, nor "
                "without tau_p does J - det F_x (but for terms of order dt^4 of SSP-RK3), so the "
                "formulations differ in the spectrum by `tau_p` alone."
            ),
            Paragraph(
                "With the self-adjoint weighting `tau_F` is in units of h / c_p and does not "
                "change along the CFL axis; printed and paper have it in units of the step, as in "
                "[Lee2017]. `tau_p` is in units of the step everywhere."
            ),
        ],
    )


def _findings(limits: pd.DataFrame) -> list[str]:
    """One sentence a base and body: the limit and the mode that sets it."""
    found = []
    for _, row in limits[limits["scan"] == "base"].iterrows():
        growth = "nothing grows" if row["mode"] == "none" else (
            f"{row['mode']} grows by {row['max_g'] - 1:.1e} a step ({row['where']}, "
            f"w dx/c_p = {row['frequency']:.2f})"
        )  # fmt: skip
        found.append(
            f"{row['base']}, {row['body']} {row['size']}: at CFL {row['cfl']:g} {growth}; "
            f"tenfold in 1000 steps from CFL {row['cfl_slow']:.2f}, in 50 from "
            f"{row['cfl_fast']:.2f} ({row['mode_beyond']})."
        )
    at_usual = limits[limits["scan"] != "larger"]
    for mode, part in at_usual[at_usual["mode"] != "none"].groupby("mode"):
        worst = part.loc[part["max_g"].idxmax()]
        found.append(
            f"**{mode}**: the fastest growing mode in {len(part)} of {len(at_usual)} spectra at "
            f"the default CFL number, at most {worst['max_g'] - 1:.1e} a step ({worst['scan']} "
            f"{worst['variant']}, {worst['base']}, {worst['body']})."
        )
    return found
