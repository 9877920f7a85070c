"""Slopes of the swinging cube against a floor, a band and an error cap (``slopes.toml``).

A slope below its *floor* says that the theory is broken; one outside its *band* says that the
behaviour changed, for better or worse; an error above its *cap* says that accuracy was lost at an
unchanged slope.  The three have different messages.  ``python -m tests.regression.test_slopes``
prints what is measured now in the form of the file.
"""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import sphsolid as sph
from studies.convergence import run_cube
from studies.measures.order import fit_order, last_order
from studies.methods import B_BAR, PAPER, Method

Case = dict[str, Any]
SLOPES = tomllib.loads((Path(__file__).parent / "slopes.toml").read_text(encoding="utf-8"))
CASES: list[Case] = SLOPES["case"]
#: Options by the words of the file.
FORMULATIONS = {each.name: each for each in (sph.PF(), sph.PFJ(), sph.PFHJ())}
SECONDARY = {"H1": sph.H1(), "H6": sph.H6()}
OPERATORS = {
    each.name: each for each in (sph.Literal(), sph.Consistent(), sph.Consistent(use="force"))
}


def method_of(
    *,
    method: str = PAPER.name,
    formulation: str = "{p,F}",
    secondary: str = "H1",
    operator: str = "Consistent",
    xi_F: float = 0.0,
    tau_p: float = 0.0,
) -> Method:
    """The method that a case names: a variant of the paper's scheme, or the elements."""
    if method == B_BAR.name:
        return B_BAR
    return PAPER.but(
        formulation=FORMULATIONS[formulation], secondary=SECONDARY[secondary],
        operator=OPERATORS[operator], xi_F=xi_F, tau_p=sph.OfStep(tau_p),
    )  # fmt: skip


@cache
def errors(
    cells: int, *, family: str, scene: str = "linear", poisson_ratio: float = 0.3, **method: Any
) -> dict[str, float]:
    """Error of every component at one spacing."""
    rows = run_cube(
        method=method_of(**method), scene=scene, family=family, poisson_ratio=poisson_ratio,
        cells=cells,
    )  # fmt: skip
    return {f"{row['field']}_{row['component']}": row["error"] for row in rows}


def measured(case: Case) -> dict[str, dict[str, float]]:
    """Last slope, fitted slope and finest error of every component that the case records."""
    levels = [errors(cells, **case["run"]) for cells in case["cells"]]
    h = [1.0 / cells for cells in case["cells"]]
    found = {}
    for name in case["slope"]:
        error = [level[name] for level in levels]
        found[name] = {
            "last": last_order(h, error),
            "fitted": fit_order(h, error),
            "error": error[-1],
        }
    return found


def complaints(case: Case, found: dict[str, dict[str, float]]) -> list[str]:
    """One sentence for everything that is wrong; empty when all is as recorded."""
    wrong = []
    for name, now in found.items():
        who = f"{case['name']}: {name}"
        field = name[0]
        recorded, known = case["slope"][name], case["error"][name]
        for kind in ("last", "fitted"):
            floor = case.get("floor", {}).get(field, float("-inf"))
            ceiling = case.get("ceiling", {}).get(field, float("inf"))
            if now[kind] < floor:
                wrong.append(
                    f"{who}: {kind} slope {now[kind]:.3f} is below its floor {floor}: the theory "
                    "is broken, look for an inconsistent operator, load, norm or time level"
                )
            if now[kind] > ceiling:
                wrong.append(
                    f"{who}: {kind} slope {now[kind]:.3f} is above {ceiling}: this operator is "
                    "recorded as one that does not converge, it is no longer the paper's"
                )
        if abs(now["last"] - recorded) > case["band"]:
            wrong.append(
                f"{who}: last slope {now['last']:.3f} left its band {recorded} +- {case['band']}: "
                "the behaviour changed; if that is meant, record the new value in slopes.toml"
            )
        if now["error"] > (1.0 + SLOPES["error_margin"]) * known:
            wrong.append(
                f"{who}: error {now['error']:.3e} at h = 1/{case['cells'][-1]} exceeds its cap, "
                f"{known:.3e} + {SLOPES['error_margin']:.0%}: accuracy was lost"
            )
    return wrong


