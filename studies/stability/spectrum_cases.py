"""Which spectra are asked for: one choice changed at a time, and maps over h/dx and CFL."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import scipy.optimize
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

import sphsolid as sph
from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, determinant
from sphsolid.defaults import H_OVER_DX_DISORDERED, NEARLY_INCOMPRESSIBLE, default_cfl
from sphsolid.errors import require
from sphsolid.scenes import Box, Constraint, Scene
from studies.engine.case import Case, Row
from studies.engine.plotting import outside_legend, panels
from studies.engine.results import Results
from studies.methods import PAPER, SUPG, Method
from studies.stability.hard_cases import PRINTED, RK3
from studies.stability.hard_problems import settings, solid
from studies.stability.spectrum import Linearisation, PlaneWaves, brillouin_zone
from studies.stability.spectrum_growth import (
    CFL,
    LIMITS,
    NEUTRAL,
    decades,
    largest_modulus,
    limits,
    name_of_wave,
    scan,
    shape,
)

#: Bodies and what holds them; ``INTERIOR`` are plane waves inside a lattice.
INTERIOR = "interior"
BODIES: dict[str, tuple[Constraint, ...]] = {
    "free": (),
    "clamped": (Constraint("Y-", "all"),),
    "rollers": tuple(Constraint(face, "normal") for face in ("X-", "Y-", "Z-")),
    INTERIOR: (),
}
INTEGRATORS = (sph.PositionVerlet(), sph.SSPRK3(), sph.TVDRK2())
#: Poisson's ratios of the table of limits, for the default stabilisation of each integrator.
RATIOS = (0.0, 0.3, 0.4, 0.45, 0.495, 0.499, 0.4999)
SUPPORTS, QUICK_SUPPORTS = (0.7, 0.77, 0.85, 1.0), (0.77, 0.9, 1.0)
#: Points along an edge of a block: its corners decide, and they are the same from four on.
SIDE, LARGER, ZONE = 4, 6, 13
#: Points along an edge of the block whose interior is looked at.
INNER = 15
#: The paper's settings with fewer fields, which have the same spectrum, and a lower xi_F.
PAPER_SPECTRUM = PAPER.but(
    name="paper, {p,F,J}, xi_F = 0.1", formulation=sph.PFJ(), xi_F=0.1, tau_p=sph.OfStep(0.1)
)
#: What scans are made around.
BASES = (SUPG, RK3, PRINTED, PAPER_SPECTRUM)
_PF = {"formulation": sph.PF(), "tau_p": 0.0}


@dataclass(frozen=True)
class Block:
    """A box of cubes of the columns' solid at rest, stretched along X and free to contract."""

    body: str = "free"
    nu: float = 0.495
    jitter: float = 0.0
    stretch: float = 1.0

    def scene(self, cells: int) -> Scene:
        """With ``cells`` of 1 m along each edge."""
        material = solid(self.nu)
        across = contraction(material, self.stretch)
        gradient = np.array([self.stretch, across, across]) - 1.0
        return Scene(
            name=f"{self.body} block",
            body=Box(upper=(float(cells),) * 3, jitter=self.jitter, seed=1),
            material=material,
            end_time=1.0,
            initial_displacement=lambda X: X * gradient,
            constraints=BODIES[self.body],
        )


def contraction(material: Any, stretch: float) -> float:
    """Stretch across a uniaxial ``stretch`` for which the sides are free of stress."""
    if stretch == 1.0:
        return 1.0

    def side_stress(across: float) -> float:
        F = (stretch, 0.0, 0.0, 0.0, across, 0.0, 0.0, 0.0, across)
        return float(law.first_piola(material, F, cofactor(F), determinant(F))[4])

    return float(scipy.optimize.brentq(side_stress, 0.2, 3.0, xtol=1.0e-14))


# --- one spectrum -------------------------------------------------------------------------------


