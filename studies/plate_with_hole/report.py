"""The report: verdicts, concentrations, pictures, how stresses were compared."""

from __future__ import annotations

import numpy as np
import pandas as pd

from studies.harness.results import Results
from studies.plate_with_hole.cases import HALF_WIDTH, INSTANTS, RADIUS, STRESS
from studies.plate_with_hole.figures import line_figure, plate_figure
from studies.plate_with_hole.verdicts import verdicts
from studies.report.document import Document, Figure, Paragraph, Section, Table
from studies.report.standard_sections import subtitle, what_failed, what_was_run

_HEADINGS = {
    "edge_particles": "edge, particles",
    "edge_spread": "spread",
    "edge_fit": "edge, fit",
    "highest_particles": "highest, particles",
    "highest_fit": "highest, fit",
}


def report(results: Results) -> Document:
    """Everything from the tables, and the pictures of the run if they are still there."""
    plate = plate_figure(results, results.out / "shots", results.out / "plate")
    lines = line_figure(results, results.out / "ligament")
    found = verdicts(results.tables)
    net = 1.0 - RADIUS / HALF_WIDTH
    known = results.tables["known"].copy()
    known["of the net section"] = np.where(
        known["what"] == "infinite plate", known["concentration"], net * known["concentration"]
    )
    return Document(
        title="Plate with a hole: stress concentration from mesh files",
        subtitle=subtitle(results.run),
        abstract=(
            "A quarter of a square plate with a hole, read from Gmsh files, is pulled slowly by "
            "SUPG-SPH with everything but the operator at its default, and by B-bar elements on "
            "the same hexahedra. Asked: the stress at the edge of the hole within 3 % of B-bar."
        ),
        sections=[
            Section(
                "Asked and met",
                [
                    _in_words(found),
                    Table(
                        "Relative difference from B-bar.", found, {"off": "+.2%", "asked": ".0%"}
                    ),
                ],
            ),
            Section("Concentration", _concentration(results, known)),
            Section(
                "Pictures",
                [
                    Figure("Hoop stress on the front, plane strain.", plate),
                    Figure(
                        "Ligament and ring, plane strain. Particles: means over the thickness; "
                        "elements on the ligament: the fit. Right: middles of cells, no fit.",
                        lines,
                    ),
                ],
            ),
            Section("How", _how()),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )


def _in_words(found: pd.DataFrame) -> Paragraph:
    default = found[found["operator"] == "SummationByParts"]
    if len(default) == 0:
        return Paragraph("No run with the default operator has finished: nothing is decided.")
    met = int((default["met"] == "met").sum())
    worst = float(default["off"].abs().max())
    return Paragraph(
        f"With the default operator, SummationByParts, {met} of {len(default)} comparisons are "
        f"within the tolerance; the largest difference is {100.0 * worst:.1f} %."
    )


def _concentration(results: Results, known: pd.DataFrame) -> list[Paragraph | Table]:
    columns = ["method", "operator", "mesh", "thickness", "particles", *_HEADINGS]
    effort = ["operator", "mesh", "thickness", "particles", "steps", "setup_s", "wall_s",
              "unrest", "kinetic_share"]  # fmt: skip
    table = results.tables["table"]
    return [
        Table(
            "Known concentrations, of the gross section (load over the whole width) and the net "
            "one. Strip: Heywood's formula. The plane reference is this square plate by second-"
            "order elements, linear elasticity; it decides between methods in plane strain.",
            known,
            {"concentration": ".3f", "of the net section": ".3f"},
        ),
        Table(
            "Hoop stress over the pull (gross section) at X = a, Y = 0 and the highest on the "
            "hole. spread: highest less lowest of the particles at the edge, over the thickness.",
            table[columns],
            dict.fromkeys(_HEADINGS, ".3f"),
            _HEADINGS,
        ),
        Table(
            "Effort and rest. unrest: range of the largest stress during the hold over its mean; "
            "kinetic_share: kinetic over strain energy at the end; setup_s: with the operator "
            "from the cache where an earlier run left it.",
            table[effort],
        ),
    ]


def _how() -> list[Paragraph]:
    return [
        Paragraph(
            f"Half-width {HALF_WIDTH:g} m, radius {RADIUS:g} m, {STRESS:g} Pa on E = 210 GPa, "
            "nu = 0.3: a strain of 1e-4, so that the neo-Hookean solid is linear to 1e-3. The "
            "load rises within several periods of the slowest mode and holds; stresses are means "
            f"of {INSTANTS} instants of the hold. plane_strain: rollers on back and front; free: "
            "on the back alone, half of a plate 0.1 m thick with free faces, whose concentration "
            "varies over the thickness."
        ),
        Paragraph(
            "B-bar has its stresses in the middle of elements, particles have theirs on the edge "
            "of the hole itself. They are compared in three ways. In the middle of the cells at "
            "the hole: elements as they are, particles as the mean of the cell's corners; nothing "
            "is extrapolated, but the mean smooths. At the edge by the same fit: both from the "
            "middles of cells, by the quadratic in X and Y that fits the nearest 40 of them; on "
            "Kirsch's field this fit is 0.8 % too high on the hexahedra from exact values in the "
            "middles, 0.7 % from means of exact corners, and on the tetrahedra 0.9 % too low from "
            "the latter (a test holds these numbers). At the edge as it is: particles against the "
            "elements' fit. Tetrahedra are compared with B-bar on the hexahedra."
        ),
    ]
