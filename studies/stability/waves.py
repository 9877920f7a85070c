"""Small motions that a sound method keeps: a free vibration, and a pulse three spacings wide."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.sparse.linalg import eigsh
from skfem import Basis, BilinearForm, ElementHex2, ElementVector, MeshHex
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

from sphsolid.continuum.wave_speed import reference_p_wave_speed
from sphsolid.errors import require
from sphsolid.record import Energy, Snapshot
from sphsolid.scenes import Box, Constraint, Scene
from studies.engine.case import Case, Row
from studies.engine.claims import Claim
from studies.engine.plotting import outside_legend, panels
from studies.engine.results import Results, Tables
from studies.measures.run import run
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE, SUPG, Method
from studies.stability.hard_cases import LONG_METHODS
from studies.stability.hard_problems import DENSITY, YOUNG, Measured, solid

Array = NDArray[np.float64]
#: The vibrating block: ``WIDTH x HEIGHT x WIDTH`` [m], clamped at ``Y = 0``.
WIDTH, HEIGHT = 0.5, 1.0
#: Elements across a quarter of the block; twice as many along it.
LEVELS = (2, 3, 4)
#: Amplitude of the vibration [m], so small that the solid answers linearly.
AMPLITUDE = 1.0e-4
PERIODS, RECORDS_A_PERIOD = 10, 40
#: Half of the base of the pulse is its width at half height; in spacings, as are the length along
#: the bar and across it, where the pulse starts and how far it travels.
PULSE_WIDTH, BAR, ACROSS, START, TRAVEL = 3.0, 40, 2, 8, 24
#: Speed in the pulse over that of the wave.
PULSE_SPEED = 1.0e-5
VIBRATION_NU, PULSE_NU = (0.3, 0.495), (0.0, 0.495)
#: Energy that a mode must keep for ten periods, and largest error of its frequency.
LEAST_LEFT, MOST_OFF = 0.98, 0.02
#: Asked of the package default: damping ratio on 1/8, and error of the frequency by cells a metre.
DAMPING = {0.3: 1.0e-4, 0.495: 1.0e-3}
OFF = {(0.3, 8): 0.01, (0.495, 8): 0.02, (0.3, 16): 0.003, (0.495, 16): 0.003}
#: A pulse may be off by this many times what it is with B-bar elements.
AS_ELEMENTS = 1.25


# --- the mode: linear elasticity, elements of 27 nodes, K u = omega^2 M u -----------------------


@dataclass(frozen=True)
class Mode:
    """``omega`` [rad/s] on the finest mesh and ``limit`` of the sequence, and the mode's shape.

    One quarter of the block is solved, between the middle planes and two faces: the motion along X
    is even in both, so the mode is unique.
    """

    omega: float
    limit: float
    basis: Basis
    values: Array

    def __call__(self, X: Array) -> Array:
        """Displacement ``(n, 3)`` at ``X (n, 3)`` [m], largest component one."""
        x, z = X[:, 0] - 0.5 * WIDTH, X[:, 2] - 0.5 * WIDTH
        inside = np.stack([np.abs(x), X[:, 1], np.abs(z)])
        found = (self.basis.probes(inside) @ self.values).reshape(3, -1).T
        sign = np.stack([np.ones_like(x), np.sign(x), np.sign(x) * np.sign(z)], axis=1)
        return np.asarray(sign * found / np.max(np.abs(self.values)))


@cache
def lowest_mode(poisson_ratio: float) -> Mode:
    """The lowest bending mode; its limit by the order that three meshes show (Richardson)."""
    found = [_solved(poisson_ratio, count) for count in LEVELS]
    a, b, c = (omega for omega, _, _ in found)
    n = np.array(LEVELS, dtype=float)
    # omega + C / count^p: the p that gives the ratio of the changes.
    orders = np.linspace(0.5, 6.0, 5501)
    power = n[:, None] ** -orders
    ratio = (power[0] - power[1]) / (power[1] - power[2])
    p = orders[np.argmin(np.abs(ratio - (a - b) / (b - c)))]
    limit = c - (b - c) * n[2] ** -p / (n[1] ** -p - n[2] ** -p)
    return Mode(c, float(limit), *found[-1][1:])


def _solved(poisson_ratio: float, count: int) -> tuple[float, Basis, Array]:
    """Elements become smaller towards the clamp and the outer edges: the stress is singular."""
    across = 0.5 * WIDTH * np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, count + 1))
    along = HEIGHT * np.linspace(0.0, 1.0, 2 * count + 1) ** 1.7
    mesh = MeshHex.init_tensor(across, along, across)
    basis = Basis(mesh, ElementVector(ElementHex2()), intorder=5)
    K = linear_elasticity(*lame_parameters(YOUNG, poisson_ratio)).assemble(basis)
    M = BilinearForm(lambda u, v, w: DENSITY * dot(u, v)).assemble(basis)
    held = np.unique(np.concatenate([
        basis.get_dofs(lambda x: np.isclose(x[1], 0.0)).all(),
        basis.get_dofs(lambda x: np.isclose(x[0], 0.0)).all(["u^2", "u^3"]),
        basis.get_dofs(lambda x: np.isclose(x[2], 0.0)).all(["u^3"]),
    ]))  # fmt: skip
    free = basis.complement_dofs(held)
    # From a vector of its own the iteration would end elsewhere each time, in the ninth digit.
    start = np.ones(len(free))
    square, shape = eigsh(K[free][:, free], k=1, M=M[free][:, free], sigma=0.0, v0=start)
    values = np.zeros(basis.N)
    values[free] = shape[:, 0]
    return float(np.sqrt(square[0])), basis, values


# --- runs ---------------------------------------------------------------------------------------


def vibrating_block(nu: float) -> Scene:
    """The clamped block in its lowest bending mode, for :data:`PERIODS` periods."""
    mode = lowest_mode(nu)
    return Scene(
        name="vibrating_block",
        body=Box((0.0, 0.0, 0.0), (WIDTH, HEIGHT, WIDTH)),
        material=solid(nu),
        end_time=PERIODS * 2.0 * math.pi / mode.limit,
        initial_velocity=lambda X: AMPLITUDE * mode.limit * mode(X),
        constraints=(Constraint("Y-", "all"),),
        provenance="Ours: the lowest mode of the column's solid.",
    )


def vibration(*, method: Method, nu: float, cells: int) -> list[Row]:
    """The clamped block's lowest bending mode, started as it is, for :data:`PERIODS` periods."""
    solver = method.simulation(vibrating_block(nu), spacing=1.0 / cells)
    named = {"part": "vibration", "method": method.name, "nu": nu, "cells": cells}
    return [named | vibration_of(solver, nu)]


