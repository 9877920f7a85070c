"""What H1 and H6 cost, measured side by side on the punch test's lattices."""

from __future__ import annotations

import time
from typing import Any

import sphsolid as sph
from sphsolid.cloud import H1, H6
from sphsolid.scenes import punch
from sphsolid.scheme.stabilisation import Stabilisation
from studies.punch.cases import lattice_name

#: Fastest of this many timings, taken in turn: the machine is shared, the minimum is what it can.
REPEATS = 9
#: Particles times steps of a timing, about 50 ms.
WORK = 5.0e4


def run_case(
    *, key: str, tau_p: float, cells: int, repeats: int = REPEATS, work: float = WORK
) -> list[dict[str, Any]]:
    """One row: nanoseconds per particle-step without, with H1 and with H6 terms.

    ``terms_ratio`` is what H6 adds to a step without secondary particles over what H1 adds;
    ``step_ratio`` is the whole step with H6 over that with H1.
    """
    choices: dict[str, Stabilisation] = {
        "none": sph.NoStabilisation(),
        "H1": sph.SUPG(tau_F=0.5, xi_F=0.1, tau_p=tau_p, secondary=H1()),
        "H6": sph.SUPG(tau_F=0.5, xi_F=0.1, tau_p=tau_p, secondary=H6()),
    }
    sims = {
        name: sph.Simulation(
            punch(),
            spacing=1.0 / cells,
            formulation=sph.PFHJ(),
            stabilisation=choice,
            integrator=sph.TVDRK2(),
            cfl=0.3,
        )
        for name, choice in choices.items()
    }
    size = sims["none"].cloud.size
    # The step is far below the stable one, nothing diverges.
    steps = max(2, int(work / size))
    best = dict.fromkeys(sims, float("inf"))
    for repeat in range(repeats + 1):
        for name, sim in sims.items():
            started = time.perf_counter()
            for _ in range(steps):
                sim.advance(1.0e-7)
            if repeat > 0:
                best[name] = min(best[name], (time.perf_counter() - started) / steps)
    ns = {name: 1.0e9 * seconds / size for name, seconds in best.items()}
    return [
        {
            "kind": "cost",
            "key": key,
            "lattice": lattice_name(sims["none"].cloud.mesh),
            "tau_p": tau_p,
            "ns_none": ns["none"],
            "ns_H1": ns["H1"],
            "ns_H6": ns["H6"],
            "terms_ratio": (ns["H6"] - ns["none"]) / (ns["H1"] - ns["none"]),
            "step_ratio": ns["H6"] / ns["H1"],
        }
    ]
