"""A constitutive law of one's own: Yeoh's rubber, in both solvers.

    W = c1 s + c2 s^2 + c3 s^3 + kappa/2 (J - 1)^2,    s = J^(-2/3) F:F - 3,    mu = 2 c1
"""

from dataclasses import replace
from typing import NamedTuple

import fem_reference as fem
import sphsolid as sph
from sphsolid.continuum import QUADRATIC, register_law
from sphsolid.continuum.tensor import add, axpy, contract, scale
from sphsolid.scenes import twisting_column


class Yeoh(NamedTuple):
    mu: float  # shear modulus at rest [Pa]
    kappa: float  # bulk modulus [Pa]
    density: float  # [kg/m^3]
    c2: float  # [Pa]
    c3: float  # [Pa]
    depends_on_H = False


def slopes(m, s):  # w'(s), w''(s)
    return 0.5 * m.mu + 2.0 * m.c2 * s + 3.0 * m.c3 * s * s, 2.0 * m.c2 + 6.0 * m.c3 * s


def energy(m, F, H, J):
    s = J ** (-2 / 3) * contract(F, F) - 3.0
    volume = 0.5 * m.kappa * (J - 1.0) ** 2
    return 0.5 * m.mu * s + m.c2 * s * s + m.c3 * s * s * s + volume


def conjugate_stresses(m, F, H, J):  # dW/dF, dW/dH, dW/dJ
    a, FF = J ** (-2 / 3), contract(F, F)
    w, _ = slopes(m, a * FF - 3.0)
    dJ = -2.0 / 3.0 * w * a / J * FF + m.kappa * (J - 1.0)
    return scale(2.0 * w * a, F), scale(0.0, H), dJ


def first_piola(m, F, H, J):  # Sigma_F + Sigma_J H
    S_F, _, S_J = conjugate_stresses(m, F, H, J)
    return axpy(S_J, H, S_F)


def hessian_action(m, F, H, J, dF, dH, dJ):  # what the conjugate stresses change by
    a, FF, FdF = J ** (-2 / 3), contract(F, F), contract(F, dF)
    w, ww = slopes(m, a * FF - 3.0)
    ds = 2.0 * a * FdF - 2.0 / 3.0 * a / J * FF * dJ
    dw, da = ww * ds, -2.0 / 3.0 * a / J * dJ
    dS_F = add(scale(2.0 * w * a, dF), scale(2.0 * (dw * a + w * da), F))
    fall = a / J
    dfall = -5.0 / 3.0 * fall / J * dJ
    dS_J = -2.0 / 3.0 * (dw * fall * FF + w * dfall * FF + w * fall * 2.0 * FdF) + m.kappa * dJ
    return dS_F, scale(0.0, dH), dS_J


register_law(
    Yeoh, energy=energy, conjugate_stresses=conjugate_stresses, first_piola=first_piola,
    hessian_action=hessian_action, volumetric=QUADRATIC,
)  # fmt: skip


def main() -> None:
    rubber = Yeoh(mu=6.54e6, kappa=1.42e7, density=1100.0, c2=-3.0e5, c3=3.0e5)
    sph.check_law(rubber)
    scene = replace(twisting_column(poisson_ratio=0.3), material=rubber)
    for simulation in (
        sph.Simulation(scene, spacing=0.5, formulation=sph.PF()),
        fem.Simulation(scene, spacing=0.5),
    ):
        simulation.run(until=5.0e-3)
        print(f"{simulation.name}: strain energy {simulation.snapshot().strain_energy:.6g} J")


if __name__ == "__main__":
    main()
