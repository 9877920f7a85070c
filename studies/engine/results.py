"""The files of a finished run: tables as CSV, and what a report is made from."""

from __future__ import annotations

import json
import lzma
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from sphsolid.errors import InputError
from studies.engine.case import write_atomically

Tables = Mapping[str, pd.DataFrame]
#: Bytes of text above which a table is kept compressed.
LONG = 80_000


@dataclass(frozen=True)
class Results:
    """What a report is made from: nothing but the files of a finished run.

    ``tables`` by name (as :attr:`Study.tables` made them, read back from CSV); ``failures`` with
    columns ``key, failure, message, wall_s``; ``run`` is ``run.json``; figures go to ``out``.
    """

    out: Path
    tables: Tables
    failures: pd.DataFrame
    run: dict[str, Any]


def read_results(command: str, out: Path) -> Results:
    """What an earlier run by ``command`` wrote to ``out``.

    Raises ``InputError`` where there is none, or where it was made before the engine: its tables
    have other names and columns.
    """
    try:
        run = json.loads((out / "run.json").read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            f"{out} holds no finished run of `{command}`; run it without --report-only"
        ) from error
    if "study_hash" not in run or "tables" not in run:
        raise InputError(
            f"{out} was made on {run.get('date_utc', 'an unknown day')} by an earlier form of the "
            f"study, whose tables this one cannot read; run `{command}` without --report-only"
        )
    tables = {table: read_table(out, table) for table in run["tables"]}
    return Results(out, tables, read_table(out, "failures"), run)


def write_table(table: pd.DataFrame, folder: Path, name: str) -> Path:
    """Write a table whole or not at all, floats with ten digits; gives its file.

    A long one, more than :data:`LONG` bytes of text, is compressed: ``name.csv.xz``, equal bytes
    for equal tables.  It has the seven digits of a float of 32 bits, more than figures show.
    """
    plain, packed = (folder / f"{name}.csv{suffix}" for suffix in ("", ".xz"))
    text, path, other = table.to_csv(index=False, float_format="%.10g"), plain, packed
    if len(text) > LONG:
        text = table.to_csv(index=False, float_format="%.7g")
        path, other = packed, plain
    write_atomically(path, lzma.compress(text.encode()) if path is packed else text)
    other.unlink(missing_ok=True)
    return path


def read_table(folder: Path, name: str) -> pd.DataFrame:
    """A table that :func:`write_table` wrote; raises ``InputError`` where there is none, or two."""
    found = [path for path in (folder / f"{name}.csv", folder / f"{name}.csv.xz") if path.exists()]
    if not found:
        raise InputError(f"{folder} has no table {name}.csv: run the study again")
    if len(found) > 1:
        raise InputError(
            f"{folder} has {name}.csv and {name}.csv.xz, one of them of an earlier run: delete it"
        )
    try:
        return pd.read_csv(found[0], keep_default_na=False, na_values=["", "nan"])
    except pd.errors.EmptyDataError:
        return pd.DataFrame()
