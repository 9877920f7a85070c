"""The document of the study of clouds, made from its tables alone."""

from __future__ import annotations

import pandas as pd

from studies.clouds.cases import RECOVERED
from studies.clouds.figures import disorder_figure, ledger_figure, orders_figure
from studies.clouds.tables import recovered, unvaried
from studies.clouds.verdicts import verdicts
from studies.convergence.figures import select
from studies.harness.front import Results
from studies.report.document import Block, Bullets, Document, Figure, Paragraph, Section, Table
from studies.report.standard_sections import subtitle, what_failed, what_was_run

_ERRORS = {
    **dict.fromkeys(["p_x", "P_xx", "error_p", "error_P"], ".2e"),
    **dict.fromkeys(["slope_p", "slope_P", "mean_slope_P"], ".2f"),
    "h": ".4f", "particles": ".0f",
}  # fmt: skip
_SHORT = {
    "formulation": "form.", "error_p": "worst p", "error_P": "worst P", "slope_p": "slope p",
    "slope_P": "slope P", "mean_slope_P": "slope |P|", "particles": "N",
}  # fmt: skip
_SET_UP_FORMATS = {
    "h": ".4f", "neighbours": ".1f", "change": ".2f", "setup_s": ".1f", "h_min_over_dx": ".2f",
    "step_ms": ".1f",
    **dict.fromkeys(["C0", "C1", "D0", "SBP", "volume", "linear_drift", "angular_drift"], ".1e"),
}  # fmt: skip
_SET_UP_SHORT = {
    "particles": "N", "neighbours": "neighb.", "iterations": "iter.", "setup_s": "set-up s",
    "linear_drift": "linear", "angular_drift": "angular", "step_ms": "step ms",
}  # fmt: skip


def _verdict_table(results: Results) -> Table:
    frame = pd.DataFrame(
        list(verdicts(results.tables)),
        columns=["what", "where", "measured", "asked", "verdict"],
    )
    for column in ("measured", "asked"):
        frame[column] = [
            "–" if value != value else (f"{value:.2f}" if value > 0.05 else f"{value:.2e}")
            for value in frame[column]
        ]
    return Table(
        "What was asked and what was measured. Slopes: the worst component, last refinement of "
        "SummationByParts; errors at h = 1/16 (files: the level nearest to it).",
        frame,
    )


def _levels_table(levels: pd.DataFrame, scene: str, family: str) -> Table:
    frame = select(levels, scene=scene, family=family)
    columns = [
        "cloud", "operator", "formulation", "h", "particles", "p_x", "P_xx", "error_p", "error_P",
        "slope_p", "slope_P", "mean_slope_P",
    ]  # fmt: skip
    return Table(
        f"{scene}, {family}: errors at every level, slopes from the level before (worst component; "
        "`slope |P|`: root mean square of all stress components).",
        frame[columns], formats=_ERRORS, headings=_SHORT,
    )  # fmt: skip


def _cube_sections(results: Results, levels: pd.DataFrame) -> list[Section]:
    figures: list[Block] = []
    for scene in ("linear", "manufactured"):
        for formulation in dict.fromkeys(levels["formulation"]):
            stem = results.out / (
                f"orders_{scene}_" + str(formulation).strip("{}").replace(",", "")
            )
            figures.append(
                Figure(
                    f"Largest component error over spacing by operator, {scene}, A+B+C=0, "
                    f"{formulation}.",
                    orders_figure(levels, scene, str(formulation), stem),
                )
            )
    if levels["cloud"].isin(["lattice"]).any() and (levels["h"] == 1.0 / 16.0).any():
        figures.append(
            Figure(
                "Disorder: error at 17^3 over the largest displacement of a particle.",
                disorder_figure(levels, results.out / "disorder"),
                width=0.8,
            )
        )
    settings = levels[["scene", "family"]].drop_duplicates()
    return [
        Section("Error over spacing", figures),
        Section(
            "Errors and slopes",
            [_levels_table(levels, row.scene, row.family) for row in settings.itertuples()],
        ),
    ]


def _set_up(results: Results) -> Section:
    frame = unvaried(results.tables["setup"])
    columns = [
        "cloud", "operator", "h", "particles", "secondary", "neighbours", "least_neighbours",
        "h_min_over_dx", "change", "iterations", "C0", "C1", "D0", "SBP", "setup_s",
    ]  # fmt: skip
    return Section(
        "Set-up",
        [
            Table(
                "Residuals, size of the change relative to the printed gradient, iterations of "
                "the solver, wall seconds of the set-up (one thread beside other runs on a shared "
                "machine; an operator of 4000 particles or more that an earlier run had left on "
                "the disk is read from there).",
                frame[columns],
                formats=_SET_UP_FORMATS,
                headings=_SET_UP_SHORT
                | {"least_neighbours": "least", "h_min_over_dx": "hmin/dx", "secondary": "sec."},
            )
        ],
    )


def _recovered_section(levels: pd.DataFrame, fits: pd.DataFrame) -> Section:
    """The stress of the particles beside the one recovered from it."""
    keys = ["cloud", "operator", "formulation", "scene", "family", "h"]
    stress = ["P_xx", "error_P", "slope_P", "mean_slope_P"]
    both = fits[[*keys, *stress]].merge(
        unvaried(levels)[[*keys, *stress]], on=keys, suffixes=(" rec.", "")
    )
    both = both[(both["formulation"] == "{p,F}") & (both["operator"] != "Literal")]
    columns = [
        "cloud", "operator", "scene", "h", "P_xx", "P_xx rec.", "error_P", "error_P rec.",
        "slope_P", "slope_P rec.",
    ]  # fmt: skip
    formats = {f"{name} rec.": _ERRORS[name] for name in stress if name in _ERRORS}
    return Section(
        "Recovered stress",
        [
            Table(
                "Stress of the particles, and recovered from it (rec.): the value of the quadratic "
                "fitted to the stresses within 3.5 spacings. {p,F}.",
                both[columns],
                formats=_ERRORS | formats,
                headings=_SHORT | {"error_P rec.": "worst P rec.", "slope_P rec.": "slope P rec."},
            )
        ],
    )


