"""What a simulation says about itself: its plan before, its cost after."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from sphsolid.cloud.lattice_difference import LatticeDifference
from sphsolid.cloud.lengths import Local
from sphsolid.compiled import description
from sphsolid.defaults import (
    NotTabulated,
    is_restrained,
    stability_limit,
)
from sphsolid.recommendation import NotMeasured
from sphsolid.scenes.stated_deformation import NOT_USED
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.time_step import STRETCH

if TYPE_CHECKING:
    from sphsolid.simulation import Simulation



def plan(sim: Simulation) -> str:
    """What is active and why, what was chosen by default, what it will cost."""
    f, c, step = sim.formulation, sim.cloud, sim._time_step
    cost: dict[str, Any] = description()
    reference = min(step.reference, sim._rhs.largest_step(sim._state))
    steps = math.ceil(max(0.0, sim.scene.end_time - sim.time) / reference)
    memory = sim.memory_bytes()
    lines = [
        f"scene          {sim.scene.name}: {sim.scene.provenance or 'no provenance given'}",
        f"particles      {c.size} primary, spacing {c.spacing:.4g} m, "
        f"{c.mean_neighbours:.1f} neighbours ({_support(sim)})",
        "material       " + _material(sim),
        f"operator       {sim.operator.name}, "
        + ("force and gradient adjoint" if c.is_adjoint else "not adjoint")
        + f"; {sim.consistency}; {_made(sim)}" + _why(sim),
        *(f"refused        {tried}: {reason}" for tried, reason in sim.refused),
        *(f"doubtful       {doubt}" for doubt in sim.doubts),
        "dilatation     " + sim.dilatation.name,
        "fields         p, x" + (", F" if f.evolves_F else " (F from the geometry)")
        + (", H" if f.evolves_H else " (H = cof F)")
        + (", J" if f.evolves_J else " (J = det F)")
        + "".join(f", {name}" for name in sim._state if name not in ("p", "x", *"FHJ", STRETCH)),
        "initial strain " + type(sim.initial_strain).__name__ + _ignored(sim),
        "projection     " + type(sim.angular_momentum).__name__,
        "stabilisation  " + _stabilisation(sim),
        f"integrator     {sim.integrator.name}, CFL {step.cfl:g} ({_limit(sim)}), undeformed step "
        f"{reference:.4g} s{_by_terms(step.reference, reference)}, at least {steps} steps and "
        f"{steps * sim.integrator.stages} evaluations to {sim.scene.end_time:.4g} s: the step "
        "shrinks with the smallest stretch of a particle",
        *_advice(sim),
        "by default     " + (", ".join(sim.by_default) or "nothing: every option was given"),
        f"memory         {memory / 1e6:.1f} MB, {memory / c.size:.0f} B a particle",
        f"threads        at most {cost['threads']}, as many as pay ({cost['threading_layer']})",
    ]
    return "\n".join(lines)


def _advice(sim: Simulation) -> list[str]:
    if "formulation" not in sim.by_default:
        return []
    evidence, active = sim.advice.evidence, sim.stabilisation.name
    same = isinstance(evidence, NotMeasured) or evidence.stabilisation == active
    return [f"formulation    {sim.advice.reason}" + ("" if same else f"; active here: {active}")]


def _support(sim: Simulation) -> str:
    c = sim.cloud
    if hasattr(sim.operator, "layout"):
        return "those of the operator"
    ratio = c.smoothing.support * sim.h_over_dx
    if isinstance(c.lengths, Local):
        small, large = ratio * np.min(c.lengths.spacing), ratio * np.max(c.lengths.spacing)
        return f"support {small:.4g} to {large:.4g} m = {ratio:.3g} times the local spacing"
    dx = c.lengths.nominal
    unit = "dx" if math.isclose(dx, c.spacing) else f"times the widest edge, {dx:.4g} m"
    return f"support {c.smoothing.support * c.h:.4g} m = {ratio:.3g} {unit}"


def _material(sim: Simulation) -> str:
    c = sim.cloud
    left_out = f"{c.left_out} pairs of particles"
    if sim.secondary is not None:
        left_out += f" and {sim.secondary.left_out} of secondary ones"
    if c.sight.is_clear:
        text = "every pair within its support is one: nothing in the body is hidden"
    else:
        text = f"{left_out} left out: the straight line between them leaves the body"
    if c.parts > 1:
        text += f"; {c.parts} parts share no pair and pass through each other: there is no contact"
    return text


def _ignored(sim: Simulation) -> str:
    unused = sim.scene.states_deformation and not sim.initial_strain.uses_stated
    return f"; {NOT_USED}" if unused else ""


def _made(sim: Simulation) -> str:
    c, detail = sim.cloud, getattr(sim.operator, "detail", None)
    if detail is not None:
        return str(detail(c.mesh))
    return (
        f"differs from the printed gradient by {c.change:.2g} of it, {c.iterations} iterations"
    )


def _why(sim: Simulation) -> str:
    if "operator" not in sim.by_default:
        return ""
    if isinstance(sim.operator, LatticeDifference):
        return "; chosen because on a box lattice no other costs less or is as accurate"
    if sim.cloud.mesh.is_lattice:
        return "; chosen because on a lattice it is as accurate and keeps the stencil"
    return "; chosen because away from a lattice no other is second order"


def _by_terms(by_cfl: float, allowed: float) -> str:
    """Whether a term allows less than the CFL number, such as the viscosity of a restraint."""
    if allowed >= by_cfl:
        return ""
    return f" (a term allows {allowed / by_cfl:.2g} of what the CFL number does)"


def _limit(sim: Simulation) -> str:
    if is_restrained(sim.formulation, (sim.stabilisation, *sim.terms)):
        phase = getattr(sim.integrator, "largest_phase", math.nan)
        if math.isnan(phase):
            return "1 is a step of two over the highest frequency of the undeformed body"
        if phase == 0.0:
            return "no step is short enough: what is not damped grows, slowly at first"
        return (
            f"{0.5 * phase:.3g} is what the highest frequency of the undeformed body allows"
        )
    others = {"formulation", "integrator", "cfl"}
    if others.union(sim.by_default) >= {"stabilisation", "h_over_dx", "operator", "smoothing"}:
        limit = stability_limit(sim.integrator, sim.formulation, sim.material)
        if isinstance(limit, NotTabulated):
            return "no stability limit is tabulated: python -m studies.stability"
        return (
            f"on a free lattice block at rest modes grow slowly above {limit.slow:g}, fast above "
            f"{limit.fast:g}"
        )
    return "stability limit not tabulated for these options: python -m studies.stability"


def _stabilisation(sim: Simulation) -> str:
    units = Units(sim._time_step.crossing, sim._time_step.reference)
    lines = [term.description(units) for term in sim._rhs.terms]
    return "; ".join(lines) or "none: no secondary particles are made"


def summary(sim: Simulation) -> str:
    """How far the run is, what it cost, and whether the positions are those of a body still."""
    work = sim.step * sim.cloud.size
    per = f"{1e9 * sim.run_seconds / work:.0f} ns a particle-step" if work else "no steps yet"
    return (
        f"{sim.name}: t = {sim.time:.6g} s, {sim.step} steps, {sim.cloud.size} particles, "
        f"set-up {sim.setup_seconds:.2f} s, run {sim.run_seconds:.2f} s, {per}\n"
        f"{sim.positions.line(sim.placement())}"
    )
