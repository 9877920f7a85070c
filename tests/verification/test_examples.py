"""The examples of ``examples/``: each is run from outside the repository, as a user would."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NUMBER = r"(-?\d[\d.]*(?:e[-+]\d+)?)"


def said(name: str, folder: Path) -> str:
    """What an example prints when it is run in ``folder``."""
    return run([str(ROOT / "examples" / name)], folder)


def run(arguments: list[str], folder: Path) -> str:
    """What Python prints with ``arguments`` in ``folder``, where the package is installed."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder, env=environment, capture_output=True, text=True, timeout=900,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers(pattern: str, text: str) -> list[float]:
    """Every number that stands in the group of ``pattern``."""
    return [float(found) for found in re.findall(pattern, text)]


def test_every_example_is_run() -> None:
    here = Path(__file__).read_text(encoding="utf-8")
    for path in (ROOT / "examples").glob("own_*.py"):
        assert f'"{path.name}"' in here or path.name == "own_study.py", path.name


def test_own_law(tmp_path: Path) -> None:
    """Both solvers store about the same energy in the same rubber."""
    particles, elements = numbers(f"energy {NUMBER} J", said("own_law.py", tmp_path))
    assert particles == pytest.approx(elements, rel=0.2)
    assert elements > 0.0


def test_own_stabilisation(tmp_path: Path) -> None:
    """It damps what nothing else does, and its power closes the energy budget."""
    text = said("own_stabilisation.py", tmp_path)
    free, damped = numbers(f"{NUMBER} of the energy kept", text)
    residuals = numbers(f"residual {NUMBER}", text)
    assert free == pytest.approx(1.0, abs=5e-3)
    assert damped < 0.5
    assert max(abs(residual) for residual in residuals) < 5e-3


def test_own_integrator(tmp_path: Path) -> None:
    second, fourth = numbers(f"order {NUMBER}", said("own_integrator.py", tmp_path))
    assert second == pytest.approx(2.0, abs=0.1)
    assert fourth == pytest.approx(4.0, abs=0.3)


def test_own_operator(tmp_path: Path) -> None:
    """It satisfies the identities that the package's own does, and is about as accurate."""
    text = said("own_operator.py", tmp_path)
    for identity in ("C0", "C1", "D0"):
        assert max(numbers(f"{identity} {NUMBER}", text)) < 1e-12, identity
    own, ours = numbers(f"error of p {NUMBER}", text)
    assert own == pytest.approx(ours, rel=0.5)


def test_own_element(tmp_path: Path) -> None:
    """The same energy; pressures that alternate, which is what locking looks like."""
    text = said("own_element.py", tmp_path)
    mean, full = numbers(f"energy {NUMBER} J", text)
    assert full == pytest.approx(mean, rel=1e-3)
    spans = numbers(f"span {NUMBER} MPa", text)
    assert spans[1] > spans[0]


@pytest.mark.parametrize("page", ["scene.md", "recorder.md"])
def test_the_code_of_a_page_runs_as_it_stands(page: str, tmp_path: Path) -> None:
    text = (ROOT / "docs" / "how_to_add" / page).read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    run(["-c", block], tmp_path)
