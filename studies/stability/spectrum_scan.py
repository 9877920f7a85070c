"""Which spectra are asked for: one choice changed at a time, and maps over h/dx and CFL."""

from __future__ import annotations

from typing import Any

import pandas as pd

from sphsolid.defaults import NEARLY_INCOMPRESSIBLE
from studies.harness.cases import Case, Row

#: The defaults of the project, {p,F,J} near incompressibility.
DEFAULT: dict[str, Any] = {
    "integrator": "SSP-RK3",
    "formulation": "{p,F,J}",
    "secondary": "H1",
    "operator": "Consistent",
    "smoothing": "Wendland C2",
    "h_over_dx": 0.77,
    "tau_F": 0.5,
    "xi_F": 0.0,
    "tau_p": 0.1,
    "nu": 0.495,
    "jitter": 0.0,
    "stretch": 1.0,
}
#: What every scan is made around; a name for it in tables and figures.
BASES: dict[str, dict[str, Any]] = {
    "SSP-RK3": {},
    "TVD-RK2, paper": {"integrator": "TVD-RK2", "tau_F": 1.0, "xi_F": 0.1},
}
NO_PRESSURE_TERM = {"tau_p": 0.0}
SCANS: dict[str, dict[str, dict[str, Any]]] = {
    "base": {"base": {}},
    "formulation": {
        "{p,F}": {"formulation": "{p,F}"} | NO_PRESSURE_TERM,
        "{p,F}, nu 0.3": {"formulation": "{p,F}", "nu": 0.3} | NO_PRESSURE_TERM,
        "{p,F,H,J}": {"formulation": "{p,F,H,J}"},
        "{p,J}": {"formulation": "{p,J}"},
        "displacement": {"formulation": "displacement"} | NO_PRESSURE_TERM,
    },
    "stabilisation": {
        "H6": {"secondary": "H6"},
        "none": {"secondary": "none"} | NO_PRESSURE_TERM,
    },
    "operator": {name: {"operator": name} for name in ("Literal", "Consistent(force)")},
    "h_over_dx": {f"h/dx {value:g}": {"h_over_dx": value} for value in (0.7, 0.85, 1.0, 1.2)},
    "smoothing": {"cubic spline": {"smoothing": "cubic spline"}},
    "tau_F": {f"tau_F {value:g}": {"tau_F": value} for value in (0.0, 0.1, 0.25, 0.5, 1.0, 2.0)},
    "xi_F": {f"xi_F {value:g}": {"xi_F": value} for value in (0.0, 0.05, 0.1, 0.2, 0.5)},
    "tau_p": {f"tau_p {value:g}": {"tau_p": value} for value in (0.0, 0.05, 0.2, 0.5)},
    "nu": {f"nu {value:g}": {"nu": value} for value in (0.3, 0.4, 0.45, 0.499, 0.4999)},
    "jitter": {"jitter 0.2, h/dx 0.9": {"jitter": 0.2, "h_over_dx": 0.9}},
    "stretch": {f"stretch {value:g}": {"stretch": value} for value in (0.8, 1.5, 2.0)},
}
#: Methods of the maps and of the larger bodies.
METHODS: dict[str, dict[str, Any]] = {
    "{p,F} H1, nu 0.3": {"formulation": "{p,F}", "nu": 0.3} | NO_PRESSURE_TERM,
    "{p,F,J} H1, nu 0.495": {},
    "{p,F,J} H6, nu 0.495": {"secondary": "H6"},
    "TVD-RK2 {p,F,J} H1, nu 0.495": BASES["TVD-RK2, paper"],
}
#: Poisson's ratios of the table of limits, for the default stabilisation of each integrator.
RATIOS = (0.0, 0.3, 0.4, 0.45, 0.495, 0.499, 0.4999)
SUPPORTS = (0.6, 0.7, 0.77, 0.85, 0.9, 1.0, 1.2, 1.5)
#: Scans that look at clamped blocks and blocks on rollers too.
_ON_EVERY_BODY = ("base",)
#: Scans made around the paper's settings too; the others change nothing there that matters.
_OF_THE_PAPER = ("base", "tau_F", "h_over_dx", "nu")
#: Points along an edge of a block: its corners decide, and they are the same from four on.
_SIDE = 4
_QUICK = ("base", "H6", "none", "tau_p 0")
#: Expected seconds of a case, by body.
_COST = {"free": 5.0, "clamped": 4.0, "rollers": 4.0, "interior": 3.0}


