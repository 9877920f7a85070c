"""Which spectra are asked for: one choice changed at a time, and maps over h/dx and CFL."""

from __future__ import annotations

from typing import Any

import pandas as pd

from sphsolid import NeoHookean
from sphsolid.defaults import (
    H_OVER_DX_DISORDERED,
    H_OVER_DX_LATTICE,
    default_integrator,
    default_stabilisation,
)
from studies.harness.cases import Case, Row
from studies.stability.spectrum_cases import FORMULATIONS

#: The options of one spectrum; {p,F,J} near incompressibility.  ``tau_F`` is in ``tau_unit``, which
#: is ``h/c_p`` (a time of the mesh) or ``dt``.
DEFAULT: dict[str, Any] = {
    "integrator": default_integrator().name,
    "formulation": "{p,F,J}",
    "secondary": "H1",
    "operator": "Consistent",
    "smoothing": "Wendland C2",
    "h_over_dx": H_OVER_DX_LATTICE,
    "weighting": "self-adjoint",
    "tau_unit": "h/c_p",
    "tau_F": 0.5,
    "xi_F": 0.0,
    "tau_p": 0.1,
    "nu": 0.495,
    "jitter": 0.0,
    "stretch": 1.0,
}


def chosen(**changes: Any) -> dict[str, Any]:
    """``DEFAULT`` with ``changes``; times that are not given are the package's for that solid."""
    options = DEFAULT | changes
    material = NeoHookean.from_young(
        young_modulus=17.0e6, poisson_ratio=options["nu"], density=1100.0
    )
    formulation = FORMULATIONS[options["formulation"]]
    supg = default_stabilisation(formulation, material)
    tau_F, tau_p = supg.intrinsic_times["tau_F"], supg.intrinsic_times["tau_p"]
    assert (tau_F.unit, tau_p.unit) == (DEFAULT["tau_unit"], "dt")
    times = {"tau_F": tau_F.c, "tau_p": tau_p.c}
    if options["secondary"] == "none":
        times["tau_p"] = 0.0
    return options | times | changes


_PRINTED: dict[str, Any] = {"weighting": "printed", "tau_unit": "dt", "tau_p": 0.1}
#: What scans are made around; a name for it in tables and figures.  ``printed`` was the default
#: before the self-adjoint weighting.
VERLET, RK3, PRINTED, PAPER = "position Verlet", "SSP-RK3", "SSP-RK3, printed", "TVD-RK2, paper"
BASES: dict[str, dict[str, Any]] = {
    VERLET: {},
    RK3: {"integrator": "SSP-RK3"},
    PRINTED: {"integrator": "SSP-RK3", "tau_F": 0.5} | _PRINTED,
    PAPER: {"integrator": "TVD-RK2", "tau_F": 1.0, "xi_F": 0.1} | _PRINTED,
}
_PF: dict[str, Any] = {"formulation": "{p,F}", "tau_p": 0.0}
SCANS: dict[str, dict[str, dict[str, Any]]] = {
    "base": {"base": {}},
    "formulation": {"{p,F}": _PF, "{p,F}, nu 0.3": _PF | {"nu": 0.3}},
    "stabilisation": {"H6": {"secondary": "H6"}, "none": {"secondary": "none", "tau_p": 0.0}},
    "operator": {name: {"operator": name} for name in ("Literal", "Consistent(force)")},
    "smoothing": {"cubic spline": {"smoothing": "cubic spline"}},
    "tau_F": {
        f"tau_F {value:g}, {{p,F}}": _PF | {"tau_F": value} for value in (0.1, 0.25, 1.0, 2.0)
    },
    "xi_F": {f"xi_F {value:g}": {"xi_F": value} for value in (0.1, 0.5)},
    "tau_p": {f"tau_p {value:g}": {"tau_p": value} for value in (0.05, 0.5)},
    "nu": {
        f"nu {value:g}, tau_p 0.1": {"nu": value, "tau_p": 0.1}
        for value in (0.3, 0.45)
    },
    "jitter": {"jitter 0.2, h/dx 0.9": {"jitter": 0.2, "h_over_dx": H_OVER_DX_DISORDERED}},
    "stretch": {f"stretch {value:g}": {"stretch": value} for value in (2.0,)},
}
#: Methods of the maps.
METHODS: dict[str, dict[str, Any]] = {
    "{p,F} H1, nu 0.3": {"formulation": "{p,F}", "nu": 0.3},
    "{p,F,J} H1, nu 0.495": {},
    "TVD-RK2, paper, nu 0.495": BASES[PAPER],
}
#: Poisson's ratios of the table of limits, for the default stabilisation of each integrator.
RATIOS = (0.0, 0.3, 0.4, 0.45, 0.495, 0.499, 0.4999)
SUPPORTS = (0.7, 0.77, 0.85, 1.0)
#: Scans made around other bases too; the others change nothing there that matters.
_OF: dict[str, tuple[str, ...]] = {
    RK3: ("base",), PRINTED: ("base", "tau_F", "nu"), PAPER: ("base", "nu"),
}  # fmt: skip
#: Points along an edge of a block: its corners decide, and they are the same from four on.
_SIDE = 4
_QUICK = ("base", "H6", "none")
#: Expected seconds of a case, by body.
_COST = {"free": 5.0, "clamped": 4.0, "rollers": 4.0, "interior": 3.0}


