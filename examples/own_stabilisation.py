"""A stabilisation of one's own: a viscosity on what the gradient does not see of a pair.

For particles a and b with X_ab = X_b - X_a and a weight w_ab [kg/s]

    r_ab = v_b - v_a - 1/2 (L_a + L_b) X_ab,    power = -sum w_ab |r_ab|^2,

L = grad v being the operator's own: an affine motion is not damped, what alternates from particle
to particle is.  The force is the transpose of r, so the power is minus a square at any state.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

import sphsolid as sph
from sphsolid.record import EnergyBudget
from sphsolid.scenes import Box, Scene
from sphsolid.scheme import Term, TermOption


@dataclass(frozen=True)
class PairViscosity(TermOption):
    """``w_ab = strength rho0 c_s V / dx`` for each pair, ``V`` the smaller of the two volumes."""

    strength: float = 0.05
    name: str = "pair viscosity"

    def terms(self, set_up):
        return (PairViscosityTerm(self.strength, set_up),)


class PairViscosityTerm(Term):
    needs_rates = True
    works = ("dissipation_pairs",)

    def __init__(self, strength, set_up):
        cloud, m = set_up.cloud, set_up.material
        a, b = cloud.pairs.row_of_pair, cloud.pairs.indices.astype(int)
        a, b = a[a < b], b[a < b]
        k, shape = np.arange(len(a)), (len(a), cloud.size)
        self.to_b, self.to_a = (csr_array((np.ones(len(a)), (k, c)), shape=shape) for c in (b, a))
        self.difference, self.mean = self.to_b - self.to_a, 0.5 * (self.to_b + self.to_a)
        self.X = cloud.X[b] - cloud.X[a]
        self.density, self.V = m.density, cloud.V
        smaller = np.minimum(cloud.V[a], cloud.V[b])
        self.w = strength * np.sqrt(m.density * m.mu) * smaller / cloud.spacing
        load = (abs(self.difference).T @ self.w) / (m.density * cloud.V)
        self.limit = 1.0 / (4.0 * load.max())

    def unseen(self, p, L):
        """``r (pairs, 3)`` [m/s]."""
        seen = (self.mean @ L.reshape(-1, 9)).reshape(-1, 3, 3)
        return self.difference @ p / self.density - np.einsum("kij,kj->ki", seen, self.X)

    def add_stress(self, stage):
        self.q = self.w[:, None] * self.unseen(stage.state.p, stage.rates.F)
        through_L = (self.mean.T @ (self.q[:, :, None] * self.X[:, None, :]).reshape(-1, 9))
        stage.P[:] -= through_L.reshape(-1, 3, 3) / self.V[:, None, None]

    def add_rates(self, stage):
        stage.rates.p -= (self.difference.T @ self.q) / self.V[:, None]

    def powers(self, stage):
        return (-float(np.sum(self.q * self.unseen(stage.state.p, stage.rates.F))),)

    def largest_step(self, state):
        return self.limit


def alternating(X):
    """1 m/s to and fro from one particle to the next, spacing 1/4 m."""
    sign = (-1.0) ** np.rint(X.sum(axis=1) / 0.25)
    return sign[:, None] * np.array([1.0, 0.0, 0.0])


def main() -> None:
    rubber = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)
    scene = Scene("noisy", Box(), rubber, 0.05, initial_velocity=alternating)
    for term in (sph.NoStabilisation(), PairViscosity()):
        simulation = sph.Simulation(
            scene, spacing=0.25, formulation=sph.Displacement(), stabilisation=term, cfl=0.1
        )
        history = simulation.run(every=0.025, record=[EnergyBudget()])
        start, end = (float(history["total_energy [J]"][k]) for k in (0, -1))
        residual = float(history["energy_rest [J]"][-1])
        print(f"{term.name}: {end / start:.6f} of the energy kept, residual {residual / start:.2e}")


if __name__ == "__main__":
    main()