def vibration_of(solver: Any, nu: float) -> Row:
    """Run ``solver`` of :func:`vibrating_block` to its end.

    ``energy_left`` over that at the start; ``damping_ratio = -ln(energy_left) / (2 omega t)``;
    ``frequency_error`` relative to the limit of quadratic elements, from the passages through rest.
    Of a run that diverged, what there was at its last record, and no frequency.
    """
    mode = lowest_mode(nu)
    shape = mode(solver.placement().mesh.vertices)

    def modal(shot: Snapshot) -> float:
        weight = shot.V[:, None] * shape
        return float(np.sum(weight * shot.velocity) / np.sum(weight * shape))

    end = solver.scene.end_time
    every = end / (PERIODS * RECORDS_A_PERIOD)
    ran = run(solver, until=end, every=every, record=[Energy(), Measured({"modal": modal})])
    energy, t = ran.history["total_energy [J]"].to_numpy(), ran.history["time [s]"].to_numpy()
    left = float(energy[-1] / energy[0])
    omega = _frequency(t, ran.history["modal"].to_numpy()) if ran.survived else math.nan
    return {
        "omega": omega, "omega_reference": mode.limit, "omega_finest": mode.omega,
        "frequency_error": omega / mode.limit - 1.0, "energy_left": left,
        "damping_ratio": -math.log(max(left, 1e-300)) / (2.0 * mode.limit * end),
        **ran.columns(),
    }  # fmt: skip


def _frequency(t: Array, q: Array) -> float:
    """From the first and the last passage of ``q`` through zero [rad/s]; nan with less than two."""
    at = np.flatnonzero(q[:-1] * q[1:] < 0.0)
    if len(at) < 2:
        return math.nan
    zero = t[at] - q[at] * (t[at + 1] - t[at]) / (q[at + 1] - q[at])
    return float(math.pi * (len(at) - 1) / (zero[-1] - zero[0]))


@dataclass(frozen=True)
class Pulse:
    """``v_x = v_0 cos^2(pi s / 2 w)`` for ``|s| < w``, ``s = X - X_0 - c t``.

    ``w`` [m] is the width at half height.
    """

    speed: float
    width: float
    start: float

    def velocity(self, X: Array, t: float) -> Array:
        """``(n, 3)`` [m/s] at time ``t`` [s]."""
        s = np.clip(X[:, 0] - self.start - self.speed * t, -self.width, self.width)
        return self._along_x(np.cos(0.5 * np.pi * s / self.width) ** 2)

    def displacement(self, X: Array) -> Array:
        """``-1/c`` of the integral of the velocity ``(n, 3)`` [m]: all of it runs to the right."""
        s = np.clip(X[:, 0] - self.start, -self.width, self.width)
        w = self.width
        integral = 0.5 * (s + w) + 0.5 * w / np.pi * np.sin(np.pi * s / w)
        return self._along_x(-integral / self.speed)

    def _along_x(self, value: Array) -> Array:
        field = np.zeros((len(value), 3))
        field[:, 0] = PULSE_SPEED * self.speed * value
        return field


def pulse_wave(nu: float, h: float) -> Pulse:
    """The exact solution of :func:`pulse_in_a_bar`."""
    return Pulse(reference_p_wave_speed(solid(nu)), PULSE_WIDTH * h, START * h)


def pulse_in_a_bar(nu: float, h: float, *, across: float | None = None) -> Scene:
    """A velocity pulse in a bar held at its sides, as :data:`TRAVEL` lengths of ``h`` [m] take.

    In the linear limit it keeps its shape, ``v = f(X - c_p t)``.  The bar is :data:`ACROSS` lengths
    of ``across`` [m] wide, of ``h`` where nothing is said.
    """
    wave = pulse_wave(nu, h)
    wide = ACROSS * (h if across is None else across)
    return Scene(
        name="pulse_in_a_bar",
        body=Box((0.0, 0.0, 0.0), (BAR * h, wide, wide)),
        material=solid(nu),
        end_time=TRAVEL * h / wave.speed,
        initial_velocity=lambda X: wave.velocity(X, 0.0),
        initial_displacement=wave.displacement,
        constraints=tuple(Constraint(face, "normal") for face in ("Y-", "Y+", "Z-", "Z+")),
        provenance="Ours: d'Alembert's solution in the linear limit.",
    )


def pulse(*, method: Method, nu: float, cells: int) -> list[Row]:
    """A pulse three spacings wide that runs along a bar by :data:`TRAVEL` spacings."""
    h = 1.0 / cells
    named = {"part": "pulse", "method": method.name, "nu": nu, "cells": cells}
    return [named | pulse_of(method.simulation(pulse_in_a_bar(nu, h), spacing=h), nu, h)]


def pulse_of(solver: Any, nu: float, h: float) -> Row:
    """Run ``solver`` of :func:`pulse_in_a_bar` to its end.

    ``energy_left`` over that at the start; ``width`` of ``v^2`` (root mean square about its centre)
    and ``lag`` of its centre, in lengths of ``h`` [m], and ``error``: root mean square of ``v``
    less the exact one, over the exact one.
    """
    until = solver.scene.end_time
    ran = run(solver, until=until, every=until, record=[Energy()])
    energy, end = ran.history["total_energy [J]"].to_numpy(), solver.snapshot()
    v, exact = end.velocity[:, 0], pulse_wave(nu, h).velocity(end.X, end.time)[:, 0]
    centre, width = _spread(end.X[:, 0], end.V * v**2)
    right, narrow = _spread(end.X[:, 0], end.V * exact**2)
    return {
        "energy_left": float(energy[-1] / energy[0]), "width": width / h,
        "width_reference": narrow / h, "lag": (right - centre) / h,
        "error": float(np.sqrt(np.sum(end.V * (v - exact) ** 2) / np.sum(end.V * exact**2))),
        **ran.columns(),
    }  # fmt: skip


