"""What both scenes of the conservation study share: solvers, runs that may end early, measures."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import fem_reference as fem
import sphsolid as sph
from sphsolid.defaults import Integrator, default_cfl
from sphsolid.errors import Diverged
from sphsolid.record.recorders import AXES, Recorder
from sphsolid.scenes import Scene
from sphsolid.scheme.stabilisation import Stabilisation, Weighting
from studies.convergence.cases import FORMULATIONS, OPERATORS, PROJECTIONS, SECONDARY, TIMES
from studies.harness.cases import Row
from studies.report.folding import folding

Array = NDArray[np.float64]
#: Share of the energy beyond which the time integrator, not the method, decides a run.
MADE_BY_TIME = 1.0e-2
#: Method of runs that leave all but spacing and formulation to the package.
DEFAULTS = "package defaults"
#: The paper's two stages; three, which damp what two let grow; one that keeps a shadow energy.
INTEGRATORS: dict[str, Integrator] = {
    "TVD-RK2": sph.TVDRK2(),
    "SSP-RK3": sph.SSPRK3(),
    "position Verlet": sph.PositionVerlet(),
}
WEIGHTINGS: dict[str, Weighting] = {
    "as printed": sph.AsPrinted(),
    "self-adjoint": sph.SelfAdjoint(),
}


def solver(
    scene: Scene,
    *,
    method: str,
    formulation: str,
    secondary: str,
    operator: str,
    projection: str,
    spacing: float,
    h_over_dx: float,
    cfl: float,
    tau_F: float,
    tau_unit: str,
    xi_F: float,
    tau_p: float,
    weighting: str,
    integrator: str,
) -> Any:
    """Either solver of a scene; options that a method does not have are ignored.

    Method ``package defaults`` gives nothing but spacing and formulation, and ``cfl`` if positive.
    """
    if method == "B-bar FEM":
        return fem.Simulation(scene, spacing=spacing, cfl=cfl)
    if method == DEFAULTS:
        given = cfl if cfl > 0.0 else None
        return sph.Simulation(
            scene, spacing=spacing, formulation=FORMULATIONS[formulation](), cfl=given
        )
    stabilisation: Stabilisation = sph.NoStabilisation()
    if secondary in SECONDARY:
        stabilisation = sph.SUPG(
            tau_F=TIMES[tau_unit](tau_F), xi_F=xi_F, tau_p=tau_p, secondary=SECONDARY[secondary],
            weighting=WEIGHTINGS[weighting],
        )  # fmt: skip
    return sph.Simulation(
        scene,
        spacing=spacing,
        formulation=FORMULATIONS[formulation](),
        stabilisation=stabilisation,
        operator=OPERATORS[operator],
        h_over_dx=h_over_dx,
        cfl=cfl,
        angular_momentum=PROJECTIONS[projection],
        integrator=INTEGRATORS[integrator],
    )


def chosen(sim: Any, options: Row) -> Row:
    """``options`` with what the package chose in the place of what was left to it."""
    if options["method"] != DEFAULTS:
        return options
    supg = sim.stabilisation
    tau_F = supg.intrinsic_times["tau_F"]
    return options | {
        "secondary": supg.secondary.name,
        "operator": sim.operator.name,
        "integrator": sim.integrator.name,
        "h_over_dx": sim.h_over_dx,
        "cfl": options["cfl"] or default_cfl(sim.integrator),
        "tau_F": tau_F.c,
        "tau_unit": tau_F.unit,
        "xi_F": supg.xi_F,
        "weighting": "self-adjoint" if supg.is_self_adjoint else "as printed",
        "tau_p": supg.intrinsic_times["tau_p"].c,
    }


def march(
    sim: Any, *, until: float, every: float, record: Sequence[Recorder]
) -> tuple[pd.DataFrame, Diverged | None]:
    """The history to ``until`` [s], or to where the solution was lost, and how it was."""
    try:
        return sim.run(until=until, every=every, record=record).table, None
    except Diverged as failure:
        return failure.history.table, failure  # type: ignore[attr-defined]


def outcome(sim: Any, failure: Diverged | None, rest: float, started: float) -> Row:
    """How a run ended.

    ``outcome``: ``lost``; ``folded``, the positions, at any time; by ``rest``, the share of the
    energy that is left over at the end (:func:`left_over`), beyond :data:`MADE_BY_TIME`: ``energy
    made``, or ``ledger open`` if it is missing; else ``kept``.
    """
    row: Row = {
        "particles": len(sim.snapshot().X),
        "steps": sim.step,
        "survived": failure is None,
        "outcome": "kept",
        "lost_at": math.nan,
        "why": "",
        **folding(sim),
        "wall_s": time.perf_counter() - started,
    }
    if abs(rest) > MADE_BY_TIME:
        row["outcome"] = "energy made" if rest > 0.0 else "ledger open"
    if row["folded"]:
        row["outcome"] = "folded"
        row["why"] = f"positions folded by {row['folded_at']:.3g} s"
    if failure is not None:
        X = ", ".join(f"{value:.3g}" for value in failure.position)
        row["outcome"] = "lost"
        row["lost_at"] = failure.time
        row["why"] = f"{failure.reason}, step {failure.step}, particle {failure.particle} at ({X})"
    return row


def left_over(table: pd.DataFrame) -> Array:
    """Rest of the energy ledger and work of the projection together [J], at every record.

    Stages project with positions that differ from what ``F`` has come to by ``dt^2``: the work
    that this costs is no physical one, and the integrator gives it back.  Apart, the two columns
    are artefacts of equal size; their sum is what the energy really missed.
    """
    return np.asarray(table["energy_rest [J]"] + table["work_projection [J]"], dtype=float)


def vectors(table: pd.DataFrame, kind: str, what: str) -> Array:
    """Columns ``<kind>_<what>_x .. z`` of :class:`MomentumDrift`, ``(n, 3)``."""
    unit = {"linear": "kg m/s", "angular": "kg m^2/s"}[kind]
    return np.asarray(table[[f"{kind}_{what}_{axis} [{unit}]" for axis in AXES]], dtype=float)


def shares(table: pd.DataFrame, kind: str, values: Array) -> Array:
    """Values over the natural scale at the same record; zero while nothing moves."""
    scale = table[f"{kind}_scale [{'kg m/s' if kind == 'linear' else 'kg m^2/s'}]"].to_numpy()
    return np.divide(values, scale, out=np.zeros_like(scale), where=scale > 0.0)
