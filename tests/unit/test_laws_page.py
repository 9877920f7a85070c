"""The code of docs/laws.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

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


@pytest.mark.slow
def test_the_run_of_the_page() -> None:
    assert len(BLOCKS) == 2
    names = law_of_the_page()
    exec(BLOCKS[1], names)
    shot = names["sim"].snapshot()
    np.testing.assert_allclose(
        names["pressure"], np.trace(shot.cauchy, axis1=1, axis2=2) / 3.0, atol=1e-6 * 1.42e7
    )
    assert np.abs(names["pressure"]).max() > 0.0