def _spread(X: Array, weight: Array) -> tuple[float, float]:
    centre = np.average(X, weights=weight)
    return float(centre), float(np.sqrt(np.average((X - centre) ** 2, weights=weight)))


# --- cases, tables, claims ----------------------------------------------------------------------


def wave_cases(*, quick: bool) -> Iterator[Case]:
    """The mode of the block on 1/8, 1/12 and 1/16, and the pulse; coarse and few in short."""
    two = (PACKAGE, SUPG, B_BAR)
    for nu in VIBRATION_NU[:1] if quick else VIBRATION_NU:
        runs = [(4, two)] if quick else [(8, LONG_METHODS), (12, two), (16, two)]
        for cells, methods in runs:
            for method in methods:
                cost = 1.0e-3 * cells**4 * (4.0 if nu > 0.4 else 1.0)
                yield _case(vibration, method, nu, cells, cost)
    for nu in PULSE_NU[:1] if quick else PULSE_NU:
        for method in two if quick else LONG_METHODS:
            yield _case(pulse, method, nu, 10, 1.0)


def _case(run_wave: Any, method: Method, nu: float, cells: int, cost: float) -> Case:
    key = f"{run_wave.__name__}, nu {nu:g}, 1/{cells}: {method.name}"
    return Case(key, run_wave, {"method": method, "nu": nu, "cells": cells}, cost)


_OF_RUN = ("survived", "diverged_at", "where", "why", "folded", "steps", "wall_s")
COLUMNS = {
    "vibration": (
        "method", "nu", "cells", "energy_left", "damping_ratio", "omega", "omega_reference",
        "omega_finest", "frequency_error", *_OF_RUN,
    ),
    "pulse": (
        "method", "nu", "cells", "energy_left", "error", "lag", "width", "width_reference",
        *_OF_RUN,
    ),
}  # fmt: skip


def wave_tables(rows: list[Row]) -> dict[str, pd.DataFrame]:
    """``vibration`` and ``pulse``, a row a run."""
    return {
        part: pd.DataFrame([row for row in rows if row.get("part") == part], columns=[*columns])
        for part, columns in COLUMNS.items()
    }


def wave_claims(tables: Tables) -> list[Claim]:
    """Of the package default and of self-adjoint SUPG, beside elements."""
    of_both = [claim for method in (PACKAGE, SUPG) for claim in _as_elements(tables, method)]
    return [*_default_claims(tables), *of_both]


def _as_elements(tables: Tables, method: Method) -> Iterator[Claim]:
    """Energy and frequency of the vibration, and the error of the pulse."""
    ours, theirs = (select(tables["vibration"], method=m.name) for m in (method, B_BAR))
    kept = (ours["energy_left"] >= LEAST_LEFT) & (ours["frequency_error"].abs() <= MOST_OFF)
    parts = [
        f"nu {row.nu:g} on 1/{row.cells}: {row.energy_left:.1%} left, frequency "
        f"{row.frequency_error:+.1%}"
        for row in ours.itertuples()
    ]
    beside = [f"{row.energy_left:.1%}, {row.frequency_error:+.1%}" for row in theirs.itertuples()]
    yield Claim.counted(
        "a free vibration keeps its energy and its frequency", int(kept.sum()), len(ours),
        said="; ".join(parts) + (f" ({B_BAR.name}: {'; '.join(beside)})" if beside else ""),
        wanted=f"{LEAST_LEFT:.0%} of the energy, frequency within {MOST_OFF:.0%}",
        where=method.name,
    )  # fmt: skip
    yield Claim(
        "a pulse three spacings wide arrives as with elements: its error over theirs",
        _over_elements(tables["pulse"], method), "<=", AS_ELEMENTS, where=method.name,
    )  # fmt: skip


