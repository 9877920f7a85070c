"""The code of docs/laws.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.continuum import check_law

PAGE = Path(__file__).parents[2] / "docs" / "laws.md"
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def law_of_the_page() -> dict[str, Any]:
    names: dict[str, Any] = {"__name__": "laws_page"}
    exec(BLOCKS[0], names)
    return names


def test_the_law_has_about_thirty_lines_and_agrees_with_itself() -> None:
    lines = [line for line in BLOCKS[0].splitlines() if line.strip()]
    assert len(lines) <= 36
    names = law_of_the_page()
    check_law(names["LogarithmicNeoHookean"](mu=6.54e6, kappa=1.42e7, density=1100.0))


def scene_of_the_page() -> dict[str, Any]:
    assert len(BLOCKS) == 2
    names = law_of_the_page()
    exec(BLOCKS[1], names)
    return names


def check_pressure(pressure: Any, cauchy: Any) -> None:
    mean = np.trace(cauchy, axis1=1, axis2=2) / 3.0
    np.testing.assert_allclose(pressure, mean, atol=1e-6 * 1.42e7)
    assert np.abs(pressure).max() > 0.0


def test_the_run_of_the_page() -> None:
    names = scene_of_the_page()
    check_pressure(names["pressure"], names["sim"].snapshot().cauchy)


@pytest.mark.slow
def test_particles_take_the_law_of_the_page() -> None:
    """Kernels of the evolved strain: the mean stress is not smoothed there."""
    sim = sph.Simulation(scene_of_the_page()["scene"], spacing=0.5, formulation=sph.PF())
    sim.run(until=1.0e-3)
    shot = sim.snapshot()
    check_pressure(shot.pressure, shot.cauchy)
