"""The document of the speed study, made from its tables."""

from __future__ import annotations

import pandas as pd

from studies.harness.results import Results
from studies.report.document import Block, Document, Paragraph, Section, Table
from studies.report.standard_sections import subtitle, what_failed, what_was_run
from studies.speed.figures import passes_figure

_FORMATS = {
    "ns_per_particle_step": ".0f", "ns_per_particle_crossing": ".0f", "bytes_per_particle": ".0f",
    "flops_per_particle": ".0f", "traffic_per_particle": ".0f", "roofline_share": ".2f",
    "setup_s": ".1f", "tau_p": "g", "cfl": "g", "neighbours": ".1f", "ns_per_particle": ".1f",
}  # fmt: skip
_HEADINGS = {
    "ns_per_particle_step": "ns / step", "ns_per_particle_crossing": "ns / (h/c)",
    "bytes_per_particle": "B stored", "flops_per_particle": "flops",
    "traffic_per_particle": "B moved", "roofline_share": "share", "setup_s": "set-up s",
    "secondary": "sec.", "neighbours": "pairs", "ns_per_particle": "ns",
}  # fmt: skip


def _table(caption: str, frame: pd.DataFrame, columns: list[str]) -> Table:
    return Table(
        caption, frame[[c for c in columns if c in frame]], formats=_FORMATS, headings=_HEADINGS
    )


def report(results: Results) -> Document:
    """Targets, steps, passes, options, the column."""
    t = results.tables
    steps = t["table"]
    sections = [
        Section(
            "Targets",
            [
                Table("Asked and measured in this run.", t["targets"], formats={"measured": ".3g"}),
                Paragraph(
                    "The paper's step is TVD-RK2 with {p,F,J}, SUPG-H1 as printed and projection: "
                    "both stages. The default step is position Verlet with the self-adjoint "
                    "weighting: one evaluation, at 2.3 times the CFL number."
                ),
            ],
        ),
        Section(
            "Steps",
            [
                _table(
                    "Whole steps. ns / (h/c): nanoseconds a particle while a p-wave crosses one "
                    "spacing, which is what a run costs. Share: time that the machine's bandwidth "
                    "or arithmetic would need, over the time taken.",
                    steps.drop_duplicates(
                        ["solver", "cloud", "integrator", "particles", "threads"]
                    ),
                    ["solver", "cloud", "storage", "integrator", "particles", "threads",
                     "ns_per_particle_step", "ns_per_particle_crossing", "bytes_per_particle",
                     "roofline_share", "setup_s"],
                )
            ],
        ),
        Section("Passes", _passes(results)),
    ]  # fmt: skip
    chosen = steps[steps["formulation"] != "-"]
    chosen = chosen[(chosen["integrator"] == "position Verlet") & (chosen["cloud"] == "lattice")]
    chosen = chosen[(chosen["particles"] == 33**3) & (chosen["threads"] == chosen["threads"].max())]
    if len(chosen) > 2:
        sections.append(
            Section(
                "What each option costs",
                [
                    _table(
                        "33^3 lattice, position Verlet: a field or a term that is absent costs "
                        "nothing. The accuracy each gives is in the pareto study.",
                        chosen,
                        ["formulation", "secondary", "weighting", "tau_p", "projects",
                         "ns_per_particle_step", "bytes_per_particle"],
                    )
                ],
            )
        )  # fmt: skip
    blocks: list[Block] = []
    if len(t["column"]):
        blocks.append(
            Table(
                "0.1 s of the twisting column (nu 0.495, 6x31x6), CPU time on one thread; "
                "twist and pressure are in the study of the column.",
                t["column"],
                formats={"cpu_s": ".2f", "cpu_ms_per_particle": ".3f", "energy_kept": ".3f"},
            )
        )  # fmt: skip
    if len(t["plain"]):
        blocks.append(
            Table(
                "The paper's step ({p,F}, one thread) with numpy and scipy's sparse matrices.",
                t["plain"],
                formats={"ns_plain": ".0f", "ns_compiled": ".0f", "ratio": ".1f"},
            )
        )
    machine = t["machine"].assign(
        bandwidth=t["machine"]["bandwidth"] / 1e9, flops=t["machine"]["flops"] / 1e9
    )
    blocks.append(
        Table(
            "The machine: triad bandwidth [GB/s], multiply-adds in registers [Gflop/s].",
            machine,
            formats={"bandwidth": ".1f", "flops": ".1f"},
        )
    )
    sections += [
        Section("The column, plain numpy, the machine", blocks),
        what_was_run(results.run),
        what_failed(results.failures),
    ]
    return Document(
        title="What a step costs, and what the machine allows",
        subtitle=subtitle(results.run),
        abstract=_abstract(t["targets"]),
        sections=sections,
    )


def _abstract(found: pd.DataFrame) -> str:
    asked = found[~found["asked"].str.startswith("(")]
    missed = asked[~asked["met"].astype(bool)]["target"].tolist()
    text = f"{len(asked) - len(missed)} of {len(asked)} targets are met."
    return text + (" Not met: " + "; ".join(missed) + "." if missed else "")


def _passes(results: Results) -> list[Block]:
    table = results.tables["passes"]
    lattice = table[(table["particles"] == 33**3)].drop_duplicates(
        ["cloud", "weighting", "threads", "pass"]
    )
    if not len(table):
        return [Paragraph("No pass was timed.")]
    return [
        passes_figure(results),
        _table(
            "Each pass alone at 33^3, {p,F,J}: time, operations and compulsory traffic a particle.",
            lattice,
            ["cloud", "weighting", "threads", "pass", "ns_per_particle", "flops_per_particle",
             "traffic_per_particle", "roofline_share"],
        ),
    ]  # fmt: skip
