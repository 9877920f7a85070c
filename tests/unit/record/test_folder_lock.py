"""One run at a time in a folder, and a killed run is called killed."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

from sphsolid.errors import InputError
from sphsolid.record import RunFolder, march, read_run
from sphsolid.record.folder_lock import NAME, FolderLock, in_use

#: Another process: takes the lock of a folder, says so, waits to be let go or killed.
HOLDER = """
import sys
from pathlib import Path
from sphsolid.record.folder_lock import FolderLock
lock = FolderLock(Path(sys.argv[1]))
print("held", flush=True)
sys.stdin.readline()
lock.release()
"""


@pytest.fixture
def holder(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.communicate()


def run(solver, folder, **options):
    return march(solver, until=0.2, every=0.1, output=RunFolder(folder, **options))


def test_another_process_keeps_a_run_out_until_it_ends(fake_solver, tmp_path, holder):
    solver = fake_solver()
    for option in ({}, {"replace": True}, {"resume": True}):
        with pytest.raises(InputError, match=rf"in use by another run \(process {holder.pid} on"):
            run(solver, tmp_path, **option)
    assert solver.step == 0
    assert [file.name for file in tmp_path.iterdir()] == [NAME]
    holder.communicate("go\n")
    assert list(tmp_path.iterdir()) == []
    run(solver, tmp_path)


def test_a_killed_process_holds_nothing(fake_solver, tmp_path, holder):
    holder.kill()
    holder.communicate()
    assert (tmp_path / NAME).exists()
    assert not in_use(tmp_path)
    run(fake_solver(), tmp_path)
    assert not (tmp_path / NAME).exists()


def test_a_process_keeps_itself_out(fake_solver, tmp_path):
    inner = []

    def again(progress):
        if not inner:
            with pytest.raises(InputError, match="of this very process") as refusal:
                run(fake_solver(), tmp_path / ".", replace=True)
            inner.append(refusal)

    march(fake_solver(), until=0.2, output=RunFolder(tmp_path), progress=again)
    assert len(inner) == 1
    run(fake_solver(), tmp_path, replace=True)


def test_a_run_that_fails_lets_go(fake_solver, tmp_path):
    with pytest.raises(RuntimeError, match="negative Jacobian"):
        run(fake_solver(fails_at=0.05), tmp_path)
    assert not in_use(tmp_path)
    lock = FolderLock(tmp_path)
    lock.release()
    lock.release()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_neither_has_the_lock_nor_takes_it_away(tmp_path):
    lock = FolderLock(tmp_path)
    child = os.fork()
    if child == 0:
        lock.release()
        os._exit(0 if in_use(tmp_path) else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert (tmp_path / NAME).exists()
    lock.release()


def killed(solver, folder):
    """Leave what a run leaves that is killed: no end, and a lock that nobody holds."""
    run(solver, folder)
    about = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(about | {"status": "running"}))
    (folder / NAME).write_text("{}")


def test_a_killed_run_is_called_killed_when_it_is_next_read(fake_solver, tmp_path):
    killed(fake_solver(), tmp_path)
    assert read_run(tmp_path)["status"] == "killed"
    assert read_run(str(tmp_path))["name"] == "fake"
    with pytest.raises(InputError, match=r"already holds a run \(killed\)"):
        run(fake_solver(), tmp_path)
    march(fake_solver(), until=0.4, every=0.1, output=RunFolder(tmp_path, resume=True))
    about = read_run(tmp_path)
    assert (about["status"], about["earlier"]["status"]) == ("complete", "killed")
    killed(fake_solver(), tmp_path / "b")
    run(fake_solver(), tmp_path / "b", replace=True)
    assert read_run(tmp_path / "b")["earlier"]["status"] == "killed"


def test_a_run_that_is_going_on_is_called_running(fake_solver, tmp_path):
    seen = []
    march(
        fake_solver(), until=0.2, output=RunFolder(tmp_path),
        progress=lambda progress: seen.append(read_run(tmp_path)["status"]),
    )  # fmt: skip
    assert seen[0] == "running"
    assert read_run(tmp_path)["status"] == "complete"


def test_a_folder_without_a_run_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no run"):
        read_run(tmp_path)
    (tmp_path / "run.json").write_text("[]")
    with pytest.raises(InputError, match="is not about a run"):
        read_run(tmp_path)


def elsewhere(folder):
    """What another process says of the folder."""
    ask = (
        "import sys; from pathlib import Path; from sphsolid.record.folder_lock import in_use; "
        "print(in_use(Path(sys.argv[1])))"
    )
    return subprocess.check_output([sys.executable, "-c", ask, str(folder)], text=True).strip()


@pytest.mark.skipif(sys.platform == "win32", reason="what Windows locks cannot be copied")
@pytest.mark.parametrize("touch", ["copy", "read"])
def test_a_process_may_copy_and_read_its_own_folder(tmp_path, touch):
    folder = tmp_path / "run"
    folder.mkdir()
    lock = FolderLock(folder)
    if touch == "copy":
        shutil.copytree(folder, tmp_path / "backup")
    else:
        (folder / NAME).read_bytes()
    assert elsewhere(folder) == "True"
    lock.release()
    assert not in_use(folder)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_process_does_not_keep_the_lock_of_a_killed_one(tmp_path):
    text = """
import os, sys, time
from pathlib import Path
from sphsolid.record.folder_lock import FolderLock
lock = FolderLock(Path(sys.argv[1]))
child = os.fork()
if child:
    print(child, flush=True)
    time.sleep(60)
else:
    os.close(1)
    time.sleep(60)
"""
    process = subprocess.Popen(
        [sys.executable, "-c", text, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    child = int(process.stdout.readline())
    try:
        assert in_use(tmp_path)
        process.kill()
        process.communicate()
        os.kill(child, 0)
        # The child closes its copy of the file as soon as it runs.
        for _ in range(100):
            if not in_use(tmp_path):
                break
            time.sleep(0.05)
        assert not in_use(tmp_path)
    finally:
        os.kill(child, signal.SIGKILL)
