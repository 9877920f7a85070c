"""Recorders that need the solver's budget: energy, momentum drift, reactions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sphsolid.errors import InputError
from sphsolid.record.budget import WORKS, Budget
from sphsolid.record.recorders import (
    AXES,
    angular_momentum,
    linear_momentum,
    momentum_scales,
)
from sphsolid.record.snapshot import Snapshot
from sphsolid.scenes.scene import Scene


def _budget(snapshot: Snapshot) -> Budget:
    if not isinstance(snapshot.budget, Budget):
        raise InputError(
            "this recorder needs the budget of energy and momentum, which the solver did not "
            "keep; call its track_budget() before the first step, or pass the recorder to run()"
        )
    return snapshot.budget


@dataclass(frozen=True)
class EnergyBudget:
    """Every term of the energy budget [J], and what is left over.

        K + W_dev + W_vol - (K + W)(0) = sum of works + residual

    Works since the start: tractions, body force, constraints (prescribed motion), dissipation by
    ``D(p)`` and by ``D(J)`` ([Lee2017] eqs. (34), (35), negative when energy is taken), projection
    (eq. (40)) and the defect of a force that is not the adjoint of the gradient.  A user's own
    term has a column of its name.  The residual, ``energy_rest``, is the time integrator's alone.
    """

    needs_budget: bool = True

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Twelve columns, and one for each further work."""
        budget = _budget(snapshot)
        kinetic, strain = snapshot.kinetic_energy, snapshot.strain_energy
        volumetric = snapshot.volumetric_energy
        row = {
            "kinetic_energy [J]": kinetic,
            "deviatoric_energy [J]": strain - volumetric,
            "volumetric_energy [J]": volumetric,
            "total_energy [J]": kinetic + strain,
        }
        residual = kinetic + strain - budget.start_energy
        for name in (*WORKS, *(other for other in budget.works if other not in WORKS)):
            work = budget.works.get(name, 0.0)
            what = name if name.startswith("dissipation") else f"work_{name}"
            row[f"{what} [J]"] = work
            residual -= work
        row["energy_rest [J]"] = residual
        return row


@dataclass(frozen=True)
class MomentumDrift:
    """Momentum that no load or constraint gave: in total, and the largest of one step.

    Norms of the linear [kg m/s] and the angular part [kg m^2/s] about the origin, beside their
    natural scales ``sum V |p|`` and ``sum V |x| |p|``, and the momentum and impulse themselves.
    """

    needs_budget: bool = True

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Two groups of twelve columns."""
        budget = _budget(snapshot)
        scales = momentum_scales(snapshot)
        # Summed as the recorders of a momentum sum it, whose columns have the same names.
        momenta = (linear_momentum(snapshot), angular_momentum(snapshot))
        row: dict[str, float] = {}
        for k, (kind, unit) in enumerate((("linear", "kg m/s"), ("angular", "kg m^2/s"))):
            row[f"{kind}_drift [{unit}]"] = float(np.linalg.norm(budget.drift[k]))
            row[f"{kind}_drift_step [{unit}]"] = float(budget.largest_step_drift[k])
            row[f"{kind}_scale [{unit}]"] = float(scales[k])
            for what, values in (
                ("momentum", momenta[k]), ("impulse", budget.impulse[k]),
                ("traction_impulse", budget.traction_impulse[k]),
            ):  # fmt: skip
                for i in range(3):
                    row[f"{kind}_{what}_{AXES[i]} [{unit}]"] = float(values[i])
        return row


@dataclass(frozen=True)
class Reactions:
    """Force [N] on the body at each constrained face, and its impulse [N s] since the start."""

    needs_budget: bool = True

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Six columns a face."""
        budget = _budget(snapshot)
        row: dict[str, float] = {}
        for face, force in budget.reaction_force.items():
            for i in range(3):
                row[f"reaction_{face}_{AXES[i]} [N]"] = float(force[i])
                row[f"reaction_impulse_{face}_{AXES[i]} [N s]"] = float(
                    budget.reaction_impulse[face][i]
                )
        return row
