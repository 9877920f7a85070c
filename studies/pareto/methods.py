"""The methods of the study: a table, to which a new integrator or element is one line."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

import fem_reference as fem
import sphsolid as sph
from fem_reference.element import Element
from sphsolid.cloud import SecondaryPoints
from sphsolid.defaults import (
    Integrator,
    default_integrator,
    default_stabilisation,
)
from sphsolid.scenes.scene import Scene
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.stabilisation import NoStabilisation, Stabilisation

#: Families, which the figures colour.
MIXED, DENSE, PAPER, PLAIN, FEM = (
    "SUPG-SPH H1", "SUPG-SPH H6", "SUPG-SPH H1, the paper's integrator",
    "SPH without stabilisation", "FEM",
)  # fmt: skip


_H1, _H6, _NONE = sph.H1(), sph.H6(), sph.NoStabilisation()
_DEFAULT, _SSP_RK3, _TVD_RK2 = default_integrator(), sph.SSPRK3(), sph.TVDRK2()


class Method(Protocol):
    """What cases and tables need of a method; ``cells`` are node spacings per metre."""

    @property
    def label(self) -> str:
        """Its name in tables and figures."""
        ...

    @property
    def family(self) -> str:
        """One of the families above."""
        ...

    @property
    def setting(self) -> dict[str, str]:
        """Columns ``formulation, stabilisation, projection, integrator``."""
        ...

    def lattice(self, cells: int) -> int:
        """The cells per metre it is run with where ``cells`` are asked for."""
        ...

    def simulation(self, scene: Scene, cells: int) -> Any:
        """A solver of ``scene`` with ``cells`` node spacings per metre."""
        ...


@dataclass(frozen=True)
class Particles:
    """SPH with the package's defaults in everything that is not named here.

    ``secondary`` says where SUPG is integrated, or that there is none.  With the paper's integrator
    ``tau_F`` and the weighting are the paper's too: one step, as printed.
    """

    formulation: Formulation
    secondary: SecondaryPoints | NoStabilisation = _H1
    integrator: Integrator = _DEFAULT
    projects: bool = True

    @property
    def label(self) -> str:
        """``{p,F} H1``; what is not the default is added."""
        words = [self.formulation.name]
        words += [] if isinstance(self.formulation, sph.Displacement) else [self.secondary.name]
        words += [] if self.integrator == _DEFAULT else [self.integrator.name]
        words += [] if self.projects else ["no projection"]
        return " ".join(words)

    @property
    def family(self) -> str:
        """By stabilisation and integrator."""
        if self.secondary == _NONE:
            return PLAIN
        if self.integrator == _TVD_RK2:
            return PAPER
        return DENSE if self.secondary == _H6 else MIXED

    @property
    def setting(self) -> dict[str, str]:
        """Its options by name."""
        plain = self.secondary == _NONE
        return {
            "formulation": self.formulation.name,
            "stabilisation": "none" if plain else f"SUPG-{self.secondary.name}",
            "projection": "local" if self.projects else "none",
            "integrator": self.integrator.name,
        }

    def lattice(self, cells: int) -> int:
        """Any lattice serves."""
        return cells

    def stabilisation(self, scene: Scene) -> Stabilisation:
        """The default for the formulation and the material, at these secondary points."""
        if isinstance(self.secondary, NoStabilisation):
            return self.secondary
        chosen = default_stabilisation(self.formulation, scene.material)
        if self.integrator == _TVD_RK2:
            chosen = sph.SUPG(tau_F=1.0, xi_F=0.0, tau_p=chosen.tau_p)
        return replace(chosen, secondary=self.secondary)

    def simulation(self, scene: Scene, cells: int) -> sph.Simulation:
        """Particles ``1/cells`` apart."""
        return sph.Simulation(
            scene,
            spacing=1.0 / cells,
            formulation=self.formulation,
            stabilisation=self.stabilisation(scene),
            integrator=self.integrator,
            angular_momentum=sph.LocalProjection() if self.projects else sph.NoProjection(),
        )


@dataclass(frozen=True)
class Elements:
    """Explicit finite elements; ``edge`` is how many node spacings an element edge spans."""

    label: str
    element: Element
    edge: int = 1

    @property
    def family(self) -> str:
        """Finite elements."""
        return FEM

    @property
    def setting(self) -> dict[str, str]:
        """They have one option: the element."""
        return {
            "formulation": self.label, "stabilisation": "-", "projection": "-",
            "integrator": "central differences",
        }  # fmt: skip

    def lattice(self, cells: int) -> int:
        """Next multiple of the node spacings of an edge."""
        return self.edge * -(-cells // self.edge)

    def simulation(self, scene: Scene, cells: int) -> fem.Simulation:
        """Nodes ``1/cells`` apart."""
        return fem.Simulation(scene, spacing=1.0 / cells, element=self.element)


PF, PFJ, PFHJ, DISPLACEMENT = sph.PF(), sph.PFJ(), sph.PFHJ(), sph.Displacement()
B_BAR = "B-bar FEM"
#: The methods that are compared; a line here is all that a new one needs.
COMPARED: tuple[Method, ...] = (
    Particles(PF),
    Particles(PFJ),
    Particles(PFHJ),
    Particles(PF, _H6),
    Particles(PFJ, _H6),
    Particles(PF, _NONE),
    Particles(DISPLACEMENT, _NONE),
    Particles(PF, integrator=_SSP_RK3),
    Particles(PFJ, integrator=_SSP_RK3),
    Particles(PF, integrator=_TVD_RK2),
    Particles(PFJ, integrator=_TVD_RK2),
    Elements(B_BAR, fem.BBarHex()),
    Elements("Taylor-Hood FEM", fem.TaylorHoodHex(), edge=2),
)
#: Formulation x stabilisation x projection: what each option costs and gives.
OPTIONS: tuple[Method, ...] = (
    *(
        Particles(formulation, secondary, projects=projects)
        for formulation in (PF, PFJ, PFHJ)
        for secondary in (_NONE, _H1, _H6)
        for projects in (True, False)
    ),
    Particles(DISPLACEMENT, _NONE),
)
METHODS: dict[str, Method] = {method.label: method for method in (*OPTIONS, *COMPARED)}
#: What may be recommended: the package's integrator and projection, any formulation.
CANDIDATES = tuple(
    method.label
    for method in COMPARED
    if isinstance(method, Particles) and method.integrator == _DEFAULT
)
#: Methods whose limits make the reference of the column, one of each kind.
REFERENCES = (B_BAR, "{p,F,J} H1")


def goes_finest(method: Method, nu: float) -> bool:
    """Whether a method is run on the cube's finest lattice, the dearest runs of the study.

    Elements of any kind are; of the particles {p,F,J}, and {p,F} where the solid is compressible,
    with H1 and the package's own integrators.
    """
    if not isinstance(method, Particles):
        return True
    fields = (PF, PFJ) if nu < 0.45 else (PFJ,)
    mine = method.integrator == _DEFAULT
    return mine and method.family == MIXED and method.projects and method.formulation in fields
