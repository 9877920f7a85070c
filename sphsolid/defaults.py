"""What a simulation uses where nothing is given, and the evidence for it.

Every value comes from a study that can be run again; ``docs/stability.md`` has the reasoning.

* **Integrator**: SSP-RK3.  With the paper's two stages an undamped mode grows by ``(w dt)^4 / 8``
  a step, and there is one at every free corner that SUPG-H1 does not see (``studies.stability``).
* **CFL** 0.5: every hard case runs to its end with it.  A free block at rest has modes that grow
  slowly there when nearly incompressible; ``plan()`` prints the limits (``studies.stability``).
* **h/dx**: the smallest support is the most accurate one that is solvable: 19 neighbours on a
  lattice (``studies.operators``, ``studies.stability``).
* **tau_F = 0.5 dt**: ``D(p)`` is not a positive form; it damps only while ``tau_F`` is shorter
  than about ``0.3 h / c_p`` (the paper's ``dt`` at CFL 0.3), and makes energy beyond: half of the
  longer SSP-RK3 step (``studies.stability``).  **xi_F = 0**: a time-integrated residual costs the
  stress its second order at boundaries (``studies.convergence``).  **tau_p = 0.1 dt** where ``J``
  is evolved and the solid nearly incompressible: the paper's; on a fine twisting column it takes
  the alternating part out of the pressure (``studies.twisting_column``), at smaller ``nu`` it makes
  energy (``studies.stability``).
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.ssp_rk3 import SSPRK3
from sphsolid.scheme.stabilisation import SUPG
from sphsolid.scheme.tvd_rk2 import TVDRK2

Integrator = TVDRK2 | SSPRK3

#: Smoothing length over spacing (Wendland C2: support 1.54 and 1.8 spacings).
H_OVER_DX_LATTICE = 0.77
H_OVER_DX_DISORDERED = 0.9

#: Poisson's ratio from which ``tau_p`` is used.
NEARLY_INCOMPRESSIBLE = 0.45

_CFL = {TVDRK2: 0.3, SSPRK3: 0.5}

#: Where the modes of a free lattice block at rest grow, with the settings of this file: data, made
#: from ``reports/stability/limits.csv`` (a test compares them).
LIMITS = Path(__file__).with_name("stability_limits.csv")


@dataclass(frozen=True)
class StabilityLimit:
    """CFL numbers above which a mode grows tenfold in 1000 (``slow``) or 50 (``fast``) steps."""

    slow: float
    fast: float


def default_cfl(integrator: Integrator) -> float:
    """CFL number of an integrator; 0.3 is the paper's for its own."""
    return _CFL[type(integrator)]


def default_h_over_dx(is_lattice: bool) -> float:
    """Smoothing length over spacing."""
    return H_OVER_DX_LATTICE if is_lattice else H_OVER_DX_DISORDERED


def poisson_ratio(material: Any) -> float:
    """``nu = (3 kappa - 2 mu) / (6 kappa + 2 mu)`` of the undeformed solid."""
    mu, kappa = material.mu, material.kappa
    return float((3.0 * kappa - 2.0 * mu) / (6.0 * kappa + 2.0 * mu))


def default_stabilisation(formulation: Formulation, material: Any) -> SUPG:
    """``SUPG(tau_F=0.5, xi_F=0)``; ``tau_p = 0.1`` where ``J`` is evolved and ``nu >= 0.45``."""
    damps_J = formulation.evolves_J and poisson_ratio(material) >= NEARLY_INCOMPRESSIBLE
    return SUPG(tau_F=0.5, xi_F=0.0, tau_p=0.1 if damps_J else 0.0)


def stability_limit(
    integrator: Integrator, formulation: Formulation, material: Any
) -> StabilityLimit:
    """Measured limit of the default settings: that of the next larger Poisson's ratio tried."""
    law = "{p,F,J}" if formulation.evolves_J else "{p,F}"
    with LIMITS.open(encoding="utf-8", newline="") as file:
        rows = [
            (float(row["nu"]), StabilityLimit(float(row["slow"]), float(row["fast"])))
            for row in csv.DictReader(file)
            if (row["integrator"], row["formulation"]) == (integrator.name, law)
        ]
    rows.sort(key=lambda row: row[0])
    nu = poisson_ratio(material)
    return next((limit for ratio, limit in rows if ratio >= nu - 1e-9), rows[-1][1])
