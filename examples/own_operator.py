"""A gradient of one's own: weighted least squares, made consistent with the divergence theorem.

The gradient of the plane that fits best through a particle and its neighbours is

    G_b(X_a) = w_ab M_a^-1 (X_b - X_a),    M_a = sum_b w_ab (X_b - X_a) (X_b - X_a)^T,    b != a.
"""

from dataclasses import dataclass

import numpy as np

import sphsolid as sph
from sphsolid.cloud.consistent import least_change
from sphsolid.cloud.gradient import offsets, row_sum
from sphsolid.cloud.operator import Gradients
from sphsolid.scenes import swinging_cube


@dataclass(frozen=True)
class LeastSquares:
    """``w_ab`` is the smoothing function over its value at zero."""

    name: str = "LeastSquares"

    def build(self, cloud):
        X, pairs, w = cloud.mesh.vertices, cloud.pairs, cloud.share()
        d = offsets(X, X, pairs)
        moment = row_sum(pairs, w[:, None, None] * d[:, :, None] * d[:, None, :])
        inverse = np.linalg.inv(moment)[pairs.row_of_pair]
        G = w[:, None] * np.einsum("pij,pj->pi", inverse, d)
        own = pairs.indices == pairs.row_of_pair
        G[own] = -row_sum(pairs, G)
        change = least_change(G, pairs, X, cloud.volumes, cloud.areas, w)
        G = G + change.D
        return Gradients(G, G, cloud.areas, change.iterations)


def main() -> None:
    scene = swinging_cube(amplitude=1e-3)
    for operator in (sph.Consistent(), LeastSquares()):
        simulation = sph.Simulation(
            scene, spacing=0.25, formulation=sph.PF(), operator=operator
        )
        history = simulation.run(until=0.01, record=[sph.record.Errors()])
        worst = max(float(history[name][-1]) for name in history.table.columns if "p_" in name)
        print(f"{operator.name}: {simulation.consistency}; error of p {worst:.4f}")


if __name__ == "__main__":
    main()