def spectrum(
    *, scan_of: str, variant: str, base: str, method: Method, block: Block, side: int
) -> list[Row]:
    """Rows over CFL and one of limits, of a cube of ``side`` points or of waves inside it.

    Only the growth at the default CFL number is looked for in the scan ``larger``.
    """
    started = time.perf_counter()
    inside = block.body == INTERIOR
    sim = method.simulation(block.scene((INNER if inside else side) - 1), spacing=1.0)
    linear = Linearisation(sim)
    waves = PlaneWaves(linear, brillouin_zone(side)) if inside else linear
    usual = default_cfl(sim.integrator)

    def modulus(cfl: float) -> float:
        return largest_modulus(waves.eigenvalues(cfl))

    def fastest(cfl: float) -> Row:
        if isinstance(waves, PlaneWaves):
            return _fastest_wave(waves, cfl)
        return _fastest_mode(linear, cfl)

    labels = {
        "part": "spectrum", "scan": scan_of, "variant": variant, "base": base, "body": block.body,
        "size": "infinite" if inside else f"{side}^3", **settings(sim), "nu": block.nu,
        "jitter": block.jitter, "stretch": block.stretch,
    }  # fmt: skip
    if scan_of == "larger":
        known, found = {usual: modulus(usual)}, {}
    else:
        # Blocks are unstable before the last of them.
        known = scan(modulus, CFL if inside else CFL[:10])
        found = limits(modulus, known)
        found = {f"cfl_{name}": value for name, value in found.items()} | {
            "mode_beyond": fastest(found["fast"] + 0.05)["mode"]
        }
    points = [
        labels | {"kind": "point", "cfl": cfl, "max_g": g, "decades": decades(g)}
        for cfl, g in known.items()
    ]
    summary = {
        "kind": "limit", "cfl": usual, "max_g": known[usual], "decades": decades(known[usual]),
        "rate": float(np.log(known[usual])) / usual, **fastest(usual), **found,
        "wall_s": time.perf_counter() - started,
    }  # fmt: skip
    return [*points, labels | summary]


def _fastest_mode(linear: Linearisation, cfl: float) -> Row:
    g, modes = linear.modes(cfl)
    moving = np.flatnonzero(np.abs(g - 1.0) >= NEUTRAL)
    first = int(moving[0])
    u, _, J = linear.fields(modes[:, first])
    found = shape(linear.simulation, u, J)
    where = f"boundary {found.boundary:.2f}, edges and corners {found.corner:.2f}"
    return _named(g[first], found.name, cfl, where) | {"neutral": len(g) - len(moving)}


def _fastest_wave(waves: PlaneWaves, cfl: float) -> Row:
    g = waves.eigenvalues(cfl)
    # Rounded, so that of waves that are equal by symmetry the first is named.
    size = np.round(np.where(np.abs(g - 1.0) < NEUTRAL, 0.0, np.abs(g)), 9)
    wave, mode = np.unravel_index(int(np.argmax(size)), size.shape)
    k = waves.k[wave]
    where = f"k dx / pi = ({', '.join(f'{part:.2g}' for part in np.abs(k) / np.pi)})"
    return _named(g[wave, mode], name_of_wave(k), cfl, where)


def _named(g: complex, name: str, cfl: float, where: str) -> Row:
    mode = name if abs(g) > LIMITS["strict"] else "none"
    return {"mode": mode, "frequency": abs(float(np.angle(g))) / cfl, "where": where}


# --- cases --------------------------------------------------------------------------------------

Variant = tuple[str, str, Mapping[str, Any], Block]


def _variants(base: Method) -> Iterator[Variant]:
    """Scan, name, changes of the method, and the block, of every scan around ``base``."""
    yield "base", "base", {}, Block()
    if base in (SUPG, PRINTED):
        unit = sph.OfStep if base is PRINTED else sph.OfMesh
        for c in (0.1, 0.25, 1.0, 2.0):
            yield "tau_F", f"tau_F {c:g} {unit(c).unit}, {{p,F}}", _PF | {"tau_F": unit(c)}, Block()
    if base is not RK3:
        for nu in (0.3, 0.45):
            changes = {"formulation": sph.PFJ(), "tau_p": sph.OfStep(0.1)}
            yield "nu", f"nu {nu:g}, tau_p 0.1", changes, Block(nu=nu)
    if base is not SUPG:
        return
    yield "formulation", "{p,F}", _PF, Block()
    yield "formulation", "{p,F}, nu 0.3", _PF, Block(nu=0.3)
    yield "stabilisation", "H6", {"secondary": sph.H6()}, Block()
    yield "stabilisation", "none", {"stabilisation": sph.NoStabilisation()}, Block()
    for operator in (sph.Literal(), sph.Consistent(use="force")):
        yield "operator", operator.name, {"operator": operator}, Block()
    yield "smoothing", "cubic spline", {"smoothing": sph.CubicSpline()}, Block()
    for xi in (0.1, 0.5):
        yield "xi_F", f"xi_F {xi:g}", {"xi_F": xi}, Block()
    for c in (0.05, 0.5):
        yield "tau_p", f"tau_p {c:g}", {"tau_p": sph.OfStep(c)}, Block()
    h = H_OVER_DX_DISORDERED
    changes = {"operator": sph.Consistent(), "h_over_dx": h}
    yield "jitter", f"jitter 0.2, h/dx {h:g}", changes, Block(jitter=0.2)
    # Under a dead load a free body turns over: no fault of the method.
    for body in ("clamped", INTERIOR):
        yield "stretch", "stretch 2", {}, Block(body, stretch=2.0)
    for body in ("clamped", "rollers"):
        yield "base", "base", {}, Block(body)


