"""Runs that end badly, in processes of their own: killed, interrupted, diverged."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.record import Energy, Every, Probe, RunFolder, read_history
from sphsolid.record.checkpoint import read_checkpoint
from sphsolid.scenes import twisting_column

ROOT = Path(__file__).resolve().parents[2]
EVERY = 5.0e-4
#: A script such as a user writes; the first two lines undo what a test runner may hand down.
SCRIPT = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
import fem_reference as fem, sphsolid as sph
from sphsolid.record import Energy, Probe, ProgressLine, RunFolder
from sphsolid.scenes import twisting_column
method, folder, cfl = sys.argv[1], sys.argv[2], float(sys.argv[3])
solver = {"sph": sph, "fem": fem}[method]
sim = solver.Simulation(twisting_column(), spacing=0.25, cfl=cfl)
sim.run(
    until=float(sys.argv[4]), every=5.0e-4, record=[Energy(), Probe("top_corner")],
    progress=ProgressLine(), output=RunFolder(folder),
)
"""


def start(folder: Path, method: str, *, cfl: float = 0.3, until: float = 1e3) -> Any:
    command = [sys.executable, "-c", SCRIPT, method, str(folder), str(cfl), str(until)]
    return subprocess.Popen(
        command, env=os.environ | {"PYTHONPATH": str(ROOT)}, stderr=subprocess.PIPE, text=True
    )


def wait_for_records(folder: Path, count: int, process: Any) -> None:
    deadline = time.monotonic() + 300.0
    while time.monotonic() < deadline:
        if process.poll() is not None:
            pytest.fail(f"the run ended by itself: {process.stderr.read()}")
        history = folder / "history.csv"
        if history.exists() and history.read_bytes().count(b"\n") > count:
            return
        time.sleep(0.01)
    process.kill()
    pytest.fail("no records in five minutes")


def simulation(method: str) -> Any:
    solver: Any = {"sph": sph, "fem": fem}[method]
    return solver.Simulation(twisting_column(), spacing=0.25, cfl=0.3)


def read_all(folder: Path) -> Any:
    """Read every file as a user would; the history."""
    history = read_history(folder / "history.csv")
    count = len(history.table)
    np.testing.assert_array_equal(history["time [s]"], [k * EVERY for k in range(count)])
    assert np.all(np.isfinite(history.table.to_numpy()))
    sets = list(ElementTree.parse(folder / "frames.pvd").getroot().iter("DataSet"))
    assert count - 1 <= len(sets) <= count
    for k, entry in enumerate(sets):
        body = meshio.read(folder / entry.attrib["file"])
        assert body.field_data["TimeValue"] == float(entry.attrib["timestep"]) == k * EVERY
        assert all(np.all(np.isfinite(values)) for values in body.point_data.values())
    assert count - 1 <= read_checkpoint(folder / "checkpoint.npz").records <= count
    return history


@pytest.mark.parametrize("method", ["sph", "fem"])
def test_a_killed_run_is_readable_and_goes_on_with_the_same_bits(
    method: str, tmp_path: Path
) -> None:
    process = start(tmp_path / "run", method)
    wait_for_records(tmp_path / "run", 5, process)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    read_all(tmp_path / "run")
    assert json.loads((tmp_path / "run" / "run.json").read_text())["status"] == "running"

    # Another process than the one that wrote the checkpoint, and one that never stopped.
    until = (read_checkpoint(tmp_path / "run" / "checkpoint.npz").records + 2) * EVERY
    record = [Energy(), Probe("top_corner")]
    whole, resumed = simulation(method), simulation(method)
    for sim, folder, options in (
        (whole, "whole", {}),
        (resumed, "run", {"resume": True}),
    ):
        output = RunFolder(tmp_path / folder, **options)
        sim.run(until=until, every=EVERY, record=record, output=output)
    read_all(tmp_path / "run")
    for name in ("history.csv", "frames.pvd"):
        one, other = (tmp_path / folder / name for folder in ("run", "whole"))
        assert one.read_bytes() == other.read_bytes()
    for name, array in whole.state_arrays().items():
        assert array.tobytes() == resumed.state_arrays()[name].tobytes(), name


def test_ctrl_c_leaves_what_there_is_and_the_shell_sees_130(tmp_path: Path) -> None:
    process = start(tmp_path, "sph")
    wait_for_records(tmp_path, 3, process)
    process.send_signal(signal.SIGINT)
    errors = process.communicate()[1]
    # Killed by the signal it caught, as the shell expects: a loop of runs stops too.
    assert process.returncode == -signal.SIGINT
    assert "KeyboardInterrupt" in errors
    history = read_all(tmp_path)
    about = json.loads((tmp_path / "run.json").read_text())
    assert (about["status"], about["records"]) == ("interrupted", len(history.table))
    saved = read_checkpoint(tmp_path / "checkpoint.npz")
    assert saved.records == len(history.table)
    assert saved.time == history["time [s]"][-1]


def test_the_shell_calls_death_by_sigint_130() -> None:
    code = "import os, signal; os.kill(os.getpid(), signal.SIGINT); input()"
    quiet = f"import signal; signal.signal(signal.SIGINT, signal.default_int_handler); {code}"
    shell = subprocess.run(
        ["sh", "-c", '"$0" -c "$1"; echo $?', sys.executable, quiet],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert shell.stdout.strip() == "130"


# ------------------------------------------------------------------ a step ten times too long
def invalid(sim: Any) -> bool:
    """What no solution looks like, said again without the solver's own check."""
    with np.errstate(all="ignore"):
        s = sim.snapshot()
        fields = (s.x, s.velocity, s.F, s.J)
        finite = all(bool(np.all(np.isfinite(values))) for values in fields)
        return not (finite and np.all(np.linalg.det(s.F) > 0.0) and np.all(s.J > 0.0))


@pytest.mark.parametrize("formulation", [sph.PF(), sph.PFHJ(), sph.Displacement()])
def test_a_lost_solution_is_noticed_in_the_step_that_lost_it(
    formulation: Any, tmp_path: Path
) -> None:
    sim = sph.Simulation(twisting_column(), spacing=0.25, cfl=3.0, formulation=formulation)
    states = []
    advance = sim.advance

    def watched(dt: float) -> None:
        advance(dt)
        states.append(invalid(sim))

    sim.advance = watched  # type: ignore[method-assign]
    with pytest.raises(sph.Diverged) as lost:
        sim.run(every=EVERY, record=[Energy()], output=RunFolder(tmp_path, frames=Every()))
    assert states.index(True) == len(states) - 1, "steps were taken from an invalid state"
    assert lost.value.step == len(states)
    history = read_all(tmp_path)
    kept = lost.value.history.table  # type: ignore[attr-defined]
    assert kept.to_numpy().tobytes() == history.table.to_numpy().tobytes()
    about = json.loads((tmp_path / "run.json").read_text())
    assert about["status"] == "diverged"
    assert about["failure"]["particle"] == lost.value.particle
    assert about["failure"]["advice"] == lost.value.advice


def test_a_diverged_script_fails_and_says_why(tmp_path: Path) -> None:
    process = start(tmp_path, "sph", cfl=3.0, until=0.1)
    errors = process.communicate()[1]
    assert process.returncode == 1
    last = errors.strip().splitlines()[-1]
    for part in ("Diverged", "at t = ", "step ", "point ", "(X = ", "Try: a smaller cfl"):
        assert part in last
    read_all(tmp_path)