def _other_sections(results: Results) -> list[Section]:
    tables, sections = results.tables, []
    levels = tables["levels"]
    fits = recovered(levels)
    if len(fits):
        sections.append(_recovered_section(levels, fits))
    variants = levels.drop(unvaried(levels).index).drop(fits.index)
    if len(variants):
        set_up = tables["setup"][["variant", "h", "neighbours", "change", "iterations", "setup_s"]]
        made = variants["variant"].str.removesuffix(f", {RECOVERED}")
        frame = variants.assign(made=made).merge(
            set_up.rename(columns={"variant": "made"}), on=["made", "h"], how="left"
        )
        columns = [
            "variant", "h", "p_x", "P_xx", "error_p", "error_P", "slope_p", "slope_P",
            "mean_slope_P", "neighbours", "change", "iterations", "setup_s",
        ]  # fmt: skip
        sections.append(
            Section(
                "Why",
                [
                    Table(
                        "One choice inside SummationByParts changed at a time: jitter 0.4, linear "
                        "limit, {p,F}. Defaults: epsilon 0.02, tolerance 0.001, h/dx 1, an "
                        "equilibrated start. A large epsilon leaves exactness on quadratics out.",
                        frame[columns],
                        formats=_ERRORS | _SET_UP_FORMATS,
                        headings=_SHORT | _SET_UP_SHORT,
                    )
                ],
            )
        )
    if len(tables["conservation"]):
        columns = [
            "shape", "cloud", "operator", "outcome", "particles", "neighbours", "linear_drift",
            "angular_drift", "D0", "SBP", "change", "iterations", "setup_s", "step_ms",
        ]  # fmt: skip
        sections.append(
            Section(
                "Other shapes",
                [
                    Table(
                        "Free bodies, {p,F}, package defaults, 60 steps: drift of linear and "
                        "angular momentum over their scales, residuals, effort.",
                        tables["conservation"][columns],
                        formats=_SET_UP_FORMATS,
                        headings=_SET_UP_SHORT,
                    )
                ],
            )
        )
    if len(tables["spectrum"]):
        sections.append(
            Section(
                "Stability",
                [
                    Table(
                        "Spectrum of one step of a free cube of 125 particles at rest, {p,F}, nu "
                        "= 0.3, package defaults: largest CFL numbers without growth (strict), "
                        "with less than tenfold growth in 1000 steps (slow) and in 50 (fast); 1.6 "
                        "is the largest tried. Decades: growth over 1000 steps at CFL 0.7. A CFL "
                        "number counts the least distance of neighbours, hmin.",
                        tables["spectrum"].drop(columns="refused"),
                        formats={"h": ".4f", "h_min_over_dx": ".3f", "decades_at_default": ".2g",
                                 "strict": ".3f", "slow": ".3f", "fast": ".3f"},
                        headings={"h_min_over_dx": "hmin/dx", "decades_at_default": "decades"},
                    )
                ],
            )
        )  # fmt: skip
    if len(tables["ledger"]):
        sections.append(
            Section(
                "Energy account",
                [
                    Paragraph(
                        "The manufactured cube over a quarter of a period, SummationByParts, no "
                        "stabilisation and no projection: what the account of energy leaves over "
                        "is the time integrator's, and falls with the step accordingly."
                    ),
                    Figure("Largest rest over the largest energy.",
                           ledger_figure(tables["ledger"], results.out / "ledger"), width=0.6),
                    Table("The same as numbers.", tables["ledger"],
                          formats={"h": ".4f", "dt": ".2e", "rest": ".2e", "slope": ".2f",
                                   "dt_over_stable": ".2f"}),
                ],
            )
        )  # fmt: skip
    return sections


def report(results: Results) -> Document:
    """All figures and the document."""
    levels = unvaried(results.tables["levels"])
    lost = results.tables["lost"]
    return Document(
        title="Operators on clouds of every kind",
        subtitle=subtitle(results.run),
        abstract=(
            "The printed equations of Lee et al. (2017), their least change that satisfies the "
            "divergence theorem, and a pair of operators that sums by parts, on lattices, "
            "disordered particles, unstructured tetrahedra and hexahedra: order of convergence "
            "of the swinging cube in the linear limit and at displacement gradients of 0.2."
        ),
        sections=[
            Section(
                "The verdict",
                [
                    _verdict_table(results),
                    Bullets(
                        [
                            "`jitter J` moves every particle by at most J/2 of the spacing along "
                            "each axis: jitter 0.2 is a disorder of +-10 %, jitter 0.4 of +-20 %.",
                            "Package defaults but for the operator: position Verlet, self-adjoint "
                            "SUPG, support by cloud, H1 on hexahedra and agglomerated secondary "
                            "particles on tetrahedra and points.",
                            "The norm is that of the convergence study: root mean square over "
                            "twelve instants of a period, one scale for all components.",
                            "Of mesh files finer levels are uniform refinements; h is the edge of "
                            "the cube that a cell stands for.",
                        ]
                    ),
                ],
            ),
            *(_cube_sections(results, levels) if len(levels) else []),
            *_other_sections(results),
            _set_up(results),
            *([Section("Lost", [Table("Diverged or folded.", lost)])] if len(lost) else []),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )
