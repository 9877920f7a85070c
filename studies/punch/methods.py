"""The methods that meet in the punch test, by name."""

from __future__ import annotations

from dataclasses import dataclass

from sphsolid import PFJ
from sphsolid.defaults import default_stabilisation
from sphsolid.scenes import punch
from sphsolid.scheme.intrinsic_time import as_time

#: Name of the finite element runs, which have no operator and no stabilisation.
FEM = "B-bar FEM"
#: The paper's settings of the method, (c) and (d) of its Figs. 10 and 11.
H6_NO_TAU_P = "{p,F,H,J} H6, tau_p 0"
H6 = "{p,F,H,J} H6, tau_p 0.1"
H1 = "{p,F,H,J} H1, tau_p 0.1"
GALERKIN = "{p,F,H,J} without SUPG"
DISPLACEMENT = "displacement SPH"
#: {p,F,J} H1 with everything else left to the package, see :mod:`sphsolid.defaults`.
TOOLKIT = "{p,F,J} by default, tau_p 0.1"
#: Support of 2 spacings with the cubic spline, the usual one of displacement-based codes.
WIDE_NO_TAU_P = "{p,F,H,J} H6, tau_p 0, support 2 dx"
WIDE = "{p,F,H,J} H6, tau_p 0.1, support 2 dx"
TAU_P = (0.0, 0.05, 0.1, 0.2)


@dataclass(frozen=True)
class Method:
    """One method: ``formulation`` and ``secondary`` by name, ``-`` where there is none.

    ``tau_F`` in ``tau_unit``, ``tau_p`` in time steps.  ``wide``: cubic spline, support 2 spacings,
    in the place of the default smoothing function.  ``by_default``: integrator, CFL number and all
    stabilisation but ``tau_p`` are the package's; otherwise ``D(p)`` is weighted as printed and
    the paper's TVD-RK2 runs at CFL 0.3.
    """

    formulation: str = "-"
    secondary: str = "-"
    tau_F: float = 0.0
    tau_unit: str = "dt"
    xi_F: float = 0.0
    tau_p: float = 0.0
    wide: bool = False
    by_default: bool = False


def toolkit(tau_p: float) -> str:
    """Name of {p,F,J} H1 with the package's defaults but for ``tau_p``."""
    return f"{{p,F,J}} by default, tau_p {tau_p:g}"


def whole_tau_F(tau_p: float) -> str:
    """Name of {p,F,J} H1 with ``tau_F = dt``, ``xi_F = 0``, TVD-RK2."""
    return f"{{p,F,J}} H1, tau_F 1, tau_p {tau_p:g}"


def without_tau_F(tau_p: float) -> str:
    """Name of {p,F,J} H1 with ``tau_F = 0``, ``xi_F = 0.1``: ``tau_p`` all but alone."""
    return f"{{p,F,J}} H1, tau_F 0, tau_p {tau_p:g}"


_CHOSEN = default_stabilisation(PFJ(), punch().material)
_TAU_F = as_time(_CHOSEN.tau_F)
METHODS: dict[str, Method] = {
    FEM: Method(),
    DISPLACEMENT: Method("displacement"),
    GALERKIN: Method("{p,F,H,J}"),
    H6_NO_TAU_P: Method("{p,F,H,J}", "H6", tau_F=0.5),
    H6: Method("{p,F,H,J}", "H6", tau_F=0.5, tau_p=0.1),
    H1: Method("{p,F,H,J}", "H1", tau_F=0.5, xi_F=0.1, tau_p=0.1),
    **{
        toolkit(tau_p): Method(
            "{p,F,J}", _CHOSEN.secondary.name, tau_F=_TAU_F.c, tau_unit=_TAU_F.unit,
            xi_F=_CHOSEN.xi_F, tau_p=tau_p, by_default=True,
        )
        for tau_p in TAU_P
    },
    **{whole_tau_F(tau_p): Method("{p,F,J}", "H1", tau_F=1.0, tau_p=tau_p) for tau_p in TAU_P},
    **{without_tau_F(tau_p): Method("{p,F,J}", "H1", xi_F=0.1, tau_p=tau_p) for tau_p in TAU_P},
    WIDE_NO_TAU_P: Method("{p,F,H,J}", "H6", tau_F=0.5, wide=True),
    WIDE: Method("{p,F,H,J}", "H6", tau_F=0.5, tau_p=0.1, wide=True),
}

#: What stands over a picture.
LABELS = {
    FEM: "B-bar FEM",
    DISPLACEMENT: "displacement\nSPH",
    GALERKIN: "{p,F,H,J} SPH\nwithout SUPG",
    H6_NO_TAU_P: "{p,F,H,J} H6\nτ_p = 0",
    H6: "{p,F,H,J} H6\nτ_p = 0.1 dt",
    H1: "{p,F,H,J} H1\nτ_p = 0.1 dt",
    TOOLKIT: "{p,F,J} H1\nby default",
}
