"""The command line end to end, in processes of its own: run, view, explain, check, sweep."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from sphsolid.record import read_history, read_run
from sphsolid.shell.member import Member, Outcome, run_member
from sphsolid.shell.settings import product
from sphsolid.shell.workers import on_this_machine

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "examples" / "cases"
SWEEP = (
    "--set", "run.until=4e-3", "--set", "run.every=1e-3",
    "--set", "material.poisson_ratio=0.3,0.45", "--set", "spacing=1,1/2",
    "--set", "solver=fem,sph", "--jobs", "1",
)  # fmt: skip


def sphsolid(*arguments: str, folder: Path) -> Any:
    """What the command says in ``folder``, where the package is not."""
    return subprocess.run(
        [sys.executable, "-m", "sphsolid", *arguments], cwd=folder, capture_output=True, text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_NUM_THREADS": "1"}, timeout=900,
    )  # fmt: skip


@pytest.mark.parametrize(("name", "spacing"), [("own_block", "1/2"), ("bending_column", "1/2")])
def test_an_example_is_run_and_looked_at(name, spacing, tmp_path):
    case = str(CASES / f"{name}.toml")
    setting = ["--set", f"spacing={spacing}", "--set", "run.until=5e-3", "--set", "run.every=1e-3"]
    done = sphsolid("run", case, *setting, "--quiet", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "positions: sound" in done.stdout
    folder = tmp_path / "out" / name
    assert read_run(folder)["status"] == "complete"
    assert len(read_history(folder / "history.csv").table) == 6
    assert {"frames.pvd", "run.vtkhdf", "checkpoint.npz"} <= {p.name for p in folder.iterdir()}

    assert (folder / "case.toml").read_text().endswith(Path(case).read_text())

    again = sphsolid("run", case, *setting, "--quiet", folder=tmp_path)
    assert again.returncode == 2
    assert "already holds a run" in again.stderr
    on = [*setting[:2], "--set", "run.until=7e-3", "--set", "run.every=1e-3", "--resume"]
    assert sphsolid("run", case, *on, "--quiet", folder=tmp_path).returncode == 0
    assert len(read_history(folder / "history.csv").table) == 8

    seen = sphsolid("view", str(folder), "--field", "von_mises", folder=tmp_path)
    assert seen.returncode == 0, seen.stderr
    for picture in ("von_mises.png", "history.png", "animation.gif"):
        assert (folder / picture).stat().st_size > 1000


def test_explain_measures_the_time(tmp_path):
    done = sphsolid(
        "explain", str(CASES / "twisting_column.toml"), "--set", "spacing=1", folder=tmp_path
    )
    assert done.returncode == 0, done.stderr
    for word in ("neighbours", "memory", "steps of at most", "by default", "measured now"):
        assert word in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_check_is_that_of_the_mesh(tmp_path):
    good = ROOT / "tests" / "data" / "meshes" / "prism_hex_1_41_text.msh"
    done = sphsolid("check", str(good), "--unit", "m", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "12 of type hexahedron" in done.stdout
    bad = tmp_path / "bad.msh"
    bad.write_text("nothing")
    done = sphsolid("check", str(bad), folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")


def test_a_run_that_diverges_says_so(tmp_path):
    done = sphsolid(
        "run", str(CASES / "twisting_column.toml"), "--set", "spacing=1/2", "--set",
        "scene.angular_velocity=3e4", "--set", "solver=fem", "--quiet", folder=tmp_path,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("diverged: ")
    assert "Traceback" not in done.stderr


def rows(out: Path) -> pd.DataFrame:
    return pd.read_csv(out / "sweep.csv").drop(columns="wall [s]")


def test_a_sweep_goes_on_after_a_kill_and_on_a_cluster_gives_equal_rows(tmp_path):
    case = str(CASES / "twisting_column.toml")
    command = [sys.executable, "-m", "sphsolid", "sweep", case, *SWEEP, "--out", "killed"]
    process = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(ROOT)}, start_new_session=True,
    )  # fmt: skip
    members, deadline = tmp_path / "killed" / "members", time.monotonic() + 600.0
    while len(list(members.glob("*.json"))) < 3:
        assert process.poll() is None, "it ended by itself"
        assert time.monotonic() < deadline
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = len(list(members.glob("*.json")))
    assert kept < 8
    assert not (tmp_path / "killed" / "sweep.csv").exists()
    done = sphsolid("sweep", case, *SWEEP, "--out", "killed", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert f"{kept} of 8 are there already" in done.stderr
    table = rows(tmp_path / "killed")
    assert len(table) == 8
    assert set(table["status"]) == {"complete"}
    assert table["material.poisson_ratio"].tolist() == [0.3] * 4 + [0.45] * 4
    assert (tmp_path / "killed" / "sweep.png").stat().st_size > 1000
    assert (tmp_path / "killed" / "sweep.md").read_text().count("\n") == 10

    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        done = sphsolid(
            "sweep", case, *SWEEP, "--out", "dask", "--scheduler", cluster.scheduler_address,
            folder=tmp_path,
        )  # fmt: skip
    assert done.returncode == 0, done.stderr
    pd.testing.assert_frame_equal(rows(tmp_path / "dask"), table, check_exact=True)


def die(member: Member) -> Outcome:
    """In a worker: one of the members takes its process with it."""
    if member.values["spacing"] == "1":
        os.kill(os.getpid(), signal.SIGKILL)
    return run_member(member)


def test_a_killed_worker_costs_its_member_only():
    text = (CASES / "twisting_column.toml").read_text(encoding="utf-8")
    combinations = product(["run.until=1e-3", "solver=fem", "spacing=1/2,1,1/2.5"])
    members = [Member(text, "twisting_column.toml", str(CASES), each) for each in combinations]
    found = {member.values["spacing"]: each for member, each in on_this_machine(members, 2, die)}
    assert found["1"].status == "failed"
    assert "killed" in found["1"].reason
    assert found["1/2"].status == found["1/2.5"].status == "complete"


def test_a_member_that_is_refused_or_diverges_is_a_row():
    text = (CASES / "twisting_column.toml").read_text(encoding="utf-8")
    settings = product(["solver=fem", "spacing=1/2", "scene.angular_velocity=3e4"])
    [found] = [run_member(Member(text, "c.toml", str(CASES), each)) for each in settings]
    assert (found.status, found.is_final) == ("diverged", True)
    assert found.reason
    settings = product(["solver=fem", "spacing=1e-9"])
    [found] = [run_member(Member(text, "c.toml", str(CASES), each)) for each in settings]
    assert found.status == "refused"
    other = Member(text, "c.toml", str(CASES), settings[0], sources="other")
    assert not run_member(other).is_final


def test_a_sweep_without_a_scheduler_or_settings_is_refused(tmp_path):
    case = str(CASES / "twisting_column.toml")
    done = sphsolid("sweep", case, folder=tmp_path)
    assert (done.returncode, "say what to vary" in done.stderr) == (2, True)
    done = sphsolid(
        "sweep", case, "--set", "spacing=1,-1", "--out", "o", folder=tmp_path
    )
    assert (done.returncode, "1 of 2 refused" in done.stdout) == (1, True)
    assert rows(tmp_path / "o")["status"].tolist() == ["complete", "refused"]


def test_the_code_of_the_page_of_files_runs_as_it_stands(tmp_path):
    page = (ROOT / "docs" / "files.md").read_text(encoding="utf-8")
    [block] = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    done = subprocess.run(
        [sys.executable, "-c", block], cwd=tmp_path, capture_output=True, text=True, timeout=900,
        env=os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_NUM_THREADS": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for made in ("both/bodies.png", "both/table.csv", "particles/animation.gif", "J.png"):
        assert (tmp_path / "out" / made).stat().st_size > 100
