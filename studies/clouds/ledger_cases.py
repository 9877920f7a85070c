"""Is energy made in space?  Unstabilised runs whose energy may change by the time step alone."""

from __future__ import annotations

from typing import Any

import numpy as np

import sphsolid as sph
from sphsolid.record import EnergyBudget
from studies.clouds.cases import cube_on, operator_of
from studies.clouds.choice import cloud_of, label_of
from studies.conservation.measures import INTEGRATORS

#: Share of a period that is run, and instants at which the account is read.
SHARE, INSTANTS = 0.25, 24
#: Steps of the coarsest run: within the limit of both integrators on every cloud of 9^3.
STEPS = 96


def ledger(*, cloud: str, level: int, operator: str, integrator: str) -> list[dict[str, Any]]:
    """Three rows, ``dt``, ``dt / 2`` and ``dt / 4``: the largest rest of the energy account.

    The manufactured cube, loaded and at strains of 0.2, without stabilisation or projection: the
    works of tractions, body force and constraints are accounted for, and what is left over is the
    integrator's, and the operator's if it is not adjoint.
    """
    instance = cloud_of(cloud).at(level)
    scene = cube_on(instance, scene="manufactured", family="A+B+C=0")
    period = scene.known_solution().period
    rows = []
    for halving in range(3):
        sim = sph.Simulation(
            scene,
            spacing=instance.spacing,
            formulation=sph.PF(),
            stabilisation=sph.NoStabilisation(),
            operator=operator_of(operator),
            angular_momentum=sph.NoProjection(),
            integrator=INTEGRATORS[integrator],
        )
        sim.track_budget()
        steps = STEPS * 2**halving
        dt = SHARE * period / steps
        found, energy = [], 0.0
        for step in range(1, steps + 1):
            sim.advance(dt)
            if step % (steps // INSTANTS) == 0:
                row = EnergyBudget().record(sim.snapshot(), scene)
                found.append(abs(row["energy_rest [J]"]))
                energy = max(energy, row["total_energy [J]"])
        rows.append(
            {
                "kind": "ledger",
                "cloud": label_of(cloud),
                "operator": operator,
                "integrator": integrator,
                "h": instance.h,
                "particles": sim.cloud.size,
                "steps": steps,
                "dt": dt,
                "dt_over_stable": dt / sim.stable_time_step(),
                "rest": float(np.max(found)) / energy,
            }
        )
    return rows