def spectrum_cases(*, quick: bool) -> Iterator[Case]:
    """All cases of the spectral part; the short form keeps small blocks of one base."""
    for base in BASES[:1] if quick else BASES:
        for what, variant, changes, block in _variants(base):
            if not quick or (variant in ("base", "H6", "none") and block == Block()):
                method = base.but(name=base.name, **changes)
                yield _case(what, variant, base.name, method, block)
        yield _case("base", "base", base.name, base, Block(INTERIOR))
    maps = ((SUPG, 0.495), (SUPG.but(formulation=sph.PF()), 0.3), (PAPER_SPECTRUM, 0.495))
    for method, nu in maps[:1] if quick else maps:
        for h in QUICK_SUPPORTS if quick else SUPPORTS:
            name = f"{method.name}, nu {nu:g}"
            yield _case("map", f"{h:g}", name, method.but(h_over_dx=h), Block(nu=nu))
    if quick:
        return
    for integrator in INTEGRATORS:
        for nu in RATIOS:
            for formulation in (sph.PF(), sph.PFJ()):
                # Without tau_p that of {p,F}, and so tabulated: see spectrum_tables.
                if formulation.evolves_J and nu < NEARLY_INCOMPRESSIBLE:
                    continue
                method = SUPG.but(integrator=integrator, formulation=formulation)
                variant = f"{formulation.name}, nu {nu:g}"
                yield _case("limits", variant, integrator.name, method, Block(nu=nu))
    # Whether what grows on the small block grows as fast on a larger one.
    yield _case("larger", "base", SUPG.name, SUPG, Block(), LARGER)


def _case(
    what: str, variant: str, base: str, method: Method, block: Block, side: int = 0
) -> Case:
    arguments = {
        "scan_of": what, "variant": variant, "base": base, "method": method, "block": block,
        "side": side or (ZONE if block.body == INTERIOR else SIDE),
    }  # fmt: skip
    key = f"spectrum: {what} {variant}, {base}, {block.body}"
    return Case(key, spectrum, arguments, cost=40.0 if what == "larger" else 5.0)


def tiny_spectra() -> Iterator[Case]:
    """Every kernel that the spectra use."""
    for base in (SUPG, PRINTED, PAPER_SPECTRUM):
        yield _case("warm-up", "base", base.name, base, Block(), 2)


_LABELS = (
    "scan", "variant", "base", "body", "size", "formulation", "stabilisation", "operator",
    "h_over_dx", "integrator", "nu", "jitter", "stretch",
)  # fmt: skip
_POINT = (*_LABELS, "cfl", "max_g", "decades")
_LIMIT = (
    *_POINT, "rate", "mode", "frequency", "where", "neutral", "cfl_strict", "cfl_slow", "cfl_fast",
    "mode_beyond", "wall_s",
)  # fmt: skip
_OF_DEFAULTS = (
    "integrator", "formulation", "nu", "body", "size", "cfl_strict", "cfl_slow", "cfl_fast",
    "mode_beyond",
)  # fmt: skip


def spectrum_tables(rows: list[Row]) -> dict[str, pd.DataFrame]:
    """``spectrum``: a row per configuration and body; ``spectrum_growth``: one per CFL too.

    ``limits``: the stability limits of the default settings, by integrator and Poisson's ratio.
    Without ``tau_p`` all mixed formulations have one spectrum, which then is that of {p,F}.
    """
    mine = [row for row in rows if row.get("part") == "spectrum"]
    growth = pd.DataFrame([r for r in mine if r["kind"] == "point"], columns=[*_POINT])
    found = pd.DataFrame([r for r in mine if r["kind"] == "limit"], columns=[*_LIMIT])
    listed = []
    for _, rows_of in found[found["scan"] == "limits"].groupby(["base", "nu"], sort=False):
        part = rows_of[[*_OF_DEFAULTS]]
        if len(part) == 1:
            part = pd.concat([part, part.assign(formulation=sph.PFJ().name)])
        listed.append(part.sort_values("formulation"))
    empty = pd.DataFrame(columns=[*_OF_DEFAULTS])
    defaults = pd.concat(listed, ignore_index=True) if listed else empty
    return {"spectrum": found, "spectrum_growth": growth, "limits": defaults}


# --- figures ------------------------------------------------------------------------------------

#: Added before the logarithm: growth below it is round-off.
FLOOR = 1.0e-8


