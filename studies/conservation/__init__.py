"""What is kept: momenta and energy of the L-shaped block and of the spinning cube.

``python -m studies.conservation`` runs the second example of [Lee2017] section 8.1 (Figs. 6 to 8: a
free block kicked by two opposite tractions) in the paper's setting with every formulation, H1 and
H6, the operator as printed and the consistent one, with the package default, self-adjoint SUPG and
B-bar finite elements on the same disordered mesh; and a spinning cube whose momentum is known,
where the energy budget must close but for the time integrator. The package default also moves free
bodies of other shapes and cells.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

import sphsolid as sph
from sphsolid.cloud.secondary import SecondaryPoints
from sphsolid.defaults import (
    default_cfl,
    default_integrator,
    default_supg,
    poisson_ratio,
)
from sphsolid.errors import require
from sphsolid.recommendation import recommend_supg
from sphsolid.scenes import Scene, l_shaped_block, spinning_cube
from sphsolid.scenes.l_shaped_block import PUBLISHED_SPACING
from sphsolid.scheme.formulation import Formulation
from studies.conservation import claims as judged
from studies.conservation.figures import FIGURES, PICTURES
from studies.conservation.runs import (
    BODIES,
    DISORDER,
    END,
    LOAD_ENDS,
    MADE_BY_TIME,
    SLOW_SPIN,
    SPIN,
    Block,
    Body,
    Cube,
    run_block,
    run_body,
    run_cube,
)
from studies.engine.study import Case, Row, Study, Tables
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE, PAPER, SUPG, Method, said
from studies.pictures.picture import keeping

FORMULATIONS: tuple[Formulation, ...] = (sph.PF(), sph.PFJ(), sph.PFHJ())
H1, H6, LITERAL, CONSISTENT = sph.H1(), sph.H6(), sph.Literal(), sph.Consistent()
OPERATORS = (LITERAL, CONSISTENT)
#: Nominal spacings [m] of the block: 425 particles, nearest to the published 388, and 1323.
SPACINGS = (PUBLISHED_SPACING, 0.5)
#: Smoothing length over spacing, which is not published; the least that there is on a lattice.
H_OVER_DX, SMALL = 0.9, 0.77
CFLS = (0.3, 0.15, 0.075)
USUAL_CFL = default_cfl(default_integrator())


def paper(
    secondary: SecondaryPoints = H6,
    operator: sph.Literal | sph.Consistent = LITERAL,
    formulation: Formulation = FORMULATIONS[0],
) -> Method:
    """The setting of [Lee2017] Figs. 7 and 8 by its own terms."""
    return PAPER.but(
        name=f"paper, {formulation.name}, {secondary.name}, {operator.name}",
        formulation=formulation, secondary=secondary, operator=operator, h_over_dx=H_OVER_DX,
    )  # fmt: skip


def package(scene: Scene, formulation: Formulation) -> Method:
    """Self-adjoint SUPG, with another formulation where it would not choose this one."""
    mine = formulation == recommend_supg(scene).formulation
    return SUPG if mine else SUPG.but(formulation=formulation)


def bare(method: Method) -> Method:
    """Without the projection of the stresses."""
    return method.but(
        name=f"{method.name}, no projection", angular_momentum=sph.NoProjection()
    )


def changes(usual: Method) -> Iterator[Method]:
    """What is changed, one at a time, to see which choices the block survives."""
    for more in (
        {"cfl": 0.6}, {"cfl": 0.9}, {"h_over_dx": SMALL}, {"h_over_dx": 1.0}, {"h_over_dx": 1.2},
        {"xi_F": 0.1}, {"tau_F": sph.OfStep(0.1)}, {"integrator": sph.SSPRK3()},
        {"integrator": sph.PositionVerlet()}, {"weighting": sph.SelfAdjoint()},
        {"formulation": sph.PFJ(), "tau_p": sph.OfStep(0.1)},
    ):  # fmt: skip
        yield usual.but(**more)
    yield usual.but(name=f"{usual.name}, unstabilised", stabilisation=sph.NoStabilisation())


def blocks() -> Iterator[Block]:
    """Every run of the L-shaped block."""
    for spacing in SPACINGS:
        yield Block("elements", B_BAR, spacing, pictured=True)
        yield Block("default", PACKAGE, spacing, pictured=True)
        for formulation in FORMULATIONS:
            for operator in OPERATORS:
                for secondary in (H1, H6):
                    method = paper(secondary, operator, formulation)
                    pictured = (formulation, secondary) == (FORMULATIONS[0], H6)
                    yield Block("paper", method, spacing, pictured=pictured)
                    if spacing == PUBLISHED_SPACING:
                        yield Block("no projection", bare(method), spacing)
            method = package(l_shaped_block(), formulation)
            yield Block("package", method, spacing, pictured=method is SUPG)
    for operator in OPERATORS:
        usual = paper(operator=operator)
        yield Block("small load", usual, load=1e-3, until=LOAD_ENDS)
        for changed in changes(usual):
            yield Block("changed", changed)
    for method in (paper(), paper(operator=CONSISTENT), B_BAR, PACKAGE, SUPG):
        yield Block("long", method, until=60.0)
        for jitter in (0.0, 0.4) if method is not SUPG else ():
            yield Block("disorder", method, jitter=jitter)


def by_default(share: float, spacing: float = 0.25) -> Cube:
    """The cube by the package default with a ``share`` of the usual step.

    Its fastest waves are not damped.  At the usual step they make the largest residual, which then
    is not yet in the range of its order in the step: orders are those of the smaller steps.
    """
    group = "usual default" if share == 1.0 else "default"
    return Cube(group, PACKAGE, spacing, share * USUAL_CFL)


def cubes() -> Iterator[Cube]:
    """Every run of the spinning cube."""
    usual, printed = paper(H1, CONSISTENT), paper(H1)
    integrators = [usual.but(integrator=one) for one in (sph.SSPRK3(), sph.PositionVerlet())]
    others = [
        *(paper(H1, CONSISTENT, formulation) for formulation in FORMULATIONS[1:]),
        paper(H6, CONSISTENT), printed, usual.but(weighting=sph.SelfAdjoint()), *integrators,
    ]  # fmt: skip
    for cfl in CFLS:
        for spacing in (0.25, 0.125):
            yield Cube("ladder", usual, spacing, cfl)
            yield Cube("elements", B_BAR, spacing, 2.0 * cfl)
        for method in others:
            yield Cube("methods", method, cfl=cfl)
    yield Cube("ladder", usual, 0.0625, CFLS[0])
    for formulation in FORMULATIONS:
        method = package(spinning_cube(), formulation)
        for share in (1.0, 0.5, 0.25):
            yield Cube("package", method, cfl=share * USUAL_CFL)
        if formulation != FORMULATIONS[2]:
            yield Cube("slow", method, cfl=USUAL_CFL, spin=SLOW_SPIN)
    for share in (1.0, 0.5, 0.25, 0.125):
        yield by_default(share)
    yield Cube("slow default", PACKAGE, cfl=USUAL_CFL, spin=SLOW_SPIN)
    yield by_default(1.0, 0.125)
    yield Cube("package", SUPG, 0.125, USUAL_CFL)
    for method in (printed, usual):
        yield Cube("no projection", bare(method), cfl=CFLS[0])
    for h in (SMALL, 0.85, 1.0, 1.2):
        yield Cube("support", usual.but(h_over_dx=h), cfl=CFLS[0])
    yield Cube("support", usual.but(h_over_dx=SMALL), cfl=CFLS[1])
    for method in integrators:
        yield Cube("support", method.but(h_over_dx=SMALL), cfl=CFLS[0])
    for method in (usual, printed, usual.but(h_over_dx=1.0), *integrators):
        yield Cube("slow", method, cfl=CFLS[0], spin=SLOW_SPIN)
    yield Cube("slow", usual, cfl=CFLS[1], spin=SLOW_SPIN)


def bodies() -> Iterator[Body]:
    """Free bodies of every shape and kind of cells, by the package default."""
    for shape, cloud in BODIES:
        yield Body("default", PACKAGE, shape, cloud)


def few() -> Iterator[Block | Cube | Body]:
    """The short form, a cross of the whole study."""
    for operator in OPERATORS:
        usual = paper(operator=operator)
        yield Block("paper", usual, pictured=True)
        yield Block("no projection", bare(usual))
        yield Block("small load", usual, load=1e-3, until=LOAD_ENDS)
    yield Block("paper", paper(H1, formulation=sph.PFHJ()))
    yield Block("elements", B_BAR, pictured=True)
    yield Block("package", SUPG, pictured=True)
    yield Block("default", PACKAGE, pictured=True)
    for share in (1.0, 0.5):
        yield Cube("package", SUPG, cfl=share * USUAL_CFL)
        yield by_default(0.5 * share)
    yield by_default(1.0)
    # The set-ups of the plates take as long as the short form may.
    yield from (body for body in bodies() if "plate" not in body.shape)
    for cfl in CFLS[:2]:
        yield Cube("ladder", paper(H1, CONSISTENT), cfl=cfl)
        yield Cube("elements", B_BAR, cfl=2.0 * cfl)
    yield Cube("support", paper(H1, CONSISTENT).but(h_over_dx=SMALL), cfl=CFLS[0])


def tiny() -> Iterator[Block | Cube | Body]:
    """Runs of a second or two that compile every kernel of the study."""
    full = paper(H6, CONSISTENT, sph.PFHJ()).but(tau_p=sph.OfStep(0.1))
    yield Block("paper", full, 1.5, until=0.5)
    for method in (paper(H6, CONSISTENT), B_BAR, PACKAGE, SUPG):
        yield Block("elements" if method is B_BAR else "paper", method, 1.5, until=6.0)
    usual = paper(H1, CONSISTENT)
    for method in (usual, usual.but(integrator=sph.SSPRK3()), B_BAR, PACKAGE, SUPG):
        yield Cube("ladder", method, 0.5, turns=0.25)
    yield Body("default", PACKAGE, *BODIES[0])


def case_of(one: Block | Cube | Body, out: Path) -> Case:
    """The case of a run; its cost is a guess of its seconds."""
    name = one.method.name
    if isinstance(one, Body):
        return Case(one.key, run_body, {"body": one}, 2.0)
    weight = 2.0 if "H6" in name else 0.3 if one.method in (B_BAR, PACKAGE) else 1.0
    if isinstance(one, Block):
        cost = weight * one.until / END * (0.9 / one.spacing) ** 4
        given = {"block": one, "shots": (out / "shots").as_posix()}
        return Case(one.key, run_block, given, cost)
    steps = one.turns / one.spin / one.spacing / one.cfl
    cost = 0.002 * weight * steps * (1.0 + 1.0 / one.spacing) ** 3
    kept = one.group in ("ladder", "elements", "support", "slow")
    return Case(one.key, run_cube, {"cube": one, "keep_history": kept}, cost)


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """All runs, or a cross of them."""
    runs: list[Block | Cube | Body] = [*few()]
    if not options.quick:
        runs = [*blocks(), *cubes(), *bodies()]
    return [case_of(one, options.out) for one in runs]


#: Tables made of rows: of the block and the cube a row a run, and of each a row a record.
KINDS = ("table", "cube", "bodies", "history", "cube_history")


def tables(rows: list[Row]) -> Tables:
    """``table``: a row a run of the block; ``cube``; their histories; ``bodies``; ``orders``."""
    made = {kind: pd.DataFrame([row for row in rows if row["of"] == kind]) for kind in KINDS}
    for kind, table in made.items():
        require(len(table) > 0, f"studies.conservation: no case finished that gives {kind}.csv")
    made = {kind: table.drop(columns="of") for kind, table in made.items()}
    return made | {"orders": judged.orders(made["cube"])}


def words(tables: Tables) -> Mapping[str, Any]:
    """Constants of the scenes, and the parts of the tables that are printed."""
    table, cube = tables["table"], tables["cube"]
    scene = l_shaped_block()
    chosen = default_supg(recommend_supg(scene).formulation, scene.material)
    # What the figures show: {p,F}, H6 of the paper's.
    in_package = table["group"].isin(["package", "default"])
    elements = table["method"].eq(B_BAR.name)
    projected = table["group"].isin(["paper", "package", "default"])
    mixed = table["formulation"].eq("{p,F}") & (table["secondary"].eq("H6") | in_package)
    particles = mixed | table["method"].eq(PACKAGE.name)
    shown = table[particles | elements].copy()
    for axis, value in zip("xyz", judged.undeformed_impulse(), strict=True):
        shown[axis] = shown[f"L_{axis}"] / (value * shown["load"])
    of_verlet = select(tables["orders"], integrator=default_integrator().name)
    nu, spinning = poisson_ratio(scene.material), spinning_cube()
    ladder = select(cube, group="ladder", cfl=CFLS[0])
    of_default = cube[cube["group"].isin(["usual default", "default"])]
    mine = cube[cube["method"] != B_BAR.name]
    usual = ["paper", "elements", "package", "default"]
    changed = table[table["group"].isin(["changed", "long"])]
    return {
        "scene": scene, "nu": nu, "E": 2.0 * scene.material.mu * (1.0 + nu), "chosen": chosen,
        "tau_F": said(chosen.tau_F), "integrator": default_integrator(), "cfl": USUAL_CFL,
        "cfls": CFLS, "h_over_dx": H_OVER_DX, "end": END, "disorder": DISORDER, "claim": judged,
        "made_by_time": MADE_BY_TIME, "spin": SPIN, "small": SMALL,
        "exact_L": spinning.material.density * SPIN / 6.0,
        "pictured": set(tables["history"]["spacing"]),
        "estimate": judged.undeformed_impulse(),
        "projected": table[projected], "default": PACKAGE.name,
        "bare": select(table, group="no projection"),
        "arms": shown[shown["group"].isin([*usual, "small load"])],
        "pressures": shown[shown["group"].isin([*usual, "disorder"])]
        .sort_values(["spacing", "jitter"], ascending=[False, True], kind="stable"),
        "energies": table[table["group"].isin(usual)],
        "changed": changed, "changed_kept": int((changed["outcome"] == "kept").sum()),
        "sizes": select(table, group="elements").set_index("spacing")["particles"],
        "ladder": ladder.sort_values("spacing", ascending=False).to_dict("records"),
        "fitted": select(tables["orders"], group="ladder")["order"],
        "mine": mine, "grown": mine[mine["outcome"] != "kept"],
        "usual": select(cube, group="package", method=SUPG.name).to_dict("records"),
        "by_default": of_default.to_dict("records"),
        "verlet": of_verlet[of_verlet["method"] != PACKAGE.name]["order"],
    }  # fmt: skip


STUDY = Study(
    name="conservation",
    cases=cases,
    tables=tables,
    claims=judged.claims,
    figures=FIGURES,
    keep=keeping(PICTURES),
    words=words,
    text=Path(__file__).with_name("report.md"),
    warm_up=lambda options: [case_of(one, options.out) for one in tiny()],
    description="Momenta and energy of the L-shaped block and of the spinning cube.",
)
