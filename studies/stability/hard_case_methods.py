"""The methods that the hard cases are put to, and the variants of one of them."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid.defaults import default_cfl, default_stabilisation
from sphsolid.scenes import Scene, twisting_column
from studies.convergence.cases import FORMULATIONS, OPERATORS, SECONDARY

Simulation = fem.Simulation | sph.Simulation
#: How much longer the step of the second run is: the paper's CFL 0.3 becomes 0.5.
LONG_STEP = 5.0 / 3.0
#: ``h_over_dx`` that leaves the choice to ``Simulation``: 0.77 on lattices, 0.9 on disorder.
CHOSEN = 0.0
INTEGRATORS: dict[str, sph.TVDRK2 | sph.SSPRK3] = {"TVD-RK2": sph.TVDRK2(), "SSP-RK3": sph.SSPRK3()}


@dataclass(frozen=True)
class Method:
    """One method with all its settings, as plain values so that a case can carry them.

    ``solver`` is ``SUPG-SPH``, ``SPH`` (no stabilisation) or ``B-bar FEM``; the intrinsic times
    are in units of the step; ``cfl`` is that of the method's own rule.
    """

    name: str
    solver: str = "SUPG-SPH"
    formulation: str = "{p,F,J}"
    secondary: str = "H1"
    operator: str = "Consistent"
    tau_F: float = 1.0
    xi_F: float = 0.0
    tau_p: float = 0.1
    h_over_dx: float = CHOSEN
    integrator: str = "SSP-RK3"
    cfl: float = 0.5

    def arguments(self) -> dict[str, Any]:
        """Plain values for a case."""
        return asdict(self)

    def longer_step(self) -> Method:
        """The same with a step :data:`LONG_STEP` times as long."""
        return replace(self, cfl=round(LONG_STEP * self.cfl, 10))

    def build(self, scene: Scene, spacing: float) -> Simulation:
        """A simulation of ``scene`` with particles or nodes ``spacing`` [m] apart."""
        if self.solver == "B-bar FEM":
            return fem.Simulation(scene, spacing=spacing, cfl=self.cfl)
        return sph.Simulation(
            scene,
            spacing=spacing,
            formulation=FORMULATIONS[self.formulation](),
            stabilisation=(
                sph.NoStabilisation()
                if self.solver == "SPH"
                else sph.SUPG(
                    tau_F=self.tau_F,
                    xi_F=self.xi_F,
                    tau_p=self.tau_p,
                    secondary=SECONDARY[self.secondary],
                )
            ),
            operator=OPERATORS[self.operator],
            h_over_dx=None if self.h_over_dx == CHOSEN else self.h_over_dx,
            cfl=self.cfl,
            integrator=INTEGRATORS[self.integrator],
        )


_SUPG = default_stabilisation(sph.PFJ(), twisting_column().material)
#: {p,F,J} SUPG-H1 with what the package uses where nothing is given.
BASE = Method(
    "{p,F,J} H1",
    tau_F=_SUPG.tau_F,
    xi_F=_SUPG.xi_F,
    tau_p=_SUPG.tau_p,
    cfl=default_cfl(sph.SSPRK3()),
)
FEM = Method(
    "B-bar FEM", solver="B-bar FEM", formulation="-", secondary="-", operator="-",
    tau_F=0.0, tau_p=0.0, integrator="-", cfl=0.6,
)  # fmt: skip
_PLAIN = replace(BASE, solver="SPH", secondary="-", tau_F=0.0, tau_p=0.0)

#: The paper's integrator, step and intrinsic times, on its column with H1.
_PAPER: dict[str, Any] = {
    "integrator": "TVD-RK2", "cfl": 0.3, "tau_F": 1.0, "xi_F": 0.2, "tau_p": 0.1,
}  # fmt: skip
#: Every method runs every case.
METHODS = (
    replace(BASE, name="{p,F} H1", formulation="{p,F}", tau_p=0.0),
    BASE,
    replace(BASE, name="{p,F,H,J} H1", formulation="{p,F,H,J}"),
    replace(BASE, name="{p,F,J} H6", secondary="H6"),
    replace(BASE, name="{p,F,H,J} H6", formulation="{p,F,H,J}", secondary="H6"),
    replace(BASE, name="{p,F,H,J} H1, paper's settings", formulation="{p,F,H,J}", **_PAPER),
    replace(
        BASE, name="{p,F,H,J} H1 Literal, paper's settings", formulation="{p,F,H,J}",
        operator="Literal", **_PAPER,
    ),
    replace(BASE, name="{p,F,J} H1 Literal", operator="Literal"),
    replace(BASE, name="{p,F,J} H1 force only", operator="Consistent(force)"),
    replace(_PLAIN, name="{p,F,J} unstabilised"),
    replace(_PLAIN, name="displacement SPH", formulation="displacement"),
    FEM,
)  # fmt: skip

_TVD: dict[str, Any] = {"integrator": "TVD-RK2", "cfl": 0.3, "tau_F": 1.0}
_CHANGES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("CFL 0.3, tau_F 1", {"cfl": 0.3, "tau_F": 1.0}),
    ("CFL 0.5, tau_F 0.25", {"cfl": 0.5, "tau_F": 0.25}),
    ("CFL 0.5, tau_F 0.5", {"cfl": 0.5, "tau_F": 0.5}),
    ("CFL 0.5, tau_F 1", {"cfl": 0.5, "tau_F": 1.0}),
    ("CFL 0.7, tau_F 0.3", {"cfl": 0.7, "tau_F": 0.3}),
    ("TVD-RK2, CFL 0.3", _TVD),
    ("TVD-RK2, CFL 0.2", _TVD | {"cfl": 0.2}),
    ("TVD-RK2, CFL 0.3, h/dx 0.85", _TVD | {"h_over_dx": 0.85}),
    ("TVD-RK2, CFL 0.3, h/dx 0.9", _TVD | {"h_over_dx": 0.9}),
    ("h/dx 0.7", {"h_over_dx": 0.7}),
    ("h/dx 0.85", {"h_over_dx": 0.85}),
    ("h/dx 0.9", {"h_over_dx": 0.9}),
    ("h/dx 1", {"h_over_dx": 1.0}),
    ("xi_F 0.1", {"xi_F": 0.1}),
    ("tau_p 0", {"tau_p": 0.0}),
    ("tau_p 0.5", {"tau_p": 0.5}),
)
#: What is changed of {p,F,J} H1: the evidence for the package's defaults.
VARIANTS = tuple(
    replace(BASE, name=name, **settings)
    for name, settings in _CHANGES
    if replace(BASE, **settings) != BASE
)
#: What the answers of the columns and the punch are compared with, on half the spacing.
REFERENCE = replace(FEM, name="B-bar FEM, half spacing")
