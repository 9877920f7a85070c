"""Coordinates of points out of a file, as they stand there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.meshio_reading import read_vtu

Array = NDArray[np.float64]
_AXES = ("x", "y", "z")
KINDS = (".csv", ".npy", ".txt", ".vtu", ".xyz")


def read_points(path: Path) -> Array:
    """Points ``(n, 3)`` of a ``.npy`` array, the points of a ``.vtu``, or a table of numbers.

    A table (``.csv`` with commas, ``.xyz`` and ``.txt`` with blanks) has three columns, or a first
    line with names, of which ``x``, ``y`` and ``z`` count; lines that begin with ``#`` are left
    out.  Raises ``InputError`` for a file that is missing, of another kind or cannot be read.
    """
    require(path.is_file(), f"{path}: there is no such file")
    kind = path.suffix.lower()
    if kind == ".vtu":
        return read_vtu(path).points
    if kind == ".npy":
        try:
            points = np.load(path, allow_pickle=False)
        except (OSError, ValueError, EOFError) as error:
            raise InputError(f"{path} cannot be read as an array of NumPy: {error}") from error
        if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "iuf":
            raise InputError(
                f"{path} holds {points.dtype} of shape {points.shape}; points are numbers (n, 3)"
            )
        return np.asarray(points, dtype=np.float64)
    if kind not in KINDS:
        raise InputError(f"{path} is of kind {kind or 'unknown'}; points are read from {KINDS}")
    return _table(path, "," if kind == ".csv" else None)


def _table(path: Path, separator: str | None) -> Array:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not a text file: {error}") from error
    columns: list[int] | None = None
    width = 3
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        words = [word.strip() for word in line.split(separator)]
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if columns is None:
            names = [word.strip('"').lower() for word in words]
            if set(_AXES) <= set(names):
                columns, width = [names.index(axis) for axis in _AXES], len(words)
                continue
            columns = [0, 1, 2]
        try:
            require(len(words) == width, "")
            rows.append([float(words[k]) for k in columns])
        except ValueError as error:
            raise InputError(
                f"{path}, line {number}: {line.strip()[:60]!r}; wanted are {width} numbers, "
                "separated by " + ("commas" if separator else "blanks")
                + ", or a first line with the names x, y, z"
            ) from error
    require(len(rows) > 0, f"{path} holds no points")
    return np.array(rows)
