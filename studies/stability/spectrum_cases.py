"""One configuration on one body: growth against CFL, limits, and the name of what grows."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import scipy.optimize

import sphsolid as sph
from sphsolid.cloud import SmoothingFunction
from sphsolid.cloud.operator import OperatorKind
from sphsolid.cloud.secondary import SecondaryPoints
from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, determinant
from sphsolid.defaults import Integrator, default_cfl
from sphsolid.geometry.body import Box
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene
from sphsolid.scheme import AsPrinted, Formulation, SelfAdjoint
from sphsolid.scheme.stabilisation import Weighting
from studies.convergence.cases import TIMES
from studies.stability.spectrum import Linearisation
from studies.stability.spectrum_growth import (
    CFL_OF_BLOCKS,
    NEUTRAL,
    decades,
    largest_modulus,
    limits,
    scan,
)
from studies.stability.spectrum_modes import name_of_wave, shape
from studies.stability.spectrum_symbol import Symbol

FORMULATIONS: dict[str, Formulation] = {
    "{p,F}": sph.PF(),
    "{p,F,J}": sph.PFJ(),
    "{p,F,H,J}": sph.PFHJ(),
    "{p,J}": sph.PJ(),
    "displacement": sph.Displacement(),
}
OPERATORS: dict[str, OperatorKind] = {
    "Consistent": sph.Consistent(),
    "Consistent(force)": sph.Consistent(use="force"),
    "Literal": sph.Literal(),
}
SMOOTHING: dict[str, SmoothingFunction] = {
    "Wendland C2": sph.WendlandC2(),
    "cubic spline": sph.CubicSpline(),
    "quintic spline": sph.QuinticSpline(),
}
SECONDARY: dict[str, SecondaryPoints] = {"H1": sph.H1(), "H6": sph.H6()}
WEIGHTINGS: dict[str, Weighting] = {"printed": AsPrinted(), "self-adjoint": SelfAdjoint()}
BODIES: dict[str, tuple[Constraint, ...]] = {
    "free": (),
    "clamped": (Constraint("Y-", "all"),),
    "rollers": tuple(Constraint(face, "normal") for face in ("X-", "Y-", "Z-")),
    "interior": (),
}
INTEGRATORS: dict[str, Integrator] = {
    each.name: each for each in (sph.TVDRK2(), sph.SSPRK3(), sph.PositionVerlet())
}


def simulation(
    *,
    body: str,
    cells: tuple[int, int, int],
    integrator: str,
    formulation: str,
    secondary: str,
    operator: str,
    smoothing: str,
    h_over_dx: float,
    weighting: str,
    tau_unit: str,
    tau_F: float,
    xi_F: float,
    tau_p: float,
    nu: float,
    jitter: float,
    stretch: float,
) -> sph.Simulation:
    """A box of ``cells`` cubes at rest, stretched along X (free to contract), nothing run.

    ``tau_unit`` says what ``tau_F`` is a number of; ``tau_p`` is one of the step.
    """
    material = sph.NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=nu, density=1100.0)
    across = contraction(material, stretch)
    gradient = np.array([stretch, across, across]) - 1.0
    scene = Scene(
        name=f"{body} block",
        body=Box(upper=(float(cells[0]), float(cells[1]), float(cells[2])), jitter=jitter, seed=1),
        material=material,
        end_time=1.0,
        initial_displacement=lambda X: X * gradient,
        constraints=BODIES[body],
    )
    stabilisation = (
        sph.NoStabilisation()
        if secondary == "none"
        else sph.SUPG(
            tau_F=TIMES[tau_unit](tau_F),
            xi_F=xi_F,
            tau_p=tau_p,
            secondary=SECONDARY[secondary],
            weighting=WEIGHTINGS[weighting],
        )
    )
    return sph.Simulation(
        scene,
        spacing=1.0,
        formulation=FORMULATIONS[formulation],
        stabilisation=stabilisation,
        operator=OPERATORS[operator],
        smoothing=SMOOTHING[smoothing],
        h_over_dx=h_over_dx,
        integrator=INTEGRATORS[integrator],
    )


def usual_cfl(integrator: str) -> float:
    """The CFL number at which modes are named: the default of the integrator."""
    return default_cfl(INTEGRATORS[integrator])


def contraction(material: Any, stretch: float) -> float:
    """Stretch across a uniaxial ``stretch`` for which the sides are free of stress."""
    if stretch == 1.0:
        return 1.0

    def side_stress(across: float) -> float:
        F = (stretch, 0.0, 0.0, 0.0, across, 0.0, 0.0, 0.0, across)
        return float(law.first_piola(material, F, cofactor(F), determinant(F))[4])

    return float(scipy.optimize.brentq(side_stress, 0.2, 3.0, xtol=1.0e-14))


def block(
    *, scan_of: str, variant: str, base: str, body: str, side: int, **options: Any
) -> list[dict[str, Any]]:
    """Dense spectrum of a cube of ``side`` particles: rows over CFL, then one of limits."""
    started = time.perf_counter()
    cells = (side - 1, side - 1, side - 1)
    linear = Linearisation(simulation(body=body, cells=cells, **options))
    known = scan(lambda cfl: largest_modulus(linear.eigenvalues(cfl)), CFL_OF_BLOCKS)
    found = limits(lambda cfl: largest_modulus(linear.eigenvalues(cfl)), known)
    labels = _labels(scan_of, variant, base, body, f"{side}^3", options)
    usual = _named(linear, usual_cfl(options["integrator"]))
    beyond = _named(linear, found["fast"] + 0.05)
    return _rows(labels, known, found, usual, beyond, started)


def interior(
    *, scan_of: str, variant: str, base: str, body: str, side: int, **options: Any
) -> list[dict[str, Any]]:
    """The same for plane waves inside a lattice, ``side`` a full axis of the Brillouin zone."""
    started = time.perf_counter()
    support = SMOOTHING[options["smoothing"]].support * options["h_over_dx"]
    reach = int(np.ceil(support - 1e-9)) - 1
    # Two rows of neighbours within what the consistent operator leaves alone at the boundary.
    cells = 2 * (max(2, 2 * reach) + 2 * reach)
    block_of_cells = simulation(body=body, cells=(cells, cells, cells), **options)
    symbol = Symbol(block_of_cells)
    k = symbol.waves(side)

    def modulus(cfl: float) -> float:
        return largest_modulus(symbol.eigenvalues(k, cfl))

    def named(cfl: float) -> dict[str, Any]:
        g = symbol.eigenvalues(k, cfl)
        size = np.where(np.abs(g - 1.0) < NEUTRAL, 0.0, np.abs(g))
        wave, mode = np.unravel_index(int(np.argmax(size)), size.shape)
        first = ", ".join(f"{part:.2g}" for part in np.abs(k[wave]) / np.pi)
        return {
            "mode": name_of_wave(k[wave]) if size[wave, mode] > 1.0 + 1e-8 else "none",
            "frequency": float(abs(np.angle(g[wave, mode]))) / cfl,
            "where": f"k dx / pi = ({first})",
        }

    known = scan(modulus)
    found = limits(modulus, known)
    labels = _labels(scan_of, variant, base, body, "infinite", options)
    usual = named(usual_cfl(options["integrator"]))
    return _rows(labels, known, found, usual, named(found["fast"] + 0.05), started)


def large(
    *, scan_of: str, variant: str, base: str, body: str, cells: list[int],
    **options: Any,
) -> list[dict[str, Any]]:
    """The spectrum of a larger body at the default CFL number alone."""
    started = time.perf_counter()
    sim = simulation(body=body, cells=(cells[0], cells[1], cells[2]), **options)
    linear = Linearisation(sim)
    cfl = usual_cfl(options["integrator"])
    g, modes = linear.modes(cfl)
    first = int(np.flatnonzero(np.abs(g - 1.0) >= NEUTRAL)[0])
    size = "x".join(str(n + 1) for n in cells)
    labels = _labels(scan_of, variant, base, body, size, options)
    usual = _shape_row(linear, complex(g[first]), modes[:, first], cfl)
    return _rows(labels, {cfl: float(abs(g[first]))}, {}, usual, {}, started)


def _named(linear: Linearisation, cfl: float) -> dict[str, Any]:
    g, modes = linear.modes(cfl)
    moving = np.flatnonzero(np.abs(g - 1.0) >= NEUTRAL)
    first = int(moving[0])
    row = _shape_row(linear, complex(g[first]), modes[:, first], cfl)
    return row | {"neutral": len(g) - len(moving)}


def _shape_row(
    linear: Linearisation, g: complex, mode: np.ndarray[Any, Any], cfl: float
) -> dict[str, Any]:
    u, _, J = linear.fields(mode)
    found = shape(linear.simulation, u, J)
    return {
        "mode": found.name if abs(g) > 1.0 + 1e-8 else "none",
        "frequency": abs(float(np.angle(g))) / cfl,
        "where": f"boundary {found.boundary:.2f}, edges and corners {found.corner:.2f}",
    }


def _labels(
    scan_of: str, variant: str, base: str, body: str, size: str, options: dict[str, Any]
) -> dict[str, Any]:
    labels = {"scan": scan_of, "variant": variant, "base": base, "body": body, "size": size}
    return {"part": "spectrum"} | labels | options


def _rows(
    labels: dict[str, Any],
    known: dict[float, float],
    found: dict[str, float],
    usual: dict[str, Any],
    beyond: dict[str, Any],
    started: float,
) -> list[dict[str, Any]]:
    points = [
        labels | {"kind": "point", "cfl": cfl, "max_g": modulus, "decades": decades(modulus)}
        for cfl, modulus in known.items()
    ]
    cfl = usual_cfl(labels["integrator"])
    summary = labels | {
        "kind": "limit",
        "cfl": cfl,
        "max_g": known[cfl],
        "decades": decades(known[cfl]),
        "rate": float(np.log(known[cfl])) / cfl,
        "mode": usual["mode"],
        "frequency": usual["frequency"],
        "where": usual["where"],
        "neutral": usual.get("neutral"),
        "mode_beyond": beyond.get("mode", ""),
        "wall_s": time.perf_counter() - started,
    }
    summary |= {f"cfl_{name}": value for name, value in found.items()}
    return [*points, summary]


__all__ = ["BODIES", "INTEGRATORS", "block", "contraction", "interior", "large", "simulation"]
