"""Which runs the conservation study makes: groups of cases, each with what it changes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sphsolid.defaults import default_cfl, default_integrator
from sphsolid.scenes.l_shaped_block import PUBLISHED_SPACING
from studies.conservation.measures import DEFAULTS
from studies.harness.cases import Case

FORMULATIONS = ("{p,F}", "{p,F,J}", "{p,F,H,J}")
OPERATORS = ("Literal", "Consistent")
#: Nominal spacings [m] of the L-shaped block: 425 particles, nearest to the published 388, and
#: 1323.
SPACINGS = (PUBLISHED_SPACING, 0.5)
END = 20.0
#: Instants [s] of the pictures.
SHOT_TIMES = (2.5, 5.0, 10.0, 15.0, 20.0)
SPIN = 105.0
#: Slow enough for the ten turns to be a long run: ten times the steps, a hundredth of the energy.
SLOW_SPIN = 10.5
CFLS = (0.3, 0.15, 0.075)
USUAL_CFL = default_cfl(default_integrator())
#: Those of the runs that are left to the package; 0 for its own.
PACKAGE_CFLS = (0.0, USUAL_CFL / 2.0, USUAL_CFL / 4.0)
#: The setting of [Lee2017] Figs. 7 and 8; the support is ours.
PAPER: dict[str, Any] = {
    "method": "SUPG-SPH",
    "formulation": "{p,F}",
    "secondary": "H6",
    "operator": "Literal",
    "projection": "local",
    "spacing": PUBLISHED_SPACING,
    "h_over_dx": 0.9,
    "cfl": 0.3,
    "tau_F": 1.0,
    "tau_unit": "dt",
    "xi_F": 0.0,
    "tau_p": 0.0,
    "weighting": "as printed",
    "integrator": "TVD-RK2",
}
ELEMENTS: dict[str, Any] = PAPER | {
    "method": "B-bar FEM",
    **dict.fromkeys(
        ("formulation", "secondary", "operator", "weighting", "integrator", "tau_unit"), "-"
    ),
    "projection": "none",
    "cfl": 0.6,
    **dict.fromkeys(("h_over_dx", "tau_F", "xi_F", "tau_p"), 0.0),
}
#: Everything left to the package but spacing and formulation.
PACKAGE: dict[str, Any] = ELEMENTS | {
    "method": DEFAULTS,
    "formulation": "{p,F}",
    "projection": "local",
    "cfl": 0.0,
}
CUBE: dict[str, Any] = PAPER | {"secondary": "H1", "operator": "Consistent", "spacing": 0.25}
#: What is changed, one at a time, to see which choices the block survives.
_CHANGES: tuple[dict[str, Any], ...] = (
    {"cfl": 0.6}, {"cfl": 0.9}, {"h_over_dx": 0.77}, {"h_over_dx": 1.0}, {"h_over_dx": 1.2},
    {"xi_F": 0.1}, {"tau_F": 0.1}, {"integrator": "SSP-RK3"}, {"integrator": "position Verlet"},
    {"weighting": "self-adjoint"}, {"secondary": "-", "tau_F": 0.0},
    {"formulation": "{p,F,J}", "tau_p": 0.1},
)  # fmt: skip
#: The same for the spinning cube.
_METHODS: tuple[dict[str, Any], ...] = (
    {"formulation": "{p,F,J}"}, {"formulation": "{p,F,H,J}"}, {"secondary": "H6"},
    {"operator": "Literal"}, {"weighting": "self-adjoint"}, {"integrator": "SSP-RK3"},
    {"integrator": "position Verlet"},
)  # fmt: skip
_SLOW_METHODS: tuple[dict[str, Any], ...] = (
    {"operator": "Literal"}, {"h_over_dx": 1.0}, {"integrator": "SSP-RK3"},
    {"integrator": "position Verlet"},
)  # fmt: skip
_WORDS = ("method", "formulation", "secondary", "operator", "weighting", "integrator")
#: The paper's choices, which the key of a run does not name.
_UNSAID = ("-", "TVD-RK2", "as printed")
#: Evaluations of the right-hand side a step, over those of the paper's integrator.
_EVALUATIONS = {"TVD-RK2": 1.0, "SSP-RK3": 1.5, "position Verlet": 0.5, "-": 0.5}


def _key(scene: str, group: str, options: dict[str, Any], extra: dict[str, Any]) -> str:
    words = [str(options[name]) for name in _WORDS if options[name] not in _UNSAID]
    words += ["no projection"] if group == "no projection" else []
    numbers = {"spacing": options["spacing"]} | extra
    if options["cfl"] > 0.0:
        numbers["cfl"] = options["cfl"]
    for name in ("h_over_dx", "tau_F", "xi_F", "tau_p"):
        if options["method"] == "SUPG-SPH" and options[name] != PAPER[name]:
            numbers[name] = options[name]
    return f"{scene} {' '.join(words)} " + " ".join(f"{a} {b:g}" for a, b in numbers.items())


def block_case(
    out: Path,
    group: str,
    options: dict[str, Any],
    *,
    jitter: float = 0.2,
    load: float = 1.0,
    until: float = END,
    picture: bool = False,
) -> Case:
    """A run of the L-shaped block."""
    extra = {"jitter": jitter} if jitter != 0.2 else {}
    extra |= {"load": load} if load != 1.0 else {}
    extra |= {"until": until} if until != END else {}
    key = _key("block", group, options, extra)
    cells = 126.0 / options["spacing"] ** 3
    steps = until / options["spacing"] / (options["cfl"] or USUAL_CFL)
    weight = {"H1": 1.0, "H6": 2.3, "-": 0.6}[options["secondary"]]
    weight *= _EVALUATIONS[options["integrator"]]
    return Case(
        key,
        "studies.conservation.cases:block",
        {
            "key": key,
            "shots": str(out / "shots"),
            "shot_times": [t for t in SHOT_TIMES if t <= until] if picture else [],
            "group": group,
            "jitter": jitter,
            "load": load,
            "until": until,
            "keep_history": picture or group in ("no projection", "long"),
            **options,
        },
        cost=2e-5 * cells * steps * weight,
    )


def cube_case(
    group: str, options: dict[str, Any], *, spin: float = SPIN, turns: float = 10.0
) -> Case:
    """A run of the spinning cube."""
    extra = {"spin": spin} if spin != SPIN else {}
    key = _key("cube", group, options, extra)
    weight = {"H1": 1.0, "H6": 1.6, "-": 0.6}[options["secondary"]]
    size = 1.0 / options["spacing"]
    steps = turns / (spin * options["spacing"] * (options["cfl"] or USUAL_CFL))
    weight *= _EVALUATIONS[options["integrator"]]
    return Case(
        key,
        "studies.conservation.cube_cases:cube",
        {
            "key": key,
            "group": group,
            "spin": spin,
            "turns": turns,
            "keep_history": group in ("ladder", "elements", "support", "slow"),
            **options,
        },
        cost=0.05 * (size + 1.0) ** 3 * steps * weight / 50.0,
    )


def block_cases(out: Path) -> Iterator[Case]:
    """Every run of the L-shaped block."""
    for spacing in SPACINGS:
        for operator in OPERATORS:
            for formulation in FORMULATIONS:
                for secondary in ("H1", "H6"):
                    options = PAPER | {
                        "spacing": spacing, "operator": operator, "formulation": formulation,
                        "secondary": secondary,
                    }  # fmt: skip
                    picture = formulation == "{p,F}" and secondary == "H6"
                    yield block_case(out, "all", options, picture=picture)
                    if spacing == PUBLISHED_SPACING:
                        bare = options | {"projection": "none"}
                        yield block_case(out, "no projection", bare)
        yield block_case(out, "elements", ELEMENTS | {"spacing": spacing}, picture=True)
        for formulation in FORMULATIONS:
            options = PACKAGE | {"spacing": spacing, "formulation": formulation}
            yield block_case(out, "defaults", options, picture=formulation == "{p,F}")
    for operator in OPERATORS:
        options = PAPER | {"operator": operator}
        yield block_case(out, "small load", options, load=1e-3, until=5.0)
        yield block_case(out, "long", options, until=60.0)
        for jitter in (0.0, 0.4):
            yield block_case(out, "disorder", options, jitter=jitter)
        for changed in _CHANGES:
            yield block_case(out, "changed", options | changed)
    yield block_case(out, "long", ELEMENTS, until=60.0)
    yield block_case(out, "long", PACKAGE, until=60.0)
    for jitter in (0.0, 0.4):
        yield block_case(out, "disorder", ELEMENTS, jitter=jitter)


def cube_cases() -> Iterator[Case]:
    """Every run of the spinning cube."""
    for cfl in CFLS:
        for spacing in (0.25, 0.125):
            yield cube_case("ladder", CUBE | {"spacing": spacing, "cfl": cfl})
            yield cube_case("elements", ELEMENTS | {"spacing": spacing, "cfl": 2.0 * cfl})
        for changed in _METHODS:
            yield cube_case("methods", CUBE | {"cfl": cfl} | changed)
    yield cube_case("ladder", CUBE | {"spacing": 0.0625})
    for formulation in FORMULATIONS:
        options = PACKAGE | {"spacing": 0.25, "formulation": formulation}
        for cfl in PACKAGE_CFLS:
            yield cube_case("defaults", options | {"cfl": cfl})
    yield cube_case("defaults", PACKAGE | {"spacing": 0.125})
    for operator in OPERATORS:
        yield cube_case("no projection", CUBE | {"operator": operator, "projection": "none"})
    for h in (0.77, 0.85, 1.0, 1.2):
        yield cube_case("support", CUBE | {"h_over_dx": h})
    yield cube_case("support", CUBE | {"h_over_dx": 0.77, "cfl": 0.15})
    for integrator in ("SSP-RK3", "position Verlet"):
        yield cube_case("support", CUBE | {"h_over_dx": 0.77, "integrator": integrator})
    for formulation in FORMULATIONS[:2]:
        options = PACKAGE | {"spacing": 0.25, "formulation": formulation}
        yield cube_case("slow", options, spin=SLOW_SPIN)
    for cfl in CFLS[:2]:
        yield cube_case("slow", CUBE | {"cfl": cfl}, spin=SLOW_SPIN)
    for changed in _SLOW_METHODS:
        yield cube_case("slow", CUBE | changed, spin=SLOW_SPIN)


def short_form(out: Path) -> Iterator[Case]:
    """A cross of the whole study, about half a minute."""
    for operator in OPERATORS:
        options = PAPER | {"operator": operator}
        yield block_case(out, "all", options, picture=True)
        yield block_case(out, "no projection", options | {"projection": "none"})
        yield block_case(out, "small load", options, load=1e-3, until=5.0)
    yield block_case(out, "all", PAPER | {"formulation": "{p,F,H,J}", "secondary": "H1"})
    yield block_case(out, "elements", ELEMENTS, picture=True)
    yield block_case(out, "defaults", PACKAGE, picture=True)
    for cfl in PACKAGE_CFLS[:2]:
        yield cube_case("defaults", PACKAGE | {"spacing": 0.25, "cfl": cfl})
    for cfl in CFLS[:2]:
        yield cube_case("ladder", CUBE | {"cfl": cfl})
        yield cube_case("elements", ELEMENTS | {"spacing": 0.25, "cfl": 2.0 * cfl})
    yield cube_case("support", CUBE | {"h_over_dx": 0.77})


def tiny(out: Path) -> Iterator[Case]:
    """Runs of a second or two that compile every kernel of the study."""
    coarse = PAPER | {"operator": "Consistent", "spacing": 1.5}
    full = coarse | {"formulation": "{p,F,H,J}", "tau_p": 0.1}
    yield block_case(out, "all", coarse, until=6.0)
    yield block_case(out, "all", full, until=0.5)
    yield block_case(out, "elements", ELEMENTS | {"spacing": 1.5}, until=6.0)
    yield cube_case("ladder", CUBE | {"spacing": 0.5}, turns=0.25)
    yield cube_case("ladder", CUBE | {"spacing": 0.5, "integrator": "SSP-RK3"}, turns=0.25)
    yield cube_case("elements", ELEMENTS | {"spacing": 0.5}, turns=0.25)
    yield block_case(out, "defaults", PACKAGE | {"spacing": 1.5}, until=6.0)
    yield cube_case("defaults", PACKAGE | {"spacing": 0.5}, turns=0.25)