def spectrum_cases(quick: bool) -> list[Case]:
    """All cases of the spectral part; the short form keeps small blocks of one base."""
    listed = []
    for base, changes in BASES.items():
        for scan, variants in SCANS.items():
            for variant, change in variants.items():
                if quick and (variant not in _QUICK or base != VERLET):
                    continue
                if scan not in _OF.get(base, (scan,)):
                    continue
                options = chosen(**(changes | change))
                listed += [
                    _case(scan, variant, base, body, _SIDE, options)
                    for body in _bodies(base, scan, options, quick)
                ]
    for method, change in METHODS.items():
        if quick and method != "{p,F,J} H1, nu 0.495":
            continue
        for support in (0.77, 0.9, 1.0) if quick else SUPPORTS:
            options = chosen(**change) | {"h_over_dx": support}
            listed.append(_case("map", f"{support:g}", method, "free", _SIDE, options))
    return listed + ([] if quick else _limits() + _larger())


def _bodies(base: str, scan: str, options: dict[str, Any], quick: bool) -> list[str]:
    if options["stretch"] != 1.0:
        # Under a dead load a free body turns over: no fault of the method.
        return ["clamped", "interior"]
    if scan != "base":
        return ["free"]
    return list(_COST) if base == VERLET and not quick else ["free", "interior"]


def _larger() -> list[Case]:
    """Whether what grows on the small block grows as fast on a larger one."""
    method, side = "{p,F,J} H1, nu 0.495", 6
    labels = {"scan_of": "larger", "variant": method, "base": VERLET, "body": "free"}
    return [
        Case(
            f"spectrum: {method}, free {side}^3",
            "studies.stability.spectrum_cases:large",
            labels | {"cells": [side - 1] * 3} | chosen(),
            cost=40.0,
        )
    ]


def _limits() -> list[Case]:
    """The default settings of every integrator, as ``sphsolid.defaults`` chooses them."""
    listed = []
    for integrator in (VERLET, "SSP-RK3", "TVD-RK2"):
        for nu in RATIOS:
            for formulation in ("{p,F}", "{p,F,J}"):
                options = chosen(integrator=integrator, nu=nu, formulation=formulation)
                if formulation == "{p,F,J}" and options["tau_p"] == 0.0:
                    continue  # That of {p,F}, and so tabulated: see spectrum_tables.
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
        BASES[PRINTED],
        BASES[PAPER],
    ]
    return [
        _case("warm-up", str(n), VERLET, "free", 2, chosen(**change))
        for n, change in enumerate(changes)
    ]


def spectrum_tables(rows: list[Row]) -> dict[str, pd.DataFrame]:
    """``spectrum``: a row per configuration and body; ``spectrum_growth``: one per CFL too.

    ``limits``: the stability limits of the default settings, by integrator and Poisson's ratio.
    Without ``tau_p`` all mixed formulations have one spectrum, which then is that of {p, F}.
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
    known = set(zip(defaults["integrator"], defaults["nu"], defaults["formulation"], strict=True))
    same = defaults[
        [(row.integrator, row.nu, "{p,F,J}") not in known for row in defaults.itertuples()]
    ]
    both = pd.concat([defaults, same.assign(formulation="{p,F,J}")])
    order = {name: place for place, name in enumerate(dict.fromkeys(defaults["integrator"]))}
    both = both.sort_values(
        ["integrator", "nu", "formulation"],
        key=lambda column: column.map(order) if column.name == "integrator" else column,
        ignore_index=True,
    )
    return {"spectrum": limits, "spectrum_growth": growth, "limits": both}
