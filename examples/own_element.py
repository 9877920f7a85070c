"""An element of one's own: eight nodes, full integration, no cure for locking.

    f_a = sum_g w_g P(F_g) dN_a/dX(g),    F_g = sum_a x_a (x) dN_a/dX(g)

It keeps what it can of B-bar (nodes, volumes, loads) and takes forces and energy with numpy.
"""

from dataclasses import dataclass

import numpy as np

import fem_reference as fem
from fem_reference.b_bar_hex import BBarHexElements
from fem_reference.element import CentroidStress
from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.scenes import twisting_column


@dataclass(frozen=True)
class FullHex:
    name: str = "full_hex"

    def cell_size(self, spacing):
        return spacing

    def discretise(self, *, mesh, sk, material):
        return FullHexElements(mesh, sk, material)


class FullHexElements(BBarHexElements):
    def __init__(self, mesh, sk, material):
        super().__init__(mesh, sk, material)
        self.law = material
        points = 0.5 + (CORNERS - 0.5) / np.sqrt(3.0)
        # N_a = product of xi or 1 - xi; its derivative flips one factor for a sign.
        factors = np.where(CORNERS[None] == 1, points[:, None], 1.0 - points[:, None])
        signs = 2.0 * CORNERS - 1.0
        dN = np.stack(
            [signs[:, i] * np.prod(np.delete(factors, i, axis=2), axis=2) for i in range(3)], axis=2
        )
        tangent = np.einsum("eai,gaj->egij", mesh.vertices[mesh.cells], dN)
        self.gradients = np.einsum("gaj,egjk->egak", dN, np.linalg.inv(tangent))
        self.weights = np.linalg.det(tangent) / 8.0
        self.smallest = np.ones(len(mesh.cells))

    def at_points(self, x):
        return np.einsum("eai,egak->egik", x[self.mesh.cells], self.gradients)

    def internal_force(self, x, force):
        F = self.at_points(x)
        entries = split(F)
        J = determinant(entries)
        P = join(law.first_piola(self.law, entries, cofactor(entries), J))
        by_corner = np.einsum("eg,egik,egak->eai", self.weights, P, self.gradients)
        force[:] = 0.0
        np.add.at(force, self.mesh.cells, by_corner)
        stretch = np.linalg.svd(F, compute_uv=False)[..., -1].min(axis=1)
        self.smallest = np.where(J.min(axis=1) > 0.0, stretch, -1.0)

    def smallest_length(self):
        return float(np.min(self.quadrature.length * self.smallest))

    def invalid_element(self):
        worst = int(np.argmin(self.smallest))
        return -1 if self.smallest[worst] > 0.0 else worst

    def strain_energy(self, x):
        entries = split(self.at_points(x))
        W = law.stored_energy(self.law, entries, cofactor(entries), determinant(entries))
        return float(np.sum(self.weights * W))

    def stress(self, x):
        F = self.at_points(x).mean(axis=1)
        entries = split(F)
        J = determinant(entries)
        P = join(law.first_piola(self.law, entries, cofactor(entries), J))
        return CentroidStress(F, J, np.ascontiguousarray(P))

    def description(self):
        return f"{self.count} fully integrated hexahedra"


def main() -> None:
    scene = twisting_column(poisson_ratio=0.495)
    for element in (fem.BBarHex(), FullHex()):
        simulation = fem.Simulation(scene, spacing=0.25, element=element)
        simulation.run(until=0.01)
        snapshot = simulation.snapshot()
        spread = np.ptp(snapshot.pressure) / 1e6
        total = snapshot.kinetic_energy + snapshot.strain_energy
        print(f"{element.name}: energy {total:.6g} J, pressures span {spread:.4g} MPa")


if __name__ == "__main__":
    main()