def parameters() -> list[Any]:
    return [
        pytest.param(case, id=case["name"], marks=[pytest.mark.slow] if case.get("slow") else [])
        for case in CASES
    ]


@pytest.mark.parametrize("case", parameters())
def test_slopes_are_those_recorded(case: Case) -> None:
    assert complaints(case, measured(case)) == []


# ------------------------------------------------------------- the judge itself
PROBE: Case = {
    "name": "probe",
    "cells": [4, 8, 16],
    "band": 0.05,
    "floor": {"p": 1.95},
    "slope": {"p_x": 2.04},
    "error": {"p_x": 1.0e-3},
}


def probe(last: float, *, error: float = 1.0e-3, **change: Any) -> list[str]:
    found = {"p_x": {"last": last, "fitted": last, "error": error}}
    return complaints(PROBE | change, found)


def test_what_is_recorded_passes() -> None:
    for slope in (2.04, 2.0, 2.085):
        assert probe(slope) == []
    assert probe(2.04, error=1.04e-3) == []
    assert probe(2.04, error=1.0e-6) == []  # a better error alone is no complaint


def test_a_degraded_slope_trips_floor_and_band_with_different_messages() -> None:
    found = probe(1.7)
    broken = [message for message in found if "theory" in message]
    changed = [message for message in found if "behaviour changed" in message]
    assert len(found) == len(broken) + len(changed)
    assert len(broken) == 2  # last and fitted
    assert len(changed) == 1
    assert "below its floor 1.95" in broken[0]
    assert "2.04 +- 0.05" in changed[0]
    # Between floor and band only the behaviour changed, and so it did where the slope is higher.
    for slope in (1.97, 2.3):
        [message] = probe(slope)
        assert "behaviour changed" in message
        assert "theory" not in message


def test_lost_accuracy_trips_the_cap_at_an_unchanged_slope() -> None:
    [message] = probe(2.04, error=1.2e-3)
    assert "accuracy was lost" in message
    assert "h = 1/16" in message


def test_a_ceiling_documents_what_does_not_converge() -> None:
    literal = {"floor": {}, "ceiling": {"p": 1.4}, "slope": {"p_x": 1.0}}
    assert probe(1.0, **literal) == []
    found = probe(2.0, **literal)
    assert any("no longer the paper's" in message for message in found)


def test_a_real_degradation_is_caught() -> None:
    """The literal operator's errors handed in as the consistent one's."""
    case = next(c for c in CASES if c["name"] == "{p,F} H1 Consistent, A+B+C=0")
    literal = {**case, "run": {**case["run"], "operator": "Literal"}, "cells": [4, 8]}
    found = complaints(case, measured(literal))
    for part in ("theory is broken", "behaviour changed", "accuracy was lost"):
        assert any(part in message for message in found), part


def test_every_case_is_complete() -> None:
    assert len({case["name"] for case in CASES}) == len(CASES)
    for case in CASES:
        assert case["slope"].keys() == case["error"].keys(), case["name"]
        assert "floor" in case or "ceiling" in case
        limits = case.get("floor", {}) | case.get("ceiling", {})
        assert {name[0] for name in case["slope"]} == set(limits), case["name"]
        assert 0.0 < case["band"] <= 0.1


def main() -> None:
    """Print the measured values of every case as TOML lines."""
    for case in CASES:
        found = measured(case)
        print(f"# {case['name']}")
        for key, kind, form in (("slope", "last", ".2f"), ("error", "error", ".2e")):
            values = ", ".join(f"{name} = {now[kind]:{form}}" for name, now in found.items())
            print(f"{key} = {{ {values} }}", flush=True)


if __name__ == "__main__":
    main()