def map_figure(results: Results) -> Figure:
    """``log10(max |g| - 1)`` over CFL and h/dx; lines: tenfold in 1000 and in 50 steps."""
    table = results.tables["spectrum_growth"]
    table = table[table["scan"] == "map"]
    require(len(table) > 0, "no map was computed: run studies.stability without --part hard")
    bases = list(dict.fromkeys(table["base"]))
    figure, axes = panels(1, len(bases), width=3.1, height=2.7)
    for ax, base in zip(axes[0], bases, strict=True):
        image = _map(ax, table[table["base"] == base])
        ax.set(title=f"{base}\nfree block", xlabel="CFL [-]", ylabel="h/dx [-]")
    bar = figure.colorbar(image, ax=axes.ravel().tolist(), shrink=0.8, extend="both")
    bar.set_label("log10(max |g| - 1)   [-]")
    return figure


def _map(ax: Axes, part: pd.DataFrame) -> Any:
    value = part.pivot_table(index="h_over_dx", columns="cfl", values="max_g")
    excess = np.log10(np.maximum(value.to_numpy(float) - 1.0, 0.0) + FLOOR)
    places, cfl = np.arange(len(value.index)), value.columns.to_numpy(float)
    colours = ListedColormap(colormaps["viridis"](np.linspace(0.05, 1.0, 16)))
    image = ax.pcolormesh(
        cfl, places, excess, cmap=colours, vmin=-8.0, vmax=0.0, shading="nearest"
    )
    if min(excess.shape) > 1:
        levels = [np.log10(LIMITS[name] - 1.0) for name in ("slow", "fast")]
        ax.contour(cfl, places, excess, levels, colors="black", linewidths=[0.8, 1.6],
                   linestyles="solid")  # fmt: skip
    ax.set_yticks(places, [f"{h:g}" for h in value.index])
    ax.grid(False)
    return image


def scans(limits: pd.DataFrame) -> pd.DataFrame:
    """The rows of the scans around the bases."""
    return limits[~limits["scan"].isin(["map", "larger", "limits"])]


def limits_figure(results: Results) -> Figure:
    """CFL limits of every variant on a free block."""
    table = scans(results.tables["spectrum"])
    table = table[table["body"] == "free"]
    require(len(table) > 0, "no scan was computed: run studies.stability without --part hard")
    variants = list(dict.fromkeys(table["variant"]))
    figure, axes = panels(1, 1, width=6.4, height=max(2.4, 0.3 * len(variants)))
    ax = axes[0, 0]
    for number, base in enumerate(BASES):
        part = table[table["base"] == base.name]
        if not len(part):
            continue
        shift = 0.16 * (number - 0.5 * (len(BASES) - 1))
        y = np.array([variants.index(variant) for variant in part["variant"]]) + shift
        ax.hlines(y, part["cfl_slow"], part["cfl_fast"], color=base.colour, linewidth=1.0)
        look = {"color": base.colour, "marker": base.marker, "linestyle": "", "markersize": 4.0}
        ax.plot(part["cfl_slow"], y, markerfacecolor="white", **look)
        ax.plot(part["cfl_fast"], y, **look, label=base.name)
    ax.set_yticks(range(len(variants)), variants)
    ax.set(title="free block", xlabel="CFL limit [-]", xlim=(-0.03, 1.05))
    ax.set_ylim(len(variants) - 0.4, -0.6)
    outside_legend(figure, [ax], columns=2)
    return figure


def default_limits_figure(results: Results) -> Figure:
    """Slow and fast limit over Poisson's ratio, a panel an integrator; dotted: default CFL."""
    table = results.tables["limits"]
    require(len(table) > 0, "no limits were computed: run studies.stability without --quick")
    figure, axes = panels(1, table["integrator"].nunique(), width=2.5, height=2.4)
    ratios = sorted(set(table["nu"]))
    usual = {each.name: default_cfl(each) for each in INTEGRATORS}
    for ax, (name, mine) in zip(axes[0], table.groupby("integrator", sort=False), strict=True):
        for formulation, part in mine.groupby("formulation"):
            place = [ratios.index(nu) for nu in part["nu"]]
            look = SUPG.look | {"linestyle": "-" if formulation == sph.PFJ().name else "--"}
            ax.plot(place, part["cfl_slow"], **look, markerfacecolor="white")
            ax.plot(place, part["cfl_fast"], **look, label=str(formulation))
        ax.axhline(usual[str(name)], color="0.5", linewidth=0.8, linestyle=":")
        ax.set_xticks(range(len(ratios)), [f"{nu:g}" for nu in ratios], rotation=60)
        ax.set(title=str(name), xlabel="Poisson's ratio [-]", ylim=(0.0, 1.02))
    axes[0, 0].set_ylabel("CFL limit, free block [-]")
    outside_legend(figure, axes.flat, columns=2)
    return figure
