"""The methods of the twisting column by the names they have in tables, and how runs are chosen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from sphsolid import PFJ, SSPRK3
from sphsolid.defaults import default_cfl, default_stabilisation
from sphsolid.scenes import twisting_column
from studies.convergence.figures import select

NU = 0.495
#: The paper's lattices have 4x19x4, 5x25x5, 6x31x6 particles; the ultra-fine one is not published.
PAPER_LATTICES = (3, 4, 5)
ULTRA_FINE = 10
H1, H6 = "SUPG-SPH H1 (paper)", "SUPG-SPH H6 (paper)"
#: ``Simulation(scene, spacing=..., formulation=PFJ())`` with nothing else given.
TOOLKIT = "default {p,F,J}"
NO_TAU_P = f"{TOOLKIT}, tau_p = 0"
LITERAL, LITERAL_H6 = f"{H1}, Literal", f"{H6}, Literal"
FORCE = f"{H1}, Consistent(force)"
DISPLACEMENT = "displacement SPH"
FEM = "B-bar FEM"
#: Added to the name of a method whose tau_F and tau_p keep their seconds when the step is changed.
KEPT = ", tau kept"

PAPER_RK2 = "TVD-RK2"
_SUPG = {
    "method": "SUPG-SPH", "secondary": "H1", "operator": "Consistent", "tau_F": 1.0,
    "integrator": PAPER_RK2,
}  # fmt: skip
_PAPER_H1 = _SUPG | {"formulation": "{p,F,H,J}", "xi_F": 0.2, "tau_p": 0.1}
_PAPER_H6 = _PAPER_H1 | {"secondary": "H6", "xi_F": 0.0}
_CHOSEN = default_stabilisation(PFJ(), twisting_column().material)
_TOOLKIT = _SUPG | {
    "formulation": "{p,F,J}", "integrator": "default", "tau_F": _CHOSEN.tau_F,
    "xi_F": _CHOSEN.xi_F, "tau_p": _CHOSEN.tau_p,
}  # fmt: skip
_CLASSICAL = {
    "secondary": "-", "tau_F": 0.0, "xi_F": 0.0, "tau_p": 0.0, "integrator": PAPER_RK2,
}  # fmt: skip
_DISPLACEMENT = _CLASSICAL | {"method": "displacement SPH", "formulation": "displacement"}
METHODS: dict[str, Mapping[str, Any]] = {
    H1: _PAPER_H1,
    H6: _PAPER_H6,
    TOOLKIT: _TOOLKIT,
    NO_TAU_P: _TOOLKIT | {"tau_p": 0.0},
    "default {p,F}": _TOOLKIT | {"formulation": "{p,F}", "tau_p": 0.0},
    "SUPG-SPH {p,F,J} H1, RK2": _SUPG | {"formulation": "{p,F,J}", "xi_F": 0.0, "tau_p": 0.1},
    LITERAL: _PAPER_H1 | {"operator": "Literal"},
    LITERAL_H6: _PAPER_H6 | {"operator": "Literal"},
    FORCE: _PAPER_H1 | {"operator": "Consistent(force)"},
    f"{TOOLKIT}, Consistent(force)": _TOOLKIT | {"operator": "Consistent(force)"},
    DISPLACEMENT: _DISPLACEMENT | {"operator": "Consistent"},
    f"{DISPLACEMENT}, Literal": _DISPLACEMENT | {"operator": "Literal"},
    FEM: _CLASSICAL
    | {"method": "B-bar FEM", "formulation": "-", "operator": "-", "integrator": "-"},
}


def lattice(cells: int) -> str:
    """Particles of the lattice with ``cells`` cells per metre: 3 is 4x19x4."""
    return f"{cells + 1}x{6 * cells + 1}x{cells + 1}"


def usual_cfl(label: str) -> float:
    """The paper's 0.3 for its scheme, the package's own for its defaults, 0.6 for elements."""
    if label == FEM:
        return 0.6
    chosen = METHODS[label.removesuffix(KEPT)]["integrator"]
    return 0.3 if chosen == PAPER_RK2 else default_cfl(SSPRK3())


def usual(frame: pd.DataFrame, nu: float = NU) -> pd.DataFrame:
    """Rows at the usual step."""
    step = frame["label"].map({label: usual_cfl(label) for label in METHODS})
    return frame[(frame["cfl"] == step) & (frame["nu"] == nu)]


def finest(frame: pd.DataFrame, label: str = FEM) -> int:
    """The most cells per metre that a method was run with."""
    return int(select(usual(frame), label=label)["cells"].max())


def common_lattice(frame: pd.DataFrame) -> int:
    """The lattice on which methods are compared: 6x31x6 where most were run on it."""
    counts = usual(frame).groupby("cells")["label"].nunique()
    wide = counts[counts >= 0.7 * counts.max()].index
    return 5 if 5 in wide else int(max(wide))
