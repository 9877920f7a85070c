"""Scenes run over one span in a given number of steps, and the order that three runs show."""

from __future__ import annotations

from typing import Any

import numpy as np

import sphsolid as sph
from sphsolid.scenes import Scene

#: Length [s] of every run.
SPAN = 2.0e-3


def build(scene: Scene, **options: Any) -> sph.Simulation:
    """Undamped unless ``options`` say otherwise."""
    return sph.Simulation(
        scene, spacing=0.4, **{"stabilisation": sph.NoStabilisation(), **options}
    )


def after(scene: Scene, steps: int, **options: Any) -> sph.Simulation:
    """At ``SPAN``, with its balance."""
    sim = build(scene, **options)
    sim.track_budget()
    for _ in range(steps):
        sim.advance(SPAN / steps)
    return sim


def orders(scene: Scene, names: str, **options: Any) -> dict[str, float]:
    """Power of the step with which each field of 32, 64 and 128 steps converges."""
    states = [after(scene, n, **options).state for n in (32, 64, 128)]
    found = {}
    for name in names:
        coarse, middle, fine = (getattr(state, name) for state in states)
        ratio = np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)
        found[name] = float(np.log2(ratio))
    return found
