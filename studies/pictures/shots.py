"""Frames of a run, small enough to keep: what pictures are drawn from.

A case of a study runs in a worker process and returns rows of numbers; its frames go to files, so
that figures can be remade without running again.  A frame is ``<folder>/<key>@<time>s.npz``
(:class:`ShotFolder`), by convention in ``<out>/shots``: the boundary quadrilaterals, float32
positions and volumes, and float32 pressure, von Mises stress and ``J`` at the vertices, once as
the method has them there and once as means over cells, which are alike for both solvers.  A file
appears whole or not at all.
"""

from __future__ import annotations

import io
import os
import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import Diverged, InputError, require
from sphsolid.record import judge_positions
from sphsolid.record.snapshot import Snapshot
from sphsolid.scenes.scene import Scene
from studies.report.places import cell_means_at_vertices

#: Before the name of a field: its means over cells, carried to the vertices.
CELL = "cell_"
_FIELDS = ("pressure", "von_mises", "J")
#: Fields a frame keeps, values at the vertices.
KEPT = (*_FIELDS, *(CELL + name for name in _FIELDS))
_FORMAT = 2


@dataclass(frozen=True, eq=False)
class Shot:
    """A body at ``time`` [s], ``label`` saying by which method.

    ``quads (f, 4)`` int32, counter-clockwise seen from outside; ``x (N, 3)`` float32 [m] all
    primary points; ``V (N,)`` float32 [m^3] their volumes; ``values``: ``pressure`` [Pa],
    ``von_mises`` [Pa], ``J`` [-], and with :data:`CELL` before the name the same as means over
    cells, each ``(N,)`` float32; ``spacing`` [m] of the undeformed points; ``folded``: whether its
    positions are judged folded (``record.positions``).
    """

    label: str
    time: float
    quads: NDArray[np.int32]
    x: NDArray[np.float32]
    V: NDArray[np.float32]
    values: dict[str, NDArray[np.float32]]
    spacing: float
    folded: bool

    def value(self, name: str) -> NDArray[np.float32]:
        """A field at the vertices; raises ``InputError`` for one that was not kept."""
        if name not in self.values:
            raise InputError(f"frame has no field {name!r}; it has {', '.join(self.values)}")
        return self.values[name]


@dataclass(frozen=True)
class Lost:
    """In the place of a frame: by ``time`` [s] the solution was lost, at ``lost_at`` [s]."""

    label: str
    time: float
    lost_at: float


@dataclass(frozen=True)
class Absent:
    """In the place of a frame: a panel that stays empty but for ``reason``."""

    label: str
    time: float
    reason: str = "not run"


#: What a panel can show.
Frame = Shot | Lost | Absent


def take_shot(snapshot: Snapshot, label: str) -> Shot:
    """The frame of a snapshot of either solver."""
    values = {name: snapshot.at_vertices(name) for name in _FIELDS}
    values |= {CELL + name: cell_means_at_vertices(snapshot, name) for name in _FIELDS}
    return Shot(
        label=label,
        time=float(snapshot.time),
        quads=snapshot.mesh.boundary.astype(np.int32),
        x=snapshot.x.astype(np.float32),
        V=snapshot.V.astype(np.float32),
        values={name: field.astype(np.float32) for name, field in values.items()},
        spacing=float(snapshot.mesh.spacing),
        folded=judge_positions(snapshot).folded,
    )


def save_shot(path: Path, shot: Shot) -> Path:
    """Write a frame so that a reader, or a kill, finds all of it or nothing."""
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        format=np.int64(_FORMAT),
        label=np.str_(shot.label),
        time=np.float64(shot.time),
        spacing=np.float64(shot.spacing),
        folded=np.bool_(shot.folded),
        quads=shot.quads,
        x=shot.x,
        V=shot.V,
        **{f"value_{name}": values for name, values in shot.values.items()},  # type: ignore[arg-type]
    )
    write_whole(path, buffer.getvalue())
    return path


