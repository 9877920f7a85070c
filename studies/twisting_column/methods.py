"""The methods of the twisting column by the names they have in tables, and how runs are chosen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from sphsolid import PF, PFJ, SSPRK3, TVDRK2
from sphsolid.defaults import (
    Integrator,
    default_cfl,
    default_integrator,
    default_stabilisation,
)
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
#: The same with three evaluations a step, at its own CFL number.
THREE_STAGES = f"{TOOLKIT}, SSP-RK3"
LITERAL, LITERAL_H6 = f"{H1}, Literal", f"{H6}, Literal"
FORCE = f"{H1}, Consistent(force)"
DISPLACEMENT = "displacement SPH"
FEM = "B-bar FEM"
#: Added to the name of a method whose tau_F and tau_p keep their seconds when the step is changed.
KEPT = ", tau kept"

INTEGRATORS: dict[str, Integrator] = {
    one.name: one for one in (TVDRK2(), SSPRK3(), default_integrator())
}
PAPER_RK2 = TVDRK2().name
AS_PRINTED, SELF_ADJOINT = "as printed", "self-adjoint"
_SUPG = {
    "method": "SUPG-SPH", "secondary": "H1", "operator": "Consistent", "weighting": AS_PRINTED,
    "tau_F": 1.0, "tau_unit": "dt", "integrator": PAPER_RK2,
}  # fmt: skip
_PAPER_H1 = _SUPG | {"formulation": "{p,F,H,J}", "xi_F": 0.2, "tau_p": 0.1}
_PAPER_H6 = _PAPER_H1 | {"secondary": "H6", "xi_F": 0.0}


def by_default(
    formulation: PF | PFJ, integrator: Integrator | None = None, nu: float = NU
) -> dict[str, Any]:
    """What the package chooses of the stabilisation."""
    integrator = default_integrator() if integrator is None else integrator
    material = twisting_column(poisson_ratio=nu).material
    chosen = default_stabilisation(formulation, material)
    tau_F, tau_p = chosen.intrinsic_times["tau_F"], chosen.intrinsic_times["tau_p"]
    return _SUPG | {
        "formulation": formulation.name, "integrator": integrator.name,
        "weighting": SELF_ADJOINT if chosen.is_self_adjoint else AS_PRINTED,
        "tau_F": tau_F.c, "tau_unit": tau_F.unit, "xi_F": chosen.xi_F, "tau_p": tau_p.c,
    }  # fmt: skip


_TOOLKIT = by_default(PFJ())
_CLASSICAL = {
    "secondary": "-", "weighting": "-", "tau_F": 0.0, "tau_unit": "-", "xi_F": 0.0,
    "tau_p": 0.0,
    "integrator": PAPER_RK2,
}  # fmt: skip
_DISPLACEMENT = _CLASSICAL | {"method": "displacement SPH", "formulation": "displacement"}
METHODS: dict[str, Mapping[str, Any]] = {
    H1: _PAPER_H1,
    H6: _PAPER_H6,
    TOOLKIT: _TOOLKIT,
    NO_TAU_P: _TOOLKIT | {"tau_p": 0.0},
    THREE_STAGES: by_default(PFJ(), SSPRK3()),
    "default {p,F}": by_default(PF()),
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
    """The package's for the integrator, which is the paper's 0.3 for its own; 0.6 for elements."""
    if label == FEM:
        return 0.6
    return default_cfl(INTEGRATORS[METHODS[label.removesuffix(KEPT)]["integrator"]])


def settings(label: str, nu: float = NU) -> dict[str, Any]:
    """The options of a method; what is left to the package depends on Poisson's ratio."""
    return by_default(PFJ(), nu=nu) if label == TOOLKIT else dict(METHODS[label])


def usual(frame: pd.DataFrame, nu: float = NU) -> pd.DataFrame:
    """Rows at the usual step."""
    step = frame["label"].map({label: usual_cfl(label) for label in METHODS})
    return frame[(frame["cfl"] == step) & (frame["nu"] == nu)]


def finest(frame: pd.DataFrame, label: str = FEM) -> int:
    """The most cells per metre that a method was run with."""
    return int(select(usual(frame), label=label)["cells"].max())


def finest_of(frame: pd.DataFrame, *labels: str) -> int:
    """The most cells per metre that all these methods were run with; 0 where there is none."""
    part = usual(frame)
    shared = set.intersection(*(set(select(part, label=label)["cells"]) for label in labels))
    return int(max(shared, default=0))


def common_lattice(frame: pd.DataFrame) -> int:
    """The lattice on which methods are compared: 6x31x6 where most were run on it."""
    counts = usual(frame).groupby("cells")["label"].nunique()
    wide = counts[counts >= 0.7 * counts.max()].index
    return 5 if 5 in wide else int(max(wide))
