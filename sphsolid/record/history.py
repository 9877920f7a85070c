"""Histories: one row per record, in memory and in a file that survives a kill."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from sphsolid.errors import InputError, nearest
from sphsolid.paths import path_of
from sphsolid.record.atomic import atomic
from sphsolid.record.showing import look

Row = dict[str, float]


@dataclass(frozen=True)
class History:
    """One row per record; the columns name their units."""

    table: pd.DataFrame

    @classmethod
    def of(cls, rows: Sequence[Row]) -> History:
        """A history of the given rows."""
        return cls(pd.DataFrame(list(rows)))

    def to_csv(self, path: str | Path) -> None:
        """Write all rows with full double precision."""
        target = path if hasattr(path, "write") else path_of(path)
        self.table.to_csv(target, index=False, float_format="%.17g", na_rep="nan")

    def __getitem__(self, column: str) -> Any:
        if column not in self.table:
            raise InputError(
                f"the history has no column {column!r}{nearest(column, self.table.columns)}; it "
                f"has {', '.join(map(repr, self.table.columns))}"
            )
        return self.table[column].to_numpy()

    def plot(self, *columns: str, against: str = "time [s]") -> Any:
        """Curves of ``columns``, by default of all, as a figure that a notebook shows.

        A column is named in full or by how it begins: ``plot("top_u")`` draws the three
        displacements.  Columns of one unit share a panel; its axis has the unit.  Save it with
        ``savefig("history.png")``.  Raises ``InputError`` for a column that is not there, and
        where matplotlib is not installed.
        """
        return look().plot(self, columns, against)

    def _repr_html_(self) -> str:
        return str(self.table._repr_html_())


def read_history(path: str | Path) -> History:
    """Read a file of :class:`HistoryFile` or ``to_csv``, bit for bit; a torn last line is left out.

    Raises ``InputError`` for a file that is not there or holds something else.
    """
    return History.of(read_rows(path_of(path)))


def read_rows(path: Path) -> list[Row]:
    """The rows of a file; see :func:`read_history`."""
    return _rows(_lines(path), path)


class HistoryFile:
    """Appends rows to a CSV file, each with one system call: whole lines at any moment.

    ``keep`` rows of a file that is there are kept, the rest of it is cut off.
    """

    def __init__(self, path: Path, *, keep: int) -> None:
        lines = _lines(path)[: keep + 1] if keep else []
        self.rows = _rows(lines, path)
        with atomic(path) as part:
            part.write_text("".join(lines), encoding="utf-8")
        self._file = path.open("ab", buffering=0)
        self._columns = list(self.rows[0]) if self.rows else []

    def append(self, row: Row) -> None:
        """Add one row; raises ``InputError`` when its columns are not those of the file."""
        text = ""
        if not self._columns:
            self._columns = list(row)
            text = _line(self._columns)
        check_columns(self._columns, list(row))
        self._file.write((text + _line([_number(value) for value in row.values()])).encode())

    def close(self) -> None:
        """Nothing more will come."""
        self._file.close()


def check_columns(known: list[str], new: list[str]) -> None:
    """Raise ``InputError`` unless a row has the columns that the rows before it have."""
    if new != known:
        changed = sorted(set(new) ^ set(known)) or "their order"
        raise InputError(
            f"a record has other columns than the history before it (differing: {changed}); "
            "go on with the same recorders, in the same order"
        )


def _number(value: float) -> str:
    # 17 significant digits name a double; counts such as the step stay whole numbers.
    return str(value) if isinstance(value, int) else f"{value:.17g}"


def _line(cells: list[str]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue()


def _lines(path: Path) -> list[str]:
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(f"there is no history {path}") from None
    except UnicodeDecodeError as damage:
        raise InputError(f"{path} is no history of a run, or is damaged ({damage})") from None
    return [line for line in text.splitlines(keepends=True) if line.endswith("\n")]


def _rows(lines: list[str], path: Path) -> list[Row]:
    if not lines:
        return []
    header, *body = csv.reader(lines)
    try:
        # ``step`` is a count; everything else is a number of physics.
        return [
            {
                name: int(cell) if name == "step" else float(cell)
                for name, cell in zip(header, cells, strict=True)
            }
            for cells in body
        ]
    except ValueError as wrong:
        raise InputError(f"{path} is not a history of numbers: {wrong}") from None
