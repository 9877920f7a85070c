"""What a simulation uses where nothing is given, and the evidence for it.

Every value comes from a study that can be run again; ``docs/stability.md`` has the reasoning.

* **Integrator**: SSP-RK3.  With the paper's two stages an undamped mode grows by ``(w dt)^4 / 8``
  a step, and there is one at every free corner that SUPG-H1 does not see (``studies.stability``).
* **CFL**: the largest round number below the stability limit of every material tried.
* **h/dx**: the smallest support is the most accurate one that is solvable: 19 neighbours on a
  lattice (``studies.operators``, ``studies.stability``).
* **tau_F = 0.5 dt**: ``D(p)`` is not a positive form; it damps only while ``tau_F`` is shorter
  than about ``0.3 h / c_p`` (the paper's ``dt`` at CFL 0.3), and makes energy beyond: half of the
  longer SSP-RK3 step (``studies.stability``).  **xi_F = 0**: a time-integrated residual costs the
  stress its second order at boundaries (``studies.convergence``).  **tau_p = 0.1 dt** where ``J``
  is evolved and the solid nearly incompressible: the paper's; it takes the checkerboard out of the
  pressure (``studies.punch``), but makes energy at smaller ``nu`` (``studies.stability``).
"""

from __future__ import annotations

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

#: Largest stable CFL of a free lattice block with the settings of this file, by integrator and
#: Poisson's ratio: data, copied from ``reports/stability/limits.csv`` (a test compares them).
LIMITS = Path(__file__).with_name("stable_cfl.csv")


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


def stable_cfl(integrator: Integrator, material: Any) -> float:
    """Measured stability limit of the default settings: that of the next larger ``nu`` tried."""
    rows = [line.split(",") for line in LIMITS.read_text(encoding="utf-8").split()[1:]]
    limits = {float(nu): float(cfl) for name, nu, cfl in rows if name == integrator.name}
    nu = poisson_ratio(material)
    above = [limits[ratio] for ratio in sorted(limits) if ratio >= nu - 1e-9]
    return above[0] if above else min(limits.values())
