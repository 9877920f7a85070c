"""A time integrator of one's own: fourth order, from three steps of position Verlet [Yoshida1990].

    u(t + dt) = V(w1 dt) V(w0 dt) V(w1 dt) u(t),    w1 = 1 / (2 - 2^(1/3)),    w0 = 1 - 2 w1
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np

import sphsolid as sph
from sphsolid.scenes import Box, Scene

W1 = 1.0 / (2.0 - 2.0 ** (1.0 / 3.0))
WEIGHTS = (W1, 1.0 - 2.0 * W1, W1)


@dataclass(frozen=True)
class Yoshida:
    name: str = "Yoshida"
    stages: int = 3
    usual_cfl: ClassVar[float] = 0.4  # its longest part is 1.7 steps long

    def stepper(self, rhs, state, essential):
        return YoshidaStepper(sph.PositionVerlet().stepper(rhs, state, essential))


class YoshidaStepper:
    def __init__(self, verlet):
        self._verlet = verlet

    @property
    def budget(self):
        return self._verlet.budget

    @budget.setter
    def budget(self, budget):
        self._verlet.budget = budget

    def advance(self, dt, t):
        for w in WEIGHTS:
            self._verlet.advance(w * dt, t)
            t += w * dt


def spinning(X):
    centre = X - 0.5
    return 20.0 * np.cross([0.0, 0.0, 1.0], centre) + 5.0 * centre


def main() -> None:
    rubber = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)
    scene = Scene("spinning", Box(), rubber, 0.02, initial_velocity=spinning)
    for integrator in (sph.PositionVerlet(), Yoshida()):
        found = []
        for steps in (8, 16, 32):
            simulation = sph.Simulation(
                scene, spacing=0.5, formulation=sph.Displacement(),
                stabilisation=sph.NoStabilisation(), integrator=integrator,
            )  # fmt: skip
            for _ in range(steps):
                simulation.advance(scene.end_time / steps)
            found.append(simulation.snapshot().x)
        coarse, fine = (np.linalg.norm(a - b) for a, b in pairwise(found))
        print(f"{integrator.name}: order {np.log2(coarse / fine):.2f}")


if __name__ == "__main__":
    main()
