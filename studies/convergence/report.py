"""The document of the convergence study, made from its tables alone."""

from __future__ import annotations

from studies.convergence.figures import (
    formulations_figure,
    incompressible_figure,
    operators_figure,
    select,
)
from studies.convergence.verdicts import verdict_table
from studies.harness.front import Results
from studies.report.document import Bullets, Document, Figure, Paragraph, Section, Table
from studies.report.standard_sections import subtitle, what_failed, what_was_run

_SHORT = {
    "formulation": "formulation", "secondary": "sec.", "operator": "operator",
    "slope_p_last": "slope p", "slope_P_last": "slope P",
    "error_p_h16": "error p, 1/16", "error_P_h16": "error P, 1/16",
    "error_p_finest": "error p, finest", "error_P_finest": "error P, finest",
    "wall_s_finest": "wall s",
}  # fmt: skip
_FORMATS = {
    "xi_F": "g",
    "slope_p_last": ".2f", "slope_P_last": ".2f", "error_p_h16": ".2e", "error_P_h16": ".2e",
    "error_p_finest": ".2e", "error_P_finest": ".2e", "wall_s_finest": ".1f",
}  # fmt: skip


def _slopes_table(results: Results, scene: str, family: str, nu: float) -> Table:
    frame = select(results.tables["summary"], scene=scene, family=family, nu=nu)
    columns = [
        "method", "formulation", "secondary", "operator", "projection", "xi_F", "slope_p_last",
        "slope_P_last", "error_p_h16", "error_P_h16", "error_p_finest", "error_P_finest",
        "wall_s_finest",
    ]  # fmt: skip
    finest = frame["h_finest"].min() if len(frame) else float("nan")
    return Table(
        f"{scene}, {family}, nu = {nu:g}: slopes of the last refinement (the worst of the three "
        "momentum and of the nine stress components) and the largest component errors at "
        f"h = 1/16 and at the finest h (1/{1 / finest:.0f} at best); wall seconds of the finest "
        "run, set-up included, one thread beside other runs.",
        frame[columns],
        formats=_FORMATS,
        headings=_SHORT,
    )


def _classical_table(results: Results) -> Table:
    """Errors of {p,F} H1 at 17^3 (or the finest level below) in the linear limit, A+B+C=0."""
    part = select(results.tables["table"], scene="linear", family="A+B+C=0", nu=0.3)
    levels = part["h"][part["h"] >= 1.0 / 16.0]
    level = float(levels.min()) if len(levels) else float(part["h"].min())
    part = part[part["h"] == level]
    wanted = part[
        ((part["formulation"] == "{p,F}") & (part["secondary"] == "H1"))
        | (part["method"] != "SUPG-SPH")
    ]
    wide = wanted.assign(
        name=wanted["field"] + "_" + wanted["component"]
    ).pivot_table(
        index=["method", "operator", "projection", "xi_F"],
        columns="name",
        values="error",
        sort=False,
    )[["p_x", "p_z", "P_xx", "P_zz", "P_xy", "P_xz"]].reset_index()  # fmt: skip
    return Table(
        f"Errors at {1.0 / level + 1.0:.0f}^3 particles, linear limit, A+B+C=0, nu = 0.3, {{p,F}} "
        "SUPG-SPH-H1 and the classical methods.",
        wide,
        formats=dict.fromkeys(["p_x", "p_z", "P_xx", "P_zz", "P_xy", "P_xz"], ".2e")
        | {"xi_F": "g"},
    )


def report(results: Results) -> Document:
    """Figures ``convergence``, ``formulations``, ``incompressible`` and the document."""
    table = results.tables["table"]
    main = operators_figure(table, results.out / "convergence")
    formulations = formulations_figure(table, results.out / "formulations")
    near = incompressible_figure(table, results.out / "incompressible")
    settings = results.tables["summary"][["scene", "family", "nu"]].drop_duplicates()
    return Document(
        title="The swinging cube: order of convergence of SUPG-SPH and of B-bar FEM",
        subtitle=subtitle(results.run),
        abstract=(
            "The mixed total-Lagrangian SUPG-SPH method of Lee et al. (2017) is run on a standing "
            "wave with a known solution, in the linear limit and, with manufactured loads, at "
            "displacement gradients of 0.2. Taken literally, its equations do not converge at "
            "second order: near the boundary the force of a uniform stress is wrong by a fixed "
            "share. With a gradient changed as little as possible so that the discrete divergence "
            "theorem holds, momentum converges at second order and stress at nearly that, with "
            "force and gradient still adjoint. An explicit B-bar finite element on the same "
            "problem statement is the reference."
        ),
        sections=[
            Section(
                "The verdict",
                [verdict_table(results), _classical_table(results)],
            ),
            Section(
                "What is measured",
                [
                    Paragraph(
                        "Error of a component: root mean square over the 12 instants "
                        "(k + 1/2) T / 12 of one period of the L2 norm of the error, divided by a "
                        "fixed scale: for momentum the norm of the largest component's amplitude, "
                        "for stress mu pi U0 / sqrt(8). The same scale serves every component. A "
                        "single instant is no measure: fitted slopes jump with the phase error."
                    ),
                    Bullets(
                        [
                            "`linear`: amplitude 1e-7 m, exact for linear elasticity; "
                            "`manufactured`: largest principal displacement gradient 0.2, body "
                            "force and tractions that make the motion exact for the full "
                            "neo-Hookean solid.",
                            "`Literal`: eqs. (30) and (32) as printed. `Consistent` (default): "
                            "least change of the gradient that satisfies the divergence theorem, "
                            "used for strain and force, which stay adjoint. `Consistent(force)`: "
                            "in the force alone.",
                            "tau_F = dt; xi_F = 0, and for {p,F} H1 the paper's 0.1 beside it; "
                            "tau_p = 0.1 dt at nu = 0.499, else 0. CFL 0.3, Wendland C2, support "
                            "1.54 spacings. B-bar FEM: CFL 0.6, stress at centroids.",
                            "`projection`: local angular-momentum projection of the stresses.",
                        ]
                    ),
                ],
            ),
            Section(
                "By operator",
                [
                    Figure(
                        "Largest component error of {p,F} SUPG-SPH-H1 by operator, of "
                        "displacement SPH and of B-bar FEM. nu = 0.3.",
                        main,
                    )
                ],
            ),
            Section(
                "By formulation",
                [
                    Figure(
                        "Largest component error of every formulation and choice of secondary "
                        "points, Consistent operator, nu = 0.3. The three formulations differ by "
                        "less than a marker; H6 is dashed.",
                        formulations,
                    )
                ],
            ),
            Section(
                "Near incompressibility",
                [
                    Paragraph(
                        "The mixed formulations do not lock: momentum is as accurate as that of "
                        "the finite element. Their stress, dominated by a bulk modulus 500 times "
                        "the shear modulus, converges too but is the less accurate one. Without "
                        "stabilisation displacement SPH is lost: its undamped high modes grow, "
                        "and on finer grids there are more steps to grow in."
                    ),
                    Figure("nu = 0.499, linear limit, A+B+C=0.", near, width=0.8),
                ],
            ),
            Section(
                "All slopes and errors",
                [
                    _slopes_table(results, row.scene, row.family, row.nu)
                    for row in settings.itertuples()
                ],
            ),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )
