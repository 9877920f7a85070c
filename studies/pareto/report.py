"""The document of the study, made from its tables alone."""

from __future__ import annotations

import pandas as pd

from studies.convergence.figures import select
from studies.harness.front import Results
from studies.pareto.choice import ENERGY_MADE, SAME_COST, WITHIN
from studies.pareto.figures import figures
from studies.pareto.iso_error import FARTHEST
from studies.pareto.methods import COMPARED
from studies.pareto.scenes import MEASURES, RATIOS, SCENES
from studies.pareto.verdicts import CERTAIN, sentence, sentence_by_scene
from studies.report.document import Bullets, Document, Figure, Section, Table
from studies.report.standard_sections import subtitle, what_failed, what_was_run

_NAMES = {
    "asked": "error", "measure": "of", "how": "how", "cpu_s_per_s": "CPU s / s", "bytes": "memory",
    "reference_share": "ref.", "sph": "cheapest SPH", "fem": "cheapest FEM",
    "sph_cpu_s_per_s": "CPU s / s", "fem_cpu_s_per_s": "CPU s / s ", "cpu_ratio": "CPU ratio",
    "bytes_ratio": "bytes ratio", "particles_ratio": "particles ratio",
    "ns_per_particle_step": "ns / step", "bytes_per_particle": "B / particle",
    "step_cpu_spread": "spread", "setup_cpu_s": "set-up s", "energy_kept": "E/E0",
    "error_ratio": "error / best", "stabilisation": "stabil.", "stress_size": "size",
    "evaluations": "evals", "uncertainty [rad]": "uncertainty [rad]",
}  # fmt: skip
_FORMATS = {
    "asked": ".0%", "nu": "g", "particles": ".0f", "cpu_s_per_s": ".3g", "bytes": ".3g",
    "reference_share": ".2f", "sph_cpu_s_per_s": ".3g", "fem_cpu_s_per_s": ".3g",
    "cpu_ratio": ".2f", "bytes_ratio": ".2f", "particles_ratio": ".2f", "momentum": ".2e",
    "stress": ".2e", "twist_rms": ".2e", "twist_end": ".2e", "energy": ".2e",
    "energy_kept": ".4f", "ns_per_particle_step": ".0f", "bytes_per_particle": ".0f",
    "step_cpu_spread": ".0%", "setup_cpu_s": ".2f", "error_ratio": ".2f", "stress_size": ".2f",
    "evaluations": ".0f", "twist [rad]": ".4f", "uncertainty [rad]": ".4f", "time [s]": ".2f",
}  # fmt: skip


def _table(caption: str, frame: pd.DataFrame) -> Table:
    return Table(caption, frame, formats=_FORMATS, headings=_NAMES)


def _iso(results: Results, scene: str, nu: float) -> Table:
    frame = select(results.tables["iso_error"], scene=scene, nu=nu)
    frame = frame[["measure", "asked", "method", "how", "particles", "cpu_s_per_s", "bytes",
                   "reference_share"]]  # fmt: skip
    return _table(
        f"{scene}, nu = {nu:g}: what an error costs: particles or nodes, CPU seconds per physical "
        "second on one thread, bytes; ref.: uncertainty of the reference over the error.",
        frame[frame["how"] != "not reached"],
    )


def _runs(results: Results, scene: str, nu: float) -> Table:
    frame = select(results.tables["table"], scene=scene, nu=nu)
    frame = frame[frame["method"].isin([method.label for method in COMPARED])]
    size = ["stress_size"] if scene == "cube" else ["energy_kept"]
    columns = ["method", "particles", "steps", "evaluations", *MEASURES[scene], *size,
               "cpu_s_per_s", "step_cpu_spread", "ns_per_particle_step", "bytes_per_particle",
               "setup_cpu_s", "survived"]  # fmt: skip
    return _table(f"{scene}, nu = {nu:g}: every run.", frame[columns])


def _reference(results: Results) -> Table:
    frame = results.tables["reference"]
    at = frame[((50.0 * frame["time [s]"]).round(6) % 1.0 == 0.0) & (frame["time [s]"] > 0.0)]
    return _table("Reference of the column: mean of the limits and its uncertainty.", at)


def lower_first(text: str) -> str:
    """A sentence that goes on after a colon."""
    return text[0].lower() + text[1:]


def report(results: Results) -> Document:
    """Five figures and the document."""
    drawn = figures(results.tables["table"], results.out)
    ratios = results.tables["ratios"]
    verdict = sentence(ratios)
    return Document(
        title="Error against cost: SPH and finite elements",
        subtitle=subtitle(results.run),
        abstract=(
            "The swinging cube (manufactured, displacement gradients of 0.2) and the twisting "
            "column, at nu = 0.3 and 0.495, with every formulation and stabilisation of the "
            f"particles and with finite elements, on several lattices. {verdict} With stabilised "
            f"particles alone: {lower_first(sentence(results.tables['ratios_stabilised']))}"
        ),
        sections=[
            Section(
                "The verdict",
                [
                    _table("SPH against FEM, scene by scene.", sentence_by_scene(ratios)),
                    Figure(
                        "Error against CPU seconds per physical second, one thread. Colour: family "
                        "of the method; dotted: errors of 10, 3 and 1 %.",
                        drawn["pareto"],
                    ),
                    _table(
                        "At equal error: the cheapest SPH, the cheapest FEM, and SPH over FEM in "
                        "CPU time, memory and particles. A method whose coarsest lattice is "
                        "enough costs at most that lattice, so such a ratio is a bound.",
                        ratios,
                    ),
                ],
            ),
            Section("What is measured", [_what_is_measured()]),
            Section(
                "What to use",
                [
                    _table(
                        "The cheapest formulation and stabilisation whose error at equal particles "
                        f"is within {WITHIN:.0%} of the best (`all`: in both scenes); its error "
                        "over the best one's, and its cost over that of the most accurate.",
                        results.tables["recommendation"],
                    ),
                    _table(
                        "Formulation x stabilisation x projection on the cube: error, CPU "
                        "nanoseconds a particle-step (all stages), CPU seconds per physical "
                        "second, bytes.",
                        results.tables["options"],
                    ),
                ],
            ),
            Section(
                "Cube and column",
                [
                    Figure("The cube: CPU time.", drawn["cube_time"]),
                    Figure("The cube: memory.", drawn["cube_memory"]),
                    Figure("The column: CPU time.", drawn["column_time"]),
                    Figure("The column: memory.", drawn["column_memory"]),
                    _reference(results),
                ],
            ),
            Section("Equal error", [_iso(results, s, nu) for s in SCENES for nu in RATIOS]),
            Section("All runs", [_runs(results, s, nu) for s in SCENES for nu in RATIOS]),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )


def _what_is_measured() -> Bullets:
    return Bullets(
        [
            "CPU seconds: `process_time` of a window of steps on one thread, least of repeats, "
            "times the steps of the run, over its physical time; spread is the largest repeat over "
            "the least, less one. No compilation, no set-up (a column of its own), and no loads: "
            "the manufactured loads of the cube are formulas of the study, cost more than a step, "
            "and are the same for all methods. Cases run one at a time.",
            "On the smallest lattices (a few hundred particles) a step is mostly the interpreter's "
            "time to launch kernels, not theirs: `ns / step` shows it.",
            "Memory: bytes of all arrays reachable from the simulation, counted by one rule.",
            "Cube: largest component error of momentum and of stress in the norm of "
            "`studies.convergence`, family A+B+C=0. Its stress scale is that of shear; `size` is "
            "the exact stress in the same units, far above one near incompressibility.",
            "Column: distance of the twist of the top from the reference, root mean square over "
            "the records over the largest twist, and at 0.1 s; energy: share of the energy at the "
            "start that is lost or made by 0.1 s.",
            "Reference of the column: the finest B-bar elements and the finest particles are each "
            "carried on to no spacing with order two, and the mean is taken, so that neither is "
            "favoured; its uncertainty is half their distance, or how far the limits move without "
            "their finest lattice. No comparison is made where it exceeds "
            f"{CERTAIN:.0%} of the error asked for.",
            "Equal error: straight lines in the logarithms between lattices; a lattice counts with "
            "the largest error of it and all finer ones, since a zero crossing is luck; at most a "
            f"factor {FARTHEST:g} in the error beyond the finest lattice.",
            "SPH: the package's defaults (Consistent operator, position Verlet, self-adjoint "
            "weighting, local projection); `RK3` rows: SSP-RK3 at CFL 0.5; `RK2` "
            "rows: TVD-RK2 at CFL 0.3 with tau_F of a step, the paper's. No method is tuned.",
            f"What to use: CPU times within {SAME_COST:.0%} count as equal, and the one that holds "
            f"less memory is taken; a method that made more than {ENERGY_MADE:.0%} energy or was "
            "lost is no choice. Only particles are candidates.",
        ]
    )
