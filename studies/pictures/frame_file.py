"""Files of frames: one format for the many that a run leaves and the few that a report needs.

Arrays that are equal are kept once; the same frames give the same bytes; a file appears whole or
not at all.
"""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.look.frame import HasDiverged, Kept, Shot
from studies.engine.case import write_atomically

_FORMAT = 3


def write_frames(path: Path, frames: Sequence[tuple[str, Kept]]) -> Path:
    """Write frames with the keys of their runs; arrays that are equal are kept once."""
    index: list[dict[str, Any]] = []
    arrays: dict[str, Any] = {}
    numbers: dict[tuple[str, tuple[int, ...], bytes], int] = {}

    def place(array: NDArray[Any]) -> int:
        number = numbers.setdefault((array.dtype.str, array.shape, array.tobytes()), len(numbers))
        arrays[f"array_{number}"] = array
        return number

    for key, frame in frames:
        entry = {"key": key, "label": frame.label, "time": frame.time}
        if isinstance(frame, HasDiverged):
            entry["diverged_at"] = frame.diverged_at
        else:
            entry["folded"] = bool(frame.folded)
            entry |= {name: place(getattr(frame, name)) for name in ("quads", "x", "V")}
            entry["values"] = {name: place(array) for name, array in frame.values.items()}
        index.append(entry)
    buffer = io.BytesIO()
    arrays |= {"format": np.int64(_FORMAT), "index": np.str_(json.dumps(index))}
    np.savez_compressed(buffer, **arrays)
    write_atomically(path, buffer.getvalue())
    return path


def read_frames(path: Path) -> list[tuple[str, Kept]]:
    """Frames with the keys of their runs; raises ``InputError`` where they cannot be read."""
    name = f"{path.parent.name}/{path.name}"
    again = "run what makes it again, without --resume"
    require(path.exists(), f"there are no frames {name}: {again}")
    try:
        with np.load(path, allow_pickle=False) as data:
            number = int(data["format"])
            index = json.loads(str(data["index"])) if number == _FORMAT else []
            arrays = [data[f"array_{k}"] for k in range(len(data.files) - 2)] if index else []
    except Exception as error:
        raise InputError(f"frames {name} cannot be read ({error}): {again}") from error
    require(
        number == _FORMAT,
        f"frames {name} have format {number}, and this version reads {_FORMAT}: {again}",
    )
    return [(entry.pop("key"), _frame(entry, arrays)) for entry in index]


def _frame(entry: dict[str, Any], arrays: Sequence[NDArray[Any]]) -> Kept:
    if "diverged_at" in entry:
        return HasDiverged(**entry)
    values = {name: arrays[number] for name, number in entry.pop("values").items()}
    return Shot(**entry | {name: arrays[entry[name]] for name in ("quads", "x", "V")},
                values=values)  # fmt: skip


@dataclass(frozen=True)
class KeptFrames:
    """The frames of many runs in the file ``path``."""

    path: Path

    @cached_property
    def frames(self) -> list[tuple[str, Kept]]:
        """All of them, with the keys of their runs."""
        return read_frames(self.path)

    def load(self, key: str, time: float) -> Kept:
        """The frame of ``key`` at ``time`` [s]; raises ``InputError`` as :func:`find` does."""
        frames = [frame for name, frame in self.frames if name == key]
        return find(frames, key, time, self.path.name)


def find(frames: Sequence[Kept], key: str, time: float, where: str) -> Kept:
    """The frame at ``time`` [s], or that the run had diverged before.

    Raises ``InputError`` where there is neither, naming the times there are.
    """
    shots = [frame for frame in frames if isinstance(frame, Shot)]
    for shot in shots:
        if np.isclose(shot.time, time, rtol=1e-6, atol=1e-12):
            return shot
    for frame in frames:
        if isinstance(frame, HasDiverged) and frame.diverged_at <= time * (1.0 + 1e-6):
            return replace(frame, time=time)
    times = ", ".join(f"{shot.time:g}" for shot in shots) or "none"
    raise InputError(
        f"there is no frame of {key!r} at {time:g} s in {where} (kept: {times}): run its case "
        "again, without --resume if its rows are kept"
    )
