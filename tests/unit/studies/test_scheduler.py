"""Cases on a Dask cluster of two worker processes of this machine."""

from __future__ import annotations

import json
from dataclasses import replace

import pandas as pd
import pytest

from studies.engine.case import Case
from studies.engine.scheduler import OnWorker
from studies.engine.study import main
from tests.unit.studies.fake_study import TEXT, dies, diverges, power, sleeps, study_of

distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
SHORT = TEXT.split("{{ figure")[0]


@pytest.fixture(scope="module")
def cluster():
    # A worker that was killed is given up after two more tries, not four.
    import dask

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
            silence_logs=50,
        ) as made,
    ):  # fmt: skip
        yield made


def on(cluster, out, *more):
    return ["--out", str(out), "--scheduler", cluster.scheduler_address, *more]


def test_rows_are_those_of_the_local_pool_and_resume_works(cluster, tmp_path):
    log = tmp_path / "log"
    fake = study_of([power(h, log=log) for h in (0.5, 0.25, 0.125)], tmp_path, text=SHORT)
    assert main(fake, ["--out", str(tmp_path / "local"), "--jobs", "2"]) == 0
    assert main(fake, on(cluster, tmp_path / "dask")) == 0
    for name in ("table.csv", "orders.csv", "failures.csv"):
        here, there = (tmp_path / run / name for run in ("local", "dask"))
        assert here.read_bytes() == there.read_bytes()
    run = json.loads((tmp_path / "dask" / "run.json").read_text())
    assert (run["jobs"], run["cluster"], run["threads_per_job"]) == (2, True, 1)
    ran = len(log.read_text().split())
    next((tmp_path / "dask" / "partial").glob("h_=_0.25*")).unlink()
    assert main(fake, on(cluster, tmp_path / "dask", "--resume")) == 0
    assert log.read_text().split()[ran:] == ["0.25"]
    # What the cluster left is what the local pool goes on with.
    assert main(fake, ["--out", str(tmp_path / "dask"), "--resume"]) == 0
    assert len(log.read_text().split()) == ran + 1


def test_a_killed_worker_costs_its_case_only(cluster, tmp_path):
    cases = [
        Case("killed", dies, {}, 9.0),
        *(power(1.0 / n) for n in range(2, 8)),
        Case("diverged", diverges, {"h": 0.5}),
        Case("s", sleeps, {"seconds": 0.5}),
    ]
    out = tmp_path / "out"
    assert main(study_of(cases, tmp_path, text=SHORT), on(cluster, out)) == 0
    failures = pd.read_csv(out / "failures.csv").set_index("key")
    assert failures["failure"].to_dict() == {"killed": "WorkerDied", "diverged": "Diverged"}
    assert len(pd.read_csv(out / "table.csv")) == 13


def test_cases_go_side_by_side(cluster, tmp_path):
    cases = [Case(f"{k}", sleeps, {"seconds": 1.0}) for k in range(2)]
    out = tmp_path / "out"
    assert main(study_of(cases, tmp_path, text=SHORT), on(cluster, out)) == 0
    kept = [json.loads(path.read_text())["rows"][0] for path in (out / "partial").iterdir()]
    assert len({row["process"] for row in kept}) == 2
    assert max(row["began"] for row in kept) < min(row["ended"] for row in kept)


def test_wrong_clusters_are_refused_in_one_line(tmp_path, capsys):
    fake = study_of([power(0.5)], tmp_path)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None, silence_logs=50
    ) as threaded:
        assert main(fake, on(threaded, tmp_path)) == 2
    assert "--nthreads 1" in capsys.readouterr().err
    assert main(fake, ["--out", str(tmp_path), "--scheduler", "no address"]) == 2
    assert "no Dask scheduler answers" in capsys.readouterr().err


def test_a_worker_with_other_sources_is_not_believed():
    assert not OnWorker(1)(power(0.5)).failed
    other = replace(OnWorker(1), sources="another")(power(0.5))
    assert other.failure == "OtherSources"
    assert not other.rows