def _over_elements(pulses: pd.DataFrame, method: Method) -> dict[str, float]:
    """Error of the pulse over that of elements, by Poisson's ratio."""
    error = pulses.pivot_table(index="nu", columns="method", values="error")
    if not {method.name, B_BAR.name} <= set(error):
        return {}
    ratio = error[method.name] / error[B_BAR.name]
    return {f"nu {nu:g}": float(value) for nu, value in ratio.items()}


def _default_claims(tables: Tables) -> Iterator[Claim]:
    """What is asked of the package default alone, by Poisson's ratio and spacing."""
    runs = tables["vibration"].set_index(["method", "nu", "cells"])
    known = [key for key in OFF if (PACKAGE.name, *key) in runs.index]
    ours = {key: runs.loc[(PACKAGE.name, *key)] for key in known}
    damping = {nu: float(ours[nu, 8]["damping_ratio"]) for nu in DAMPING if (nu, 8) in ours}
    yield Claim(
        "damping ratio of a free vibration on 1/8",
        {f"nu {nu:g}": value for nu, value in damping.items()}, "<=",
        {f"nu {nu:g}": DAMPING[nu] for nu in damping}, where=PACKAGE.name, format=".1e",
    )  # fmt: skip
    names = {key: f"nu {key[0]:g} on 1/{key[1]}" for key in known}
    theirs = {
        name: f"{runs.loc[(B_BAR.name, *key)]['frequency_error']:+.2%}"
        for key, name in names.items() if (B_BAR.name, *key) in runs.index
    }  # fmt: skip
    said = "; ".join(
        f"{name}: {ours[key]['frequency_error']:+.2%} ({B_BAR.name} {theirs.get(name, '-')})"
        for key, name in names.items()
    )
    yield Claim(
        "frequency of a free vibration, off by",
        {name: abs(float(ours[key]["frequency_error"])) for key, name in names.items()}, "<=",
        {name: OFF[key] for key, name in names.items()}, where=PACKAGE.name, said=said,
        format=".1%",
    )  # fmt: skip
    yield Claim(
        "error of a pulse three spacings wide over that of elements",
        _over_elements(tables["pulse"], PACKAGE), "<=", 1.0, where=PACKAGE.name, format=".2f",
    )  # fmt: skip


#: Where a bar is cut, with its value above it [%]: one that grew a millionfold would leave
#: nothing of the others.
_TALLEST = 125.0


def vibration_figure(results: Results) -> Figure:
    """Energy left after ten periods, and frequency error: a bar a method, a group a case."""
    table = results.tables["vibration"]
    require(len(table) > 0, "no vibration was run: run studies.stability without --part")
    groups = list(dict.fromkeys(zip(table["nu"], table["cells"], strict=True)))
    figure, axes = panels(1, 2, width=3.6, height=2.9)
    measures = {"energy_left": "energy left after ten periods [%]",
                "frequency_error": "frequency error [%]"}  # fmt: skip
    for ax, (column, label) in zip(axes[0], measures.items(), strict=True):
        for shift, method in enumerate(LONG_METHODS):
            part = table[(table["method"] == method.name) & (table["survived"] == True)]  # noqa: E712
            if not len(part):
                continue
            at = [groups.index(key) for key in zip(part["nu"], part["cells"], strict=True)]
            wide = 0.8 / len(LONG_METHODS)
            place = np.array(at) + wide * (shift - 0.5 * (len(LONG_METHODS) - 1))
            height = 100.0 * part[column].to_numpy(dtype=float)
            cut = np.minimum(height, _TALLEST)
            ax.bar(place, cut, width=0.95 * wide, color=method.colour, label=method.name)
            for x, value in zip(place, height, strict=True):
                if value > _TALLEST:
                    ax.annotate(f"{value:.0e}", (x, _TALLEST), ha="center", va="bottom", fontsize=7)
        ax.set_xticks(range(len(groups)), [f"nu {nu:g}\n1/{cells}" for nu, cells in groups])
        ax.set_ylabel(label)
        ax.axhline(0.0, color="black", linewidth=0.6)
        ax.grid(visible=False, axis="x")
    outside_legend(figure, axes[0], columns=2)
    return figure