def load_shot(path: Path) -> Shot:
    """Read a frame; raises ``InputError`` where there is none or it cannot be read."""
    name = f"{path.parent.name}/{path.name}"
    try:
        with np.load(path, allow_pickle=False) as data:
            number = int(data["format"])
            require(
                number == _FORMAT,
                f"frame {name} has format {number}, this version reads {_FORMAT}; run its case "
                "again without --resume",
            )
            return Shot(
                label=str(data["label"]),
                time=float(data["time"]),
                spacing=float(data["spacing"]),
                folded=bool(data["folded"]),
                quads=data["quads"],
                x=data["x"],
                V=data["V"],
                values={
                    key.removeprefix("value_"): data[key]
                    for key in data.files
                    if key.startswith("value_")
                },
            )
    except FileNotFoundError as error:
        raise InputError(
            f"there is no frame {name}: run its case again, without --resume if its rows are kept"
        ) from error
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"frame {name} cannot be read ({error}); run its case again") from error


@dataclass(frozen=True)
class ShotFolder:
    """The frames of all cases of a study, found again by the case's ``key`` and the time.

    ``path`` is usually ``<out>/shots``.  Call ``clear(key)`` before a run: frames of an older run
    of the same case never mix with new ones.
    """

    path: Path

    def file(self, key: str, time: float) -> Path:
        """Where the frame of ``key`` at ``time`` [s] is kept."""
        return self.path / f"{_readable(key)}@{time:.9g}s.npz"

    def clear(self, key: str) -> None:
        """Forget every frame of a case."""
        for _, path in self._files(key):
            path.unlink()
        self._lost_file(key).unlink(missing_ok=True)

    def save(self, key: str, snapshot: Snapshot, label: str) -> Path:
        """Keep a snapshot."""
        return save_shot(self.file(key, snapshot.time), take_shot(snapshot, label))

    def save_lost(self, key: str, label: str, failure: Diverged) -> None:
        """Keep that the run of ``key`` ended at ``failure.time``."""
        write_whole(self._lost_file(key), f"{failure.time!r}\n{label}\n".encode())

    def load(self, key: str, time: float) -> Shot | Lost:
        """The frame at ``time`` [s]; :class:`Lost` if the run ended before.

        Raises ``InputError`` where there is neither, naming the times there are.
        """
        found = self._files(key)
        for at, path in found:
            if np.isclose(at, time, rtol=1e-6, atol=1e-12):
                return load_shot(path)
        lost = self._lost_file(key)
        if lost.exists():
            when, label = lost.read_text(encoding="utf-8").splitlines()
            if float(when) <= time * (1.0 + 1e-6):
                return Lost(label=label, time=time, lost_at=float(when))
        times = ", ".join(f"{at:g}" for at, _ in found) or "none"
        raise InputError(
            f"there is no frame of {key!r} at {time:g} s in {self.path.name}/ (kept: {times}): run "
            "its case again, without --resume if its rows are kept"
        )

    def load_all(self, key: str) -> list[Shot]:
        """Every frame of a case, in order of time; raises ``InputError`` if there is none."""
        found = self._files(key)
        require(
            len(found) > 0,
            f"there are no frames of {key!r} in {self.path.name}/: run its case again, without "
            "--resume if its rows are kept",
        )
        return [load_shot(path) for _, path in found]

    def _files(self, key: str) -> list[tuple[float, Path]]:
        stem, found = f"{_readable(key)}@", []
        # Not glob: a key may hold brackets.
        for path in self.path.iterdir() if self.path.is_dir() else ():
            if path.name.startswith(stem) and path.name.endswith("s.npz"):
                found.append((float(path.name[len(stem) : -len("s.npz")]), path))
        return sorted(found)

    def _lost_file(self, key: str) -> Path:
        return self.path / f"{_readable(key)}@lost.txt"


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


def write_whole(path: Path, content: bytes) -> None:
    """Write bytes so that a reader, or a kill, finds the old file or the whole new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(content)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
