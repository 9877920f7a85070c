"""One run at a time in a folder: a lock that ends with its process, however that ends.

The operating system holds the lock (``flock``, or that of Windows), so that a killed run leaves a
file behind but no lock.  It belongs to the open file, not to the process: a process may copy or
read its own folder, whereas a POSIX record lock ends when any descriptor of its file is closed.  A
forked process closes its copy of the file, so that the lock ends with the run's own process.  Where
a file system knows no locks, the process number in the file is all there is to go by.
"""

from __future__ import annotations

import datetime
import errno
import json
import os
import platform
import sys
import threading
from contextlib import suppress
from pathlib import Path

from sphsolid.errors import InputError

NAME = ".sphsolid-lock"
#: Folders that this process writes into, and the open file of each lock.
_HELD: dict[str, int] = {}
_GUARD = threading.Lock()
_BUSY = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)


if sys.platform == "win32":
    import msvcrt

    def _lock(file: int, *, shared: bool) -> None:
        # Far behind what is written there: what Windows locks cannot be read.
        os.lseek(file, 1 << 20, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        os.lseek(file, 0, os.SEEK_SET)
else:
    import fcntl

    def _lock(file: int, *, shared: bool) -> None:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


def _forget() -> None:
    # The run does not pass to a forked process, so its lock must not live on there.
    global _GUARD
    _GUARD = threading.Lock()
    for file in _HELD.values():
        with suppress(OSError):
            os.close(file)
    _HELD.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


def in_use(folder: Path) -> bool:
    """True when a run that is alive writes into ``folder``; changes nothing."""
    with _GUARD:
        if os.path.realpath(folder) in _HELD:
            return True
        try:
            file = os.open(folder / NAME, os.O_RDONLY)
        except OSError:
            return False
        try:
            _lock(file, shared=True)
        except OSError as failure:
            return failure.errno in _BUSY or _owner_lives(folder)
        finally:
            os.close(file)
        return False


def refuse_in_use(folder: Path) -> None:
    """Raise ``InputError`` when a run that is alive writes into ``folder``."""
    if in_use(folder):
        raise InputError(
            f"{folder} is in use by another run ({_owner(folder)}); wait for its end, or choose "
            "another folder"
        )


class FolderLock:
    """Taken when made; raises ``InputError`` when another run, of any process, has it."""

    def __init__(self, folder: Path) -> None:
        refuse_in_use(folder)
        self._path, self._real, self._process = folder / NAME, os.path.realpath(folder), os.getpid()
        with _GUARD:
            self._file = self._taken(folder)
            _HELD[self._real] = self._file

    def _taken(self, folder: Path) -> int:
        while True:
            file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
            try:
                _lock(file, shared=False)
            except OSError as failure:
                if failure.errno in _BUSY:
                    os.close(file)
                    raise InputError(
                        f"{folder} is in use by another run ({_owner(folder)}); wait for its end, "
                        "or choose another folder"
                    ) from None
            # Whoever had it may have removed the file after we opened it: that lock is worth
            # nothing.
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(file), os.stat(self._path)):
                    break
            os.close(file)
        since = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        about = {"process": self._process, "host": platform.node(), "since": since}
        os.ftruncate(file, 0)
        os.write(file, json.dumps(about).encode())
        return file

    def release(self) -> None:
        """Let others have it; does nothing in a forked process, nor a second time."""
        with _GUARD:
            if self._process != os.getpid() or self._real not in _HELD:
                return
            del _HELD[self._real]
            if sys.platform == "win32":
                os.close(self._file)
                self._path.unlink(missing_ok=True)
            else:
                # While it is still locked, so that nobody's file is removed but ours.
                self._path.unlink(missing_ok=True)
                os.close(self._file)


def _about(folder: Path) -> dict[str, object]:
    try:
        found = json.loads((folder / NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _owner(folder: Path) -> str:
    if os.path.realpath(folder) in _HELD:
        return "of this very process"
    about = _about(folder)
    if not about:
        return "of another process"
    return f"process {about.get('process')} on {about.get('host')}, since {about.get('since')}"


def _owner_lives(folder: Path) -> bool:
    about = _about(folder)
    process = about.get("process")
    if about.get("host") != platform.node() or not isinstance(process, int):
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