def spectrum_cases(quick: bool) -> list[Case]:
    """All cases of the spectral part; the short form keeps small blocks of one base."""
    listed = []
    for base, changes in BASES.items():
        for scan, variants in SCANS.items():
            for variant, change in variants.items():
                if quick and (variant not in _QUICK or base != "SSP-RK3"):
                    continue
                if base != "SSP-RK3" and scan not in _OF_THE_PAPER:
                    continue
                options = DEFAULT | changes | change
                short = quick or scan not in _ON_EVERY_BODY
                bodies = ["free", "interior"] if short else list(_COST)
                if options["jitter"] > 0.0:
                    bodies.remove("interior")
                if options["stretch"] != 1.0:
                    # Under a dead load a free body turns over: no fault of the method.
                    bodies = ["clamped", "interior"]
                for body in bodies:
                    listed.append(_case(scan, variant, base, body, _SIDE, options))
    for method, change in METHODS.items():
        if quick and method != "{p,F,J} H1, nu 0.495":
            continue
        if method == "{p,F,J} H6, nu 0.495":
            continue
        for support in (0.77, 0.9, 1.0) if quick else SUPPORTS:
            options = DEFAULT | change | {"h_over_dx": support}
            for body in ("free", "interior"):
                listed.append(_case("map", f"{support:g}", method, body, _SIDE, options))
    return listed + ([] if quick else _limits() + _larger())


def _larger() -> list[Case]:
    listed = []
    for method, change in METHODS.items():
        bodies = [("clamped", [3, 18, 3])] + ([("free", [8, 8, 8])] if not change else [])
        for body, cells in bodies:
            labels = {"scan_of": "larger", "variant": method, "base": method, "body": body}
            size = "x".join(str(n + 1) for n in cells)
            listed.append(
                Case(
                    f"spectrum: {method}, {body} {size}",
                    "studies.stability.spectrum_cases:large",
                    labels | {"cells": cells} | DEFAULT | change,
                    cost=30.0,
                )
            )
    return listed


def _limits() -> list[Case]:
    listed = []
    for integrator in ("SSP-RK3", "TVD-RK2"):
        for nu in RATIOS:
            # As sphsolid.defaults chooses: tau_p near incompressibility only.
            with_J = 0.1 if nu >= NEARLY_INCOMPRESSIBLE else 0.0
            for formulation, tau_p in (("{p,F}", 0.0), ("{p,F,J}", with_J)):
                change = {"integrator": integrator, "nu": nu} | {"formulation": formulation}
                options = DEFAULT | change | {"tau_p": tau_p}
                variant = f"{formulation}, nu {nu:g}"
                listed.append(_case("limits", variant, integrator, "free", _SIDE, options))
    return listed


def _case(
    scan: str, variant: str, base: str, body: str, side: int, options: dict[str, Any]
) -> Case:
    run = "interior" if body == "interior" else "block"
    labels = {"scan_of": scan, "variant": variant, "base": base, "body": body}
    points = {"side": 13 if body == "interior" else side}
    cost = _COST[body]
    if body == "interior" and options["h_over_dx"] > 1.0:
        cost *= 3.0
    return Case(
        f"spectrum: {scan} {variant}, {base}, {body}",
        f"studies.stability.spectrum_cases:{run}",
        labels | points | options,
        cost=cost,
    )


def spectrum_warm_up() -> list[Case]:
    """Tiny cases that compile every kernel the spectra use."""
    changes: list[dict[str, Any]] = [
        {},
        {"formulation": "{p,F,H,J}"},
        {"formulation": "displacement", "tau_p": 0.0},
    ]
    return [
        _case("warm-up", str(n), "SSP-RK3", "free", 2, DEFAULT | change)
        for n, change in enumerate(changes)
    ]


def spectrum_tables(rows: list[Row]) -> dict[str, pd.DataFrame]:
    """``spectrum``: a row per configuration and body; ``spectrum_growth``: one per CFL too.

    ``limits``: the stability limits of the default settings, by integrator and Poisson's ratio.
    """
    mine = [row for row in rows if row.get("part") == "spectrum"]
    labels = ["scan", "variant", "base", "body", "size", *DEFAULT]
    growth = pd.DataFrame(
        [row for row in mine if row["kind"] == "point"],
        columns=[*labels, "cfl", "max_g", "decades"],
    )
    limits = pd.DataFrame(
        [row for row in mine if row["kind"] == "limit"],
        columns=[*labels, "cfl", "max_g", "decades", "rate", "mode", "frequency", "where",
                 "neutral", "cfl_strict", "cfl_slow", "cfl_fast", "mode_beyond", "wall_s"],
    )  # fmt: skip
    columns = ["integrator", "formulation", "nu", "body", "size", "cfl_strict", "cfl_slow",
               "cfl_fast", "mode_beyond"]  # fmt: skip
    defaults = limits[limits["scan"] == "limits"][columns]
    return {"spectrum": limits, "spectrum_growth": growth, "limits": defaults}
