"""What a method costs beside another, in counted work, against what was recorded.

Per physical second: evaluations (stages over the stable step) times the pairs that an evaluation
visits, times the bytes gathered and the multiply-adds done there, and the bytes of the fields.  A
wider support, a shorter step, a pass, a stage or a field more changes a ratio by whole per cents;
no clock can.  ``python -m tests.regression.test_cost_ratios`` prints what is counted now in the
form of the file.
"""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path

import pytest

from studies.pareto import POISSON
from studies.pareto.methods import compared
from studies.pareto.problems import CUBE, timed
from studies.pareto.runs import counted_work, evaluations_per_step

RECORDED = tomllib.loads((Path(__file__).parent / "cost_ratios.toml").read_text(encoding="utf-8"))
KINDS = ("gathered", "streamed", "multiply_adds")


@cache
def work_per_second(method: str, nu: float) -> dict[str, float]:
    """Bytes gathered and multiply-adds per physical second."""
    [chosen] = [each for each in compared(nu) if each.name == method]
    sim = chosen.simulation(timed(CUBE, nu), spacing=1.0 / RECORDED["cells"])
    evaluations = evaluations_per_step(sim) / sim.stable_time_step()
    work = counted_work(sim)
    return {kind: evaluations * getattr(work, kind) for kind in KINDS}


def ratio(method: str, nu: float) -> dict[str, float]:
    """Work of a method over that of the base."""
    own, base = work_per_second(method, nu), work_per_second(RECORDED["base"], nu)
    return {kind: own[kind] / base[kind] for kind in KINDS}


@pytest.mark.parametrize("nu", POISSON)
@pytest.mark.parametrize("method", [method.name for method in compared(POISSON[0])])
def test_work_is_as_recorded(method: str, nu: float) -> None:
    recorded, band = RECORDED[f"nu {nu:g}"][method], RECORDED["band"]
    for kind, now in ratio(method, nu).items():
        assert now == pytest.approx(recorded[kind], rel=band), (
            f"{method} at nu = {nu:g} now does {now:.3f} times the {kind} of {RECORDED['base']}, "
            f"recorded {recorded[kind]:.3f}: look for a changed support, step, stage or pass; if "
            "it is meant, record the new value in cost_ratios.toml"
        )


def test_work_of_the_base_is_as_recorded() -> None:
    """All ratios would stay where they are if everything became dearer."""
    for nu in POISSON:
        for kind, now in work_per_second(RECORDED["base"], nu).items():
            recorded = RECORDED[f"nu {nu:g}"]["base"][kind]
            assert now == pytest.approx(recorded, rel=RECORDED["band"]), (nu, kind)


def main() -> None:
    """Print the tables of the file as they are now."""
    for nu in POISSON:
        print(f'\n["nu {nu:g}"]')
        base = work_per_second(RECORDED["base"], nu)
        print(f"base = {{ {', '.join(f'{kind} = {base[kind]:.6g}' for kind in KINDS)} }}")
        for method in compared(nu):
            now = ratio(method.name, nu)
            numbers = ", ".join(f"{kind} = {now[kind]:.4f}" for kind in KINDS)
            print(f'"{method.name}" = {{ {numbers} }}')


if __name__ == "__main__":
    main()
