"""The report of the stability study, made from its tables."""

from __future__ import annotations

import pandas as pd

from studies.harness.results import Results, Tables
from studies.report.document import Block, Bullets, Document, Figure, Paragraph, Section, Table
from studies.report.standard_sections import subtitle, what_failed, what_was_run
from studies.stability.hard_case_figures import overview
from studies.stability.hard_case_judgement import ABSENT, CRITERIA, LOST, SOUND
from studies.stability.hard_case_methods import BASE, DEFAULTS, FEW, METHODS, VARIANTS
from studies.stability.hard_cases import LONG_COLUMN
from studies.stability.spectrum_report import spectrum_sections
from studies.stability.verdicts import BY_PACKAGE
from studies.stability.wave_report import wave_sections
from studies.stability.waves import WAVE_CLAIMS

_FORMATS = {
    "energy_kept": ".3f", "energy_gain": ".1e", "energy_rest": ".1e", "J_min": ".3f",
    "J_max": ".3f", "unseen_rms": ".2f", "inside_out": ".1%", "smallest_det": ".2f",
    "noise_end": ".2f", "answer": ".4g", "deviation": "+.1%", "wall_s": ".1f",
}  # fmt: skip
_HEADINGS = {
    "energy_kept": "kept", "energy_gain": "gain", "energy_rest": "rest", "J_min": "J min",
    "J_max": "J max", "unseen_rms": "unseen", "inside_out": "turned", "smallest_det": "det min",
    "noise_end": "noise", "deviation": "off by", "wall_s": "s",
}  # fmt: skip
_SHOWN = ["method", "verdict", *_FORMATS]


def report(results: Results) -> Document:
    """Verdicts, hard cases, spectrum."""
    table = results.tables["table"]
    sections = [
        *_failures_of_defaults(results.tables),
        Section(
            "Verdicts",
            [
                Table("Each verdict is computed from the tables.", results.tables["verdicts"]),
                Paragraph(
                    "Published [Lee2017]: the column (Omega 105 rad/s, nu 0.495, to 0.1 s) and the "
                    "punch, run there at CFL 0.3 with the two-stage integrator, tau_F = dt, xi_F = "
                    "0.2 (H1) or 0 (H6) and tau_p = 0.1 dt on the column. Every other case, the "
                    "criteria, h/dx and the package's own settings are ours."
                ),
            ],
        )
    ]
    if len(table):
        sections += _hard_cases(results, table)
    sections += wave_sections(results)
    sections += spectrum_sections(results.tables, results.out)
    sections += [what_was_run(results.run), what_failed(results.failures)]
    return Document(
        title="Stability: where each method breaks",
        subtitle=subtitle(results.run),
        abstract=(
            "Two views of the same question. Hard cases in time: twisting columns up to 300 rad/s "
            "and nu 0.4999, longer ones from nu 0.3 on, disordered columns, the punch, seeded "
            "modes, a block pulled to twice its length, a free vibration and a short pulse. And "
            "the spectrum of one time step: which modes grow, from which CFL number on, and what "
            "they look like."
        ),
        sections=sections,
    )


def _failures_of_defaults(tables: Tables) -> list[Section]:
    """What today's defaults fail, before anything else."""
    table = tables["table"]
    ours = table[table["method"].isin(BY_PACKAGE) & ~table["verdict"].isin([SOUND, ABSENT])]
    said = [f"{row.case}, {row.method}: {row.why}" for row in ours.itertuples()]
    wrong = tables["verdicts"]
    waves = wrong[wrong["claim"].isin([claim for claim, _ in WAVE_CLAIMS])]
    said += [
        f"{row[1]}: {row[2]} - {row[3]}" for row in waves.itertuples(name=None)
        if row[2] not in ("reproduced", "not run")
    ]  # fmt: skip
    if not said:
        return []
    return [
        Section(
            "What fails today with the package's own settings",
            [
                Paragraph(
                    f"{DEFAULTS.name}: nothing is chosen; the others name the formulation. A run "
                    "that ends folded has failed, however sound its stresses look; it says so "
                    "itself."
                ),
                Bullets(tuple(said)),
            ],
        )
    ]


def _hard_cases(results: Results, table: pd.DataFrame) -> list[Section]:
    methods = [method.name for method in METHODS]
    is_long = table["case"].str.startswith(LONG_COLUMN)
    short, long = table[~is_long], table[is_long]
    variants = [BASE.name, *(variant.name for variant in VARIANTS)]
    said = (
        "Green: sound; yellow: ran to the end and is useless; red: lost. In a cell: energy kept; "
        "of a seed the amplitude left (root of the energy over that at the start); in tension the "
        "growth of the noise; of a lost run, after which share of the time; fold: the positions "
        "folded, with the largest unseen motion of neighbours (rms over the body, of their "
        "distance: sound runs 0.03 to 0.1)."
    )
    blocks: list[Block] = [
        Paragraph("A run that lasts is still useless when any of these holds:"),
        Bullets(CRITERIA),
        Figure(
            f"Every case with every method. {said}",
            overview(short, results.out, name="hard_cases", methods=methods, title=""),
        ),
    ]
    if len(long):
        drawn = overview(
            long, results.out, name="long_columns", methods=[m.name for m in FEW], title=""
        )
        blocks.append(Figure(f"The long columns, to 0.2 s. {said}", drawn))
    in_variants = table[table["method"].isin(variants[1:])]
    if len(in_variants):
        ours = table[table["case"].isin(set(in_variants["case"]))]
        drawn = overview(ours, results.out, name="hard_case_variants", methods=variants, title="")
        blocks.append(
            Figure(f"{BASE.name} and what one change makes of it. {said}", drawn)
        )
    return [
        Section("Hard cases", blocks),
        Section("Who fails where", [_failures(table)]),
        Section("All runs", _case_tables(table)),
    ]


def _failures(table: pd.DataFrame) -> Table:
    bad = table[~table["verdict"].isin([SOUND, "not applicable"])]
    frame = bad[["case", "method", "verdict", "why"]].copy()
    frame["where"] = [
        f"X = ({x:.2g}, {y:.2g}, {z:.2g}) m" if verdict == LOST else ""
        for verdict, x, y, z in bad[["verdict", "lost_X", "lost_Y", "lost_Z"]].itertuples(
            index=False
        )
    ]
    caption = "Runs that were lost or are useless, and why."
    return Table(caption, frame)


def _case_tables(table: pd.DataFrame) -> list[Block]:
    found: list[Block] = [
        Paragraph(
            "kept: energy at the end over what was put in; gain: the largest excess over it at any "
            "record; rest: made by the time integrator; noise: high-frequency share of the "
            "pressure at the end; off by: the answer against B-bar elements."
        )
    ]
    for case, part in table.groupby("case", sort=False):
        answers = part["answer_is"].dropna()
        caption = f"{case}; answer: {answers.iloc[0] if len(answers) else '-'}."
        found.append(Table(caption, part[_SHOWN], formats=_FORMATS, headings=_HEADINGS))
    return found
