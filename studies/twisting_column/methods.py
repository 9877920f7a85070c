"""The methods of the twisting column, and how runs are chosen from its tables."""

from __future__ import annotations

import pandas as pd

import sphsolid as sph
from studies.measures.tables import select
from studies.methods import B_BAR, DISPLACEMENT, PACKAGE, PAPER, SUPG, Method, Times
from studies.twisting_column.runs import NU

#: The paper's lattices have 4x19x4, 5x25x5, 6x31x6 particles; the ultra-fine one is not published.
PAPER_LATTICES, ULTRA_FINE = (3, 4, 5), 10
_TAU_P = 0.1
#: The paper's two settings, with its tau_p.
H1 = PAPER.but(
    name="paper, {p,F,H,J}, H1", formulation=sph.PFHJ(), secondary=sph.H1(), xi_F=0.2,
    tau_p=sph.OfStep(_TAU_P),
)  # fmt: skip
H6 = H1.but(
    name="paper, {p,F,H,J}, H6", line="--", marker="^", secondary=sph.H6(), xi_F=0.0,
)  # fmt: skip
DEFAULT, PLAIN, FEM = PACKAGE, SUPG, B_BAR
RK3 = PLAIN.but(integrator=sph.SSPRK3())
NO_TAU_P = PLAIN.but(tau_p=0.0, line=":", marker="v")
LITERAL, LITERAL_H6 = (
    one.but(operator=sph.Literal(), line=":", marker="x") for one in (H1, H6)
)
FORCE = H1.but(operator=sph.Consistent(use="force"), line="-.", marker="+")
#: In the paper's integrator and step, as all classical methods of the paper.
CLASSICAL = DISPLACEMENT.but(
    name="displacement SPH, TVD-RK2", integrator=sph.TVDRK2(), cfl=0.3
)
METHODS: tuple[Method, ...] = (
    H1,
    H6,
    DEFAULT,
    PLAIN,
    NO_TAU_P,
    RK3,
    PLAIN.but(formulation=sph.PF()),
    PAPER.but(formulation=sph.PFJ(), tau_p=sph.OfStep(_TAU_P)),
    LITERAL,
    LITERAL_H6,
    FORCE,
    PLAIN.but(operator=sph.Consistent(use="force")),
    CLASSICAL,
    CLASSICAL.but(operator=sph.Literal()),
    FEM,
)
#: Where both of the paper's settings ran they are compared with each other.
PAIRS = ((H1.name, H6.name), (LITERAL.name, LITERAL_H6.name))
#: Lines of the methods in the figures.
SHOWN = (H1, H6, DEFAULT, PLAIN, NO_TAU_P, LITERAL, FORCE, CLASSICAL, FEM)


def in_seconds(method: Method, factor: float) -> Method:
    """With ``factor`` times the intrinsic times of the step: those of a step so much shorter.

    The default has none.
    """
    if method in (H1, H6):
        return method.but(
            name=method.name, tau_F=sph.OfStep(factor), tau_p=sph.OfStep(_TAU_P * factor)
        )
    has_tau_p = method not in (NO_TAU_P, DEFAULT)
    return method.but(name=method.name, tau_p=Times(factor)) if has_tau_p else method


def usual(frame: pd.DataFrame, nu: float = NU) -> pd.DataFrame:
    """Rows at the usual step."""
    return frame[frame["usual"].astype(bool) & (frame["nu"] == nu)]


def finest_of(frame: pd.DataFrame, *methods: str) -> int:
    """The most cells per metre that all these methods were run with; 0 where there is none."""
    part = usual(frame)
    shared = set.intersection(*(set(select(part, method=name)["cells"]) for name in methods))
    return int(max(shared, default=0))


def common_lattice(frame: pd.DataFrame) -> int:
    """The lattice on which methods are compared: 6x31x6 where most were run on it."""
    counts = usual(frame).groupby("cells")["method"].nunique()
    wide = counts[counts >= 0.7 * counts.max()].index
    return 5 if 5 in wide else int(max(wide))
