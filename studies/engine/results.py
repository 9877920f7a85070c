"""The files of a finished run: tables as CSV, and what a report is made from."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from sphsolid.errors import InputError
from studies.engine.case import write_atomically

Tables = Mapping[str, pd.DataFrame]


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
    """What an earlier run by ``command`` wrote to ``out``; raises ``InputError`` without one."""
    try:
        run = json.loads((out / "run.json").read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            f"{out} holds no finished run of `{command}`; run it without --report-only"
        ) from error
    tables = {table: _read_csv(out / f"{table}.csv") for table in run["tables"]}
    return Results(out, tables, _read_csv(out / "failures.csv"), run)


def write_csv(table: pd.DataFrame, path: Path) -> None:
    """Write a table whole or not at all, floats with ten digits."""
    write_atomically(path, table.to_csv(index=False, float_format="%.10g"))


def _read_csv(path: Path) -> pd.DataFrame:
    try:
        return pd.read_csv(path, keep_default_na=False, na_values=["", "nan"])
    except pd.errors.EmptyDataError:
        return pd.DataFrame()
