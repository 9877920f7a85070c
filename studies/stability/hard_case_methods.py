"""The methods that the hard cases are put to, and the variants of one of them."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid.defaults import (
    Integrator,
    default_cfl,
    default_integrator,
    default_stabilisation,
)
from sphsolid.scenes import Scene
from sphsolid.scheme.intrinsic_time import as_time
from studies.convergence.cases import FORMULATIONS, SECONDARY

Simulation = fem.Simulation | sph.Simulation
#: Leaves the choice to the package: ``h_over_dx`` by the cloud, ``tau_p`` by formulation and solid.
CHOSEN = -1.0
#: Leaves every choice to the package, the formulation too.
BY_DEFAULT = "by default"
INTEGRATORS: dict[str, Integrator] = {
    each.name: each for each in (sph.PositionVerlet(), sph.SSPRK3(), sph.TVDRK2())
}


@dataclass(frozen=True)
class Method:
    """One method with all its settings, as plain values so that a case can carry them.

    The operator is the package's choice for the cloud: another one where particles are disordered.

    ``solver`` is ``SUPG-SPH``, ``SPH`` (no stabilisation) or ``B-bar FEM``; ``cfl`` is that of the
    method's own rule.  With ``weighting`` ``self-adjoint`` ``tau_F`` is in units of the default's,
    which is a time of the mesh; with ``printed`` of the step, as is ``tau_p``.
    """

    name: str
    solver: str = "SUPG-SPH"
    formulation: str = "{p,F,J}"
    secondary: str = "H1"
    weighting: str = "self-adjoint"
    tau_F: float = 1.0
    xi_F: float = 0.0
    tau_p: float = CHOSEN
    h_over_dx: float = CHOSEN
    integrator: str = "position Verlet"
    cfl: float = 0.7

    def arguments(self) -> dict[str, Any]:
        """Plain values for a case."""
        return asdict(self)

    def build(self, scene: Scene, spacing: float) -> Simulation:
        """A simulation of ``scene`` with particles or nodes ``spacing`` [m] apart."""
        if self.solver == "B-bar FEM":
            return fem.Simulation(scene, spacing=spacing, cfl=self.cfl)
        if self.formulation == BY_DEFAULT:
            return sph.Simulation(scene, spacing=spacing)
        return sph.Simulation(
            scene,
            spacing=spacing,
            formulation=FORMULATIONS[self.formulation](),
            stabilisation=self._stabilisation(scene),
            h_over_dx=None if self.h_over_dx == CHOSEN else self.h_over_dx,
            cfl=self.cfl,
            integrator=INTEGRATORS[self.integrator],
        )

    def _stabilisation(self, scene: Scene) -> sph.SUPG | sph.NoStabilisation:
        if self.solver == "SPH":
            return sph.NoStabilisation()
        supg = default_stabilisation(FORMULATIONS[self.formulation](), scene.material)
        usual = as_time(supg.tau_F)
        supg = replace(
            supg,
            tau_F=replace(usual, c=self.tau_F * usual.c),
            xi_F=self.xi_F,
            tau_p=supg.tau_p if self.tau_p == CHOSEN else self.tau_p,
            secondary=SECONDARY[self.secondary],
        )
        if self.weighting == "printed":
            return replace(supg, tau_F=sph.OfStep(self.tau_F), weighting=sph.AsPrinted())
        return supg


#: {p,F,J} SUPG-H1 with what the package uses where nothing is given.
BASE = Method(
    "{p,F,J} H1",
    integrator=default_integrator().name,
    cfl=default_cfl(default_integrator()),
)
FEM = Method(
    "B-bar FEM", solver="B-bar FEM", formulation="-", secondary="-",
    weighting="-", tau_F=0.0, tau_p=0.0, integrator="-", cfl=0.6,
)  # fmt: skip
_PLAIN = replace(BASE, solver="SPH", secondary="-", weighting="-", tau_F=0.0, tau_p=0.0)

_RK3: dict[str, Any] = {"integrator": "SSP-RK3", "cfl": default_cfl(sph.SSPRK3())}
#: Every method runs every case.  ``printed`` was the package's choice before the self-adjoint
#: weighting; the paper's settings are those of its column with H1.
METHODS = (
    replace(BASE, name="{p,F} H1", formulation="{p,F}"),
    BASE,
    replace(BASE, name="{p,F,J} H1, SSP-RK3", **_RK3),
    replace(
        BASE, name="{p,F,J} H1, printed", weighting="printed", tau_F=0.5, tau_p=0.1, **_RK3
    ),
    replace(
        BASE, name="{p,F,H,J} H1, paper's settings", formulation="{p,F,H,J}", weighting="printed",
        tau_F=1.0, xi_F=0.2, tau_p=0.1, integrator="TVD-RK2", cfl=0.3,
    ),
    replace(_PLAIN, name="{p,F,J} unstabilised"),
    replace(_PLAIN, name="displacement SPH", formulation="displacement"),
    FEM,
)  # fmt: skip
#: What a user gets who chooses nothing.
DEFAULTS = replace(BASE, name="defaults", formulation=BY_DEFAULT, secondary="by default")
PAPER = next(method for method in METHODS if method.name.endswith("paper's settings"))
PLAIN = next(method for method in METHODS if method.name == "{p,F,J} unstabilised")
#: For the long columns and the waves.
FEW = (DEFAULTS, PAPER, PLAIN, FEM)

_CHANGES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("CFL 0.5", {"cfl": 0.5}),
    ("CFL 0.8", {"cfl": 0.8}),
    ("tau_F / 2", {"tau_F": 0.5}),
    ("tau_F x 2", {"tau_F": 2.0}),
    ("tau_F x 4", {"tau_F": 4.0}),
    ("tau_p 0", {"tau_p": 0.0}),
)
#: What is changed of {p,F,J} H1: the evidence for the package's defaults.
VARIANTS = tuple(replace(BASE, name=name, **settings) for name, settings in _CHANGES)
#: What the answers of the columns and the punch are compared with, on half the spacing.
REFERENCE = replace(FEM, name="B-bar FEM, half spacing")
