"""Coordinates of points out of a file, as they stand there."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.vtu_reading import read_vtu

Array = NDArray[np.float64]
#: Names of the columns of coordinates, as they are and as ParaView writes them.
_AXES = (("x", "y", "z"), ("points:0", "points:1", "points:2"))
_FORTRAN = re.compile(r"([0-9.])[dD]([-+]?\d+)$")
KINDS = (".csv", ".npy", ".txt", ".vtu", ".xyz")


def read_points(path: Path) -> Array:
    """Points ``(n, 3)`` of a ``.npy`` array, the points of a ``.vtu``, or a table of numbers.

    A table (``.csv`` with commas, ``.xyz`` and ``.txt`` with blanks) has three columns, or a first
    line with names.  Of the names ``x``, ``y`` and ``z`` count (``Points:0`` ... of ParaView, too).
    Lines that begin with ``#`` are left out.  Raises ``InputError`` for a file that is missing, of
    another kind, a table of another layout, or cannot be read.
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
    lines = _text(path).splitlines()
    columns: list[int] | None = None
    width = 3
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        words = [word.strip() for word in line.split(separator)]
        if columns is None:
            _refuse_other_tables(path, lines[number - 1 :], separator)
            names = [word.strip('"').lower() for word in words]
            for axes in _AXES:
                if set(axes) <= set(names):
                    columns, width = [names.index(axis) for axis in axes], len(words)
            if columns is not None:
                continue
            columns = [0, 1, 2]
        try:
            require(len(words) == width, "")
            rows.append([_number(words[k]) for k in columns])
        except ValueError as error:
            raise InputError(
                f"{path}, line {number}: {line.strip()[:60]!r}; wanted are {width} numbers, "
                "separated by " + ("commas" if separator else "blanks")
                + ", or a first line with the names x, y, z"
            ) from error
    require(len(rows) > 0, f"{path} holds no points")
    return np.array(rows)


def _text(path: Path) -> str:
    """Only the comments of a table may have letters of another encoding."""
    data = path.read_bytes()
    require(
        b"\0" not in data,
        f"{path} is not a text file, or in UTF-16; save it as UTF-8 or ASCII",
    )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _number(word: str) -> float:
    """A number as Fortran writes it, too: 1.5D+00."""
    if "_" in word:
        raise ValueError(word)
    return float(_FORTRAN.sub(r"\1e\2", word.strip('"')))


def _refuse_other_tables(path: Path, lines: list[str], separator: str | None) -> None:
    """Raises ``InputError`` for tables of a kind that is not read, by its first lines."""
    first = lines[0]
    wanted = "commas" if separator else "blanks"
    require(
        ";" not in first,
        f"{path}: its columns are separated by semicolons (and a comma may be the decimal point); "
        f"save it with {wanted} between the columns and decimal points",
    )
    require(
        separator is not None or "," not in first,
        f"{path}: its columns are separated by commas; name it .csv, or save it with blanks",
    )
    require(
        separator is None or "\t" not in first or "," in first,
        f"{path}: its columns are separated by tabs; name it .txt, or save it with commas",
    )
    molecule = separator is None and first.strip().isdigit() and len(first.split()) == 1
    require(
        not molecule,
        f"{path} is an XYZ file of atoms (a count, a comment, then symbols), which is not read; "
        "keep its three columns of coordinates alone",
    )
