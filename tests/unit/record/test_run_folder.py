"""Run folders: whole at any moment, resumed bit for bit, never mixed, never greedy."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest

from sphsolid.errors import Diverged, InputError
from sphsolid.record import Energy, Every, Never, RunFolder, march, read_history, read_run
from sphsolid.record.checkpoint import read_checkpoint


@dataclasses.dataclass(frozen=True)
class Speed:
    def record(self, snapshot, scene):
        return {"speed [m/s]": float(snapshot.velocity[0, 0])}


def run(solver, folder, *, until=0.5, **options):
    return march(
        solver, until=until, every=0.1, record=[Speed()], output=RunFolder(folder, **options)
    )


def collection(folder: Path) -> list[tuple[float, str]]:
    root = ElementTree.parse(folder / "frames.pvd").getroot()
    return [(float(d.attrib["timestep"]), d.attrib["file"]) for d in root.iter("DataSet")]


def frames(folder: Path) -> list[str]:
    return sorted(f"frames/{file.name}" for file in (folder / "frames").iterdir())


def content(folder: Path) -> dict[str, Any]:
    """What a run leaves, but for the file that says when and how."""
    files = [file for file in sorted(folder.rglob("*")) if file.is_file()]
    kept = [f for f in files if f.name not in ("run.json", "checkpoint.npz", "manifest.txt")]
    found: dict[str, Any] = {f.relative_to(folder).as_posix(): f.read_bytes() for f in kept}
    saved = read_checkpoint(folder / "checkpoint.npz")
    return found | {"state": (saved.time, saved.step, saved.records, saved.arrays["x"].tobytes())}


def names(count):
    return [f"frames/frame_{k:06d}.vtu" for k in range(count)]


def test_a_run_leaves_history_frames_and_checkpoint(fake_solver, tmp_path):
    solver = fake_solver()
    history = run(solver, tmp_path / "run")
    folder = tmp_path / "run"
    history.to_csv(tmp_path / "h.csv")
    assert (folder / "history.csv").read_bytes() == (tmp_path / "h.csv").read_bytes()
    assert collection(folder) == list(zip(history["time [s]"], names(6), strict=True))
    assert frames(folder) == names(6)
    for time, name in collection(folder):
        found = meshio.read(folder / name)
        assert found.field_data["TimeValue"] == [time]
        np.testing.assert_array_equal(found.point_data["v"], np.float32(time))
    saved = read_checkpoint(folder / "checkpoint.npz")
    assert (saved.time, saved.step, saved.records) == (0.5, solver.step, 6)
    about = json.loads((folder / "run.json").read_text())
    assert about["status"] == "complete"
    assert (about["plan"], about["until_s"]) == (["nothing", "to speak of"], 0.5)
    assert about["recorders"] == ["Speed()"]
    listed = (folder / "manifest.txt").read_text().split()
    made = {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}
    assert made - {"manifest.txt"} == set(listed)
    assert len(listed) == len(set(listed))


def test_every_so_many_records_and_never(fake_solver, tmp_path):
    run(fake_solver(), tmp_path, frames=Every(records=2), checkpoints=Never())
    assert frames(tmp_path) == [names(6)[k] for k in (0, 2, 4, 5)]
    assert [name for _, name in collection(tmp_path)] == frames(tmp_path)
    assert not (tmp_path / "checkpoint.npz").exists()
    run(fake_solver(), tmp_path, frames=Never(), replace=True)
    assert frames(tmp_path) == []
    assert len(read_history(tmp_path / "history.csv").table) == 6


def test_frames_need_no_recorder(fake_solver, tmp_path):
    history = march(fake_solver(), until=0.2, every=0.1, output=RunFolder(tmp_path))
    assert list(history.table) == ["time [s]", "step"]
    assert frames(tmp_path) == names(3)


# ------------------------------------------------------------------ no mixing, no greed
def test_a_folder_with_a_run_is_refused_with_the_remedies(fake_solver, tmp_path):
    run(fake_solver(), tmp_path)
    before = content(tmp_path)
    solver = fake_solver()
    with pytest.raises(InputError, match=r"already holds a run.*replace=True.*resume=True"):
        run(solver, tmp_path)
    assert content(tmp_path) == before
    assert solver.step == 0


def test_a_shorter_rerun_leaves_nothing_of_the_longer(fake_solver, tmp_path):
    run(fake_solver(), tmp_path)
    run(fake_solver(dt=lambda t: 0.05), tmp_path, until=0.2, replace=True)
    run(fake_solver(dt=lambda t: 0.05), tmp_path / "alone", until=0.2)
    assert frames(tmp_path) == names(3)
    alone = content(tmp_path / "alone")
    assert {k: v for k, v in content(tmp_path).items() if "alone" not in k} == alone


def test_replace_removes_no_file_that_is_not_ours(fake_solver, tmp_path):
    folder = tmp_path / "run"
    run(fake_solver(), folder)
    others = {
        folder / "notes.txt": "mine",
        folder / "frames" / "picture.png": "mine",
        folder / "frames" / "frame_1.vtu": "mine",
        tmp_path / "outside.txt": "mine",
    }
    for path, text in others.items():
        path.write_text(text)
    # Not even when somebody wrote its name on the list.
    with (folder / "manifest.txt").open("a") as manifest:
        manifest.write(f"../outside.txt\n{tmp_path / 'outside.txt'}\nframes/../../outside.txt\n")
    run(fake_solver(), folder, until=0.1, replace=True)
    assert {path: path.read_text() for path in others} == others
    assert [name for name in frames(folder) if name in names(9)] == names(2)


@pytest.mark.parametrize(
    "name", ["history.csv", "frames.pvd", "run.json", "frames/frame_000007.vtu"]
)
@pytest.mark.parametrize("option", [{}, {"replace": True}, {"resume": True}])
def test_files_of_others_in_our_place_are_refused(fake_solver, tmp_path, name, option):
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("mine")
    solver = fake_solver()
    with pytest.raises(InputError, match=name):
        run(solver, tmp_path, **option)
    assert [f for f in tmp_path.rglob("*") if f.is_file()] == [path]
    assert (path.read_text(), solver.step) == ("mine", 0)


def test_a_folder_with_other_things_may_take_a_run(fake_solver, tmp_path):
    (tmp_path / "script.py").write_text("mine")
    run(fake_solver(), tmp_path)
    assert (tmp_path / "script.py").read_text() == "mine"


def test_bad_input_is_refused_before_an_old_run_goes(fake_solver, tmp_path):
    run(fake_solver(), tmp_path)
    before = content(tmp_path)

    class Broken:
        def record(self, snapshot, scene):
            raise InputError("no such probe")

    output = RunFolder(tmp_path, replace=True)
    for times in ({"until": -1.0}, {"until": 1.0, "every": 0.0}):
        with pytest.raises(InputError, match=r"until|every"):
            march(fake_solver(), **times, output=output)
    with pytest.raises(InputError, match="no such probe"):
        march(fake_solver(), until=1.0, record=[Broken()], output=output)
    assert content(tmp_path) == before


def test_bad_options_are_refused(tmp_path):
    with pytest.raises(InputError, match="one of them"):
        RunFolder(tmp_path, replace=True, resume=True)
    with pytest.raises(InputError, match="frames = 2 is not an option object"):
        RunFolder(tmp_path, frames=2)
    with pytest.raises(InputError, match="at least 1"):
        Every(records=0)
    with pytest.raises(InputError, match=r"Every\(records=True\)"):
        Every(records=True)


@pytest.mark.parametrize("name", ["resume", "replace"])
@pytest.mark.parametrize("value", ["yes", "no", "", 1, 0, None, np.True_, [True]])
def test_only_true_and_false_resume_and_replace(fake_solver, tmp_path, name, value):
    run(fake_solver(), tmp_path)
    before = content(tmp_path)
    with pytest.raises(InputError, match=f"RunFolder: {name} = .* must be True or False"):
        run(fake_solver(), tmp_path, **{name: value})
    assert content(tmp_path) == before


@pytest.mark.parametrize(
    ("path", "named"),
    [
        ("/dev/null/x", "^/dev/null, in the path of the run, is a file"),
        ("/dev/null", "^/dev/null is a file"),
        ("/proc/x/y", "^the folder /proc/x/y cannot be made"),
        ("a\0b", r"path = 'a\\x00b' has a null character"),
        ("x" * 5000, "cannot be a folder"),
        ("file/x/y", "file, in the path of the run, is a file"),
        ("link", "link cannot be made"),
    ],
)
def test_what_cannot_be_a_folder_is_refused_in_one_sentence(
    fake_solver, tmp_path, monkeypatch, path, named
):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("mine")
    Path("link").symlink_to("nowhere")
    solver = fake_solver()
    with pytest.raises(InputError, match=named) as refused:
        run(solver, path)
    assert "\n" not in str(refused.value)
    assert solver.step == 0
    assert sorted(file.name for file in tmp_path.iterdir()) == ["file", "link"]


def test_a_file_in_place_of_the_folder_is_refused(fake_solver, tmp_path):
    (tmp_path / "run").write_text("mine")
    with pytest.raises(InputError, match="is a file"):
        run(fake_solver(), tmp_path / "run")


# ------------------------------------------------------------------ going on
def test_a_resumed_run_is_the_run_that_never_stopped(fake_solver, tmp_path):
    whole = run(fake_solver(), tmp_path / "whole", until=1.0)
    run(fake_solver(), tmp_path / "parts", until=4 * 0.1)
    for until in (7 * 0.1, 1.0):
        parts = run(fake_solver(), tmp_path / "parts", until=until, resume=True)
    assert content(tmp_path / "parts") == content(tmp_path / "whole")
    assert parts.table.equals(whole.table)


def test_the_energy_that_progress_counts_from_is_that_of_the_first_record(fake_solver, tmp_path):
    energy = []
    for until in (0.2, 0.4):
        march(
            fake_solver(), until=until, every=0.1, record=[Energy()],
            output=RunFolder(tmp_path, resume=True),
            progress=lambda progress: energy.append((progress.start_energy, progress.energy)),
        )  # fmt: skip
    assert {start for start, _ in energy} == {0.0}
    assert energy[-1][1] > 0.0


def test_a_finished_run_is_not_run_again(fake_solver, tmp_path):
    first = run(fake_solver(), tmp_path)
    solver = fake_solver()
    again = run(solver, tmp_path, resume=True)
    assert again.table.equals(first.table)
    assert (solver.time, solver.steps) == (0.5, [])


def test_resume_begins_where_there_is_nothing_yet(fake_solver, tmp_path):
    run(fake_solver(), tmp_path / "new", resume=True)
    run(fake_solver(), tmp_path / "plain")
    assert content(tmp_path / "new") == content(tmp_path / "plain")


def test_what_is_newer_than_the_checkpoint_is_made_again(fake_solver, tmp_path):
    run(fake_solver(), tmp_path / "whole", until=1.0)
    with pytest.raises(Diverged):
        run(fake_solver(fails_at=0.75), tmp_path / "lost", until=1.0, checkpoints=Every(records=5))
    assert frames(tmp_path / "lost") == names(8)
    assert read_checkpoint(tmp_path / "lost" / "checkpoint.npz").records == 6
    history = run(fake_solver(), tmp_path / "lost", until=1.0, resume=True)
    assert len(history.table) == 11
    assert content(tmp_path / "lost") == content(tmp_path / "whole")


def test_other_recorders_are_refused_before_a_file_changes(fake_solver, tmp_path):
    run(fake_solver(), tmp_path)
    before = content(tmp_path)
    with pytest.raises(InputError, match="same recorders"):
        march(
            fake_solver(), until=1.0, every=0.1, output=RunFolder(tmp_path, resume=True)
        )
    assert content(tmp_path) == before


def test_without_a_checkpoint_there_is_no_going_on(fake_solver, tmp_path):
    run(fake_solver(), tmp_path, checkpoints=Never())
    with pytest.raises(InputError, match="6 records but no checkpoint"):
        run(fake_solver(), tmp_path, until=1.0, resume=True)


def test_a_history_that_lost_rows_is_refused(fake_solver, tmp_path):
    run(fake_solver(), tmp_path)
    text = (tmp_path / "history.csv").read_text().splitlines(keepends=True)
    (tmp_path / "history.csv").write_text("".join(text[:3]))
    with pytest.raises(InputError, match="2 rows where the checkpoint was taken after 6"):
        run(fake_solver(), tmp_path, until=1.0, resume=True)


# ------------------------------------------------------------------ bad ends
def test_a_lost_solution_says_so_in_the_folder(fake_solver, tmp_path):
    with pytest.raises(Diverged) as lost:
        run(fake_solver(fails_at=0.3), tmp_path)
    assert frames(tmp_path) == names(3)
    stored = read_history(tmp_path / "history.csv")
    assert stored.table.equals(lost.value.history.table)
    about = json.loads((tmp_path / "run.json").read_text())
    assert (about["status"], about["records"]) == ("diverged", 3)
    assert about["failure"] == {
        "reason": "negative Jacobian", "time_s": lost.value.time, "step": lost.value.step,
        "particle": 1, "X_m": [0.0, 0.0, 1.0], "advice": "less",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("end", "status"), [(KeyboardInterrupt(), "interrupted"), (OSError("disk full"), "failed")]
)
def test_every_other_end_is_named(fake_solver, tmp_path, end, status):
    solver = fake_solver()
    advance = solver.advance

    def stop(dt):
        if solver.step == 9:
            raise end
        advance(dt)

    solver.advance = stop
    with pytest.raises(type(end)):
        run(solver, tmp_path)
    about = json.loads((tmp_path / "run.json").read_text())
    assert (about["status"], about["records"]) == (status, 3)
    assert read_checkpoint(tmp_path / "checkpoint.npz").step == 8


# ------------------------------------------------------------------ killed at every moment
END = 2 * 0.1


def killed_at(count: int, folder: Path, solver: Any, **options: Any) -> bool:
    """Run in a child that drops dead before its ``count``-th change of a file; False: it ended."""
    child = os.fork()
    if child == 0:
        seen = 0

        def watch(event: str, arguments: tuple[Any, ...]) -> None:
            nonlocal seen
            writes = event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR)
            if writes or event in ("os.rename", "os.remove", "os.mkdir"):
                seen += 1
                if seen == count:
                    os._exit(1)

        with contextlib.suppress(BaseException):
            sys.addaudithook(watch)
            run(solver, folder, **options)
            os._exit(0)
        os._exit(2)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    assert status in (0, 1), "the child failed by itself"
    return status == 1


def check_readable(folder: Path) -> None:
    if (folder / "history.csv").exists():
        rows = read_history(folder / "history.csv")
        expected = [k * 0.1 for k in range(len(rows.table))]
        assert len(rows.table) == 0 or rows["time [s]"].tolist() == expected
    if (folder / "frames.pvd").exists():
        listed = collection(folder)
        assert [name for _, name in listed] == names(len(listed))
        for time, name in listed:
            assert meshio.read(folder / name).field_data["TimeValue"] == [time]
        assert len(rows.table) >= len(listed)
    if (folder / "checkpoint.npz").exists():
        assert read_checkpoint(folder / "checkpoint.npz").records <= len(rows.table)
    if (folder / "run.json").exists():
        status = json.loads((folder / "run.json").read_text())["status"]
        assert read_run(folder)["status"] == ("killed" if status == "running" else status)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
@pytest.mark.parametrize("kind", ["new", "replace", "resume"])
def test_a_run_killed_before_any_change_of_a_file_can_be_read_and_resumed(
    fake_solver, tmp_path, kind
):
    run(fake_solver(), tmp_path / "whole", until=END)
    expected = content(tmp_path / "whole")
    deaths = 0
    for count in range(1, 200):
        folder = tmp_path / f"killed{count}"
        if kind == "replace":
            run(fake_solver(dt=lambda t: 0.02), folder, until=0.1)
        if kind == "resume":
            with pytest.raises(Diverged):
                run(fake_solver(fails_at=0.15), folder, until=END, checkpoints=Every(records=2))
        options = {} if kind == "new" else {kind: True}
        if not killed_at(count, folder, fake_solver(), until=END, **options):
            break
        deaths += 1
        check_readable(folder)
        # A run that was to replace another may still find the other's checkpoint.
        remedy = "replace" if kind == "replace" else "resume"
        run(fake_solver(), folder, until=END, **{remedy: True})
        assert content(folder) == expected, count
    else:
        pytest.fail("the run never ended")
    assert deaths > 15


@pytest.mark.parametrize(
    ("name", "content", "named"),
    [
        ("run.vtkhdf", b"xx", "run.vtkhdf is no file of records, or is damaged"),
        ("history.csv", b"\xff\xfe", "history.csv is no history of a run, or is damaged"),
        ("manifest.txt", b"\xff", "manifest.txt is no list of files, or is damaged"),
    ],
)
def test_a_damaged_file_is_named(fake_solver, tmp_path, name, content, named):
    run(fake_solver(), tmp_path, until=0.3)
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=named):
        run(fake_solver(), tmp_path, resume=True)
