"""Who is compared, and the options of each on each scene, as their own papers set them."""

from __future__ import annotations

from dataclasses import dataclass

import sphsolid as sph
from studies.methods import (
    B_BAR,
    C_TOUCH,
    DISPLACEMENT,
    HOURGLASS,
    HOURGLASS_AS_SHIPPED,
    JST,
    NODAL_PRESSURE,
    PACKAGE,
    PAPER,
    PG_FEM,
    PG_FEM_HEX,
    Q1,
    SUPG,
    TAYLOR_HOOD,
    UNSTABILISED,
    UPWIND,
    UPWIND_LIMITED,
    Method,
)

CUBE, COLUMN, PUNCH = "cube", "column", "punch"


@dataclass(frozen=True)
class Contender:
    """A method under one name and look, with its options on each scene.

    ``cube``, ``column`` and ``punch`` are the same method as each scene sets it.  ``slow``: its
    kernels are not compiled through, so its runs are long ones.
    """

    cube: Method
    column: Method
    punch: Method
    slow: bool = False

    @property
    def name(self) -> str:
        """In every table."""
        return self.cube.name

    def on(self, scene: str) -> Method:
        """The method with the options of a scene."""
        return {CUBE: self.cube, COLUMN: self.column, PUNCH: self.punch}[scene]


def same(method: Method, *, slow: bool = False) -> Contender:
    """One that has the same options everywhere."""
    return Contender(method, method, method, slow)


#: Figs. 5, 11 and 15 of [Lee2017]: {p,F,H,J} with H1.
_FIG_5 = PAPER.but(
    name="paper's SUPG", label="paper's SUPG {p,F,H,J}, H1", formulation=sph.PFHJ(), xi_F=0.1,
)  # fmt: skip
_FIG_11 = _FIG_5.but(name=_FIG_5.name, tau_F=sph.OfStep(0.5), tau_p=sph.OfStep(0.1))
_FIG_15 = _FIG_5.but(name=_FIG_5.name, xi_F=0.2, tau_p=sph.OfStep(0.1))
PAPERS = Contender(_FIG_5, _FIG_15, _FIG_11)


def _printed(method: Method) -> Method:
    return method.but(
        name="paper's SUPG, printed", label="paper's SUPG, operator as printed", line=":",
        operator=sph.Literal(),
    )  # fmt: skip


PRINTED = Contender(_printed(_FIG_5), _printed(_FIG_15), _printed(_FIG_11))
#: The same figures: {p,F,H,J} without ``D(J)`` on the cube and with it on the punch, {p,F} on the
#: column.
_JST_FIG_5 = JST.but(name=JST.name, formulation=sph.PFHJ())
JSTS = Contender(
    _JST_FIG_5,
    JST.but(name=JST.name, formulation=sph.PF()),
    _JST_FIG_5.but(name=JST.name, stabilisation=sph.JST(eps_J4=1.0 / 32.0)),
)
UPWINDS = same(UPWIND.but(name=UPWIND.name, formulation=sph.PFHJ()))
LIMITED = same(UPWIND_LIMITED.but(name=UPWIND_LIMITED.name, formulation=sph.PFHJ()))
PLAIN = same(
    UNSTABILISED.but(
        name=UNSTABILISED.name, label="{p,F,H,J}, not stabilised", formulation=sph.PFHJ()
    )
)
DEFAULT, SELF_ADJOINT, CLASSICAL = same(PACKAGE), same(SUPG), same(DISPLACEMENT)
CONTROLLED, SHIPPED = same(HOURGLASS), same(HOURGLASS_AS_SHIPPED)
ELEMENTS, QUADRATIC, FULL = same(B_BAR), same(TAYLOR_HOOD), same(Q1)
NODAL = same(NODAL_PRESSURE)
PETROV = same(PG_FEM, slow=True)
PETROV_HEX = same(PG_FEM_HEX, slow=True)
TOUCH = same(C_TOUCH, slow=True)

PARTICLES = (
    DEFAULT, SELF_ADJOINT, PAPERS, PRINTED, JSTS, UPWINDS, LIMITED, CONTROLLED, SHIPPED, CLASSICAL,
    PLAIN,
)  # fmt: skip
MESHES = (ELEMENTS, QUADRATIC, FULL, NODAL, PETROV, PETROV_HEX, TOUCH)
CONTENDERS = (*PARTICLES, *MESHES)
BY_NAME = {one.name: one for one in CONTENDERS}
#: Meshes whose twist of the column must come to one value: locking-free and quadratic elements,
#: the paper's finite elements and finite volumes.
AGREEING = (ELEMENTS, QUADRATIC, PETROV, TOUCH)
#: What the paper says of itself in order: the best first, equal ones in one group.
PAPERS_ORDER = ((PAPERS.name, PETROV.name), (JSTS.name,), (CLASSICAL.name,))
#: Formulations of the peers beside those that the paper's figures have.
FORMULATIONS = (sph.PF(), sph.PFJ(), sph.PFHJ())


#: Without its dissipation, each in its integrator, kernel and step: what a stabilisation adds.
BARE = {
    PAPERS.name: PAPER.but(
        name="paper's SUPG, bare", formulation=sph.PFHJ(), stabilisation=sph.NoStabilisation()
    ),
    JSTS.name: JST.but(
        name="JST-SPH, bare", formulation=sph.PFHJ(), stabilisation=sph.NoStabilisation()
    ),
}


def variants() -> tuple[Method, ...]:
    """JST and none with each formulation; JST with its transpose, which is ours; both bare."""
    made = [
        base.but(formulation=formulation)
        for base in (JST, UNSTABILISED)
        for formulation in FORMULATIONS
    ]
    adjoint = sph.JST(weighting=sph.SelfAdjoint())
    return (*made, JST.but(formulation=sph.PFHJ(), stabilisation=adjoint), *BARE.values())
