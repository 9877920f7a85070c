"""The frames of the runs of a study, written by the workers that make them.

A case returns rows of numbers; its frames go to ``<out>/shots``, which git ignores.  What the
figures need of them is kept beside the tables and committed (``pictures.picture``).
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from sphsolid.errors import Diverged, require
from sphsolid.look.frame import KEPT, Absent, Frame, HasDiverged, Kept, Shot, take_shot
from sphsolid.look.scalars import CELL
from sphsolid.record.snapshot import Snapshot
from sphsolid.scenes.scene import Scene
from studies.pictures.frame_file import find, read_frames, write_frames

__all__ = [
    "CELL", "KEPT", "Absent", "Frame", "HasDiverged", "SaveShots", "Shot", "ShotFolder",
    "take_shot",
]  # fmt: skip


@dataclass(frozen=True)
class ShotFolder:
    """The frames of all runs of a study, one a file, found again by the run's ``key``.

    ``path`` is usually ``<out>/shots``.  Call ``clear(key)`` before a run: frames of an older run
    of the same case never mix with new ones.
    """

    path: Path

    def clear(self, key: str) -> None:
        """Forget every frame of a case."""
        for path in self._files(key):
            path.unlink()

    def save(self, key: str, snapshot: Snapshot, label: str) -> Path:
        """Keep a snapshot."""
        return self.save_frame(key, take_shot(snapshot, label))

    def save_diverged(self, key: str, label: str, stop: Diverged) -> Path:
        """Keep that the run of ``key`` diverged."""
        return self.save_frame(key, HasDiverged(label, stop.time, stop.time))

    def save_frame(self, key: str, frame: Kept) -> Path:
        """Keep a frame."""
        name = "diverged" if isinstance(frame, HasDiverged) else f"{frame.time:.9g}s"
        return write_frames(self.path / f"{_readable(key)}@{name}.npz", [(key, frame)])

    def load(self, key: str, time: float) -> Kept:
        """The frame at ``time`` [s]; raises ``InputError`` as :func:`find` does."""
        return find(self._frames(key), key, time, f"{self.path.name}/")

    def load_all(self, key: str) -> list[Shot]:
        """Every frame of a case, in order of time; raises ``InputError`` if there is none."""
        shots = [frame for frame in self._frames(key) if isinstance(frame, Shot)]
        require(
            len(shots) > 0,
            f"there are no frames of {key!r} in {self.path.name}/: run its case again, without "
            "--resume if its rows are kept",
        )
        return sorted(shots, key=lambda shot: shot.time)

    def _frames(self, key: str) -> list[Kept]:
        return [frame for path in self._files(key) for _, frame in read_frames(path)]

    def _files(self, key: str) -> list[Path]:
        # Not glob: a key may hold brackets.
        stem, there = f"{_readable(key)}@", self.path.iterdir() if self.path.is_dir() else ()
        return sorted(p for p in there if p.name.startswith(stem) and p.suffix == ".npz")


@dataclass(frozen=True)
class SaveShots:
    """A recorder that keeps frames and adds no column.

    With ``times`` [s] only records at those instants are kept, else every record.
    """

    folder: ShotFolder
    key: str
    label: str
    times: Sequence[float] = field(default=())

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """No column."""
        if not self.times or np.isclose(self.times, snapshot.time, rtol=1e-6, atol=1e-12).any():
            self.folder.save(self.key, snapshot, self.label)
        return {}


def _readable(key: str) -> str:
    plain = re.sub(r"[^A-Za-z0-9.=+-]+", "_", key).strip("_")[:80]
    # Keys that differ only in what was replaced must not share a file.
    return plain if plain == key else f"{plain}-{zlib.crc32(key.encode()):08x}"
