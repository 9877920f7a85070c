"""The example of a user's own study, from a folder of its own."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd

ROOT = Path(__file__).resolve().parents[3]


def test_the_example_runs_from_outside_the_package(tmp_path):
    for name in ("own_study.py", "own_study.md"):
        shutil.copy(ROOT / "examples" / name, tmp_path)
    # The package is found as an editable install finds it.
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "own_study.py", "--quick", "--jobs", "1"]

    def ran(*more):
        made = subprocess.run(
            [*command, *more], cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert made.returncode == 0, made.stderr
        return made.stdout

    said = ran()
    out = tmp_path / "out" / "own_study-quick"
    assert "8 of 8 cases finished" in said
    assert (out / "report.pdf").stat().st_size > 10_000
    table = pd.read_csv(out / "table.csv")
    assert table["method"].unique().tolist() == [
        "package default", "self-adjoint SUPG", "self-adjoint SUPG, tau_F x 2", "B-bar, h/2"
    ]  # fmt: skip
    assert table["survived"].all()
    verdicts = pd.read_csv(out / "claims.csv").set_index("where")["verdict"]
    assert verdicts["B-bar, h/2"] == "met"
    run = json.loads((out / "run.json").read_text())
    assert run["command"] == "python own_study.py --quick --jobs 1"
    assert "[" not in ran("--resume"), "its cases are known by its own sources and options"
    assert json.loads((out / "run.json").read_text())["cases_resumed"] == 8
