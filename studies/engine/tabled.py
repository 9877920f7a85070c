"""Do rows that a case gives now stand in the tables of a report?  For a report from a clone.

What a study keeps of its cases is no part of the repository, its tables are.  A row stands in a
table that shares most of its columns, together with others that the study made of all rows; so
only the values that the case itself gave are compared.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pandas as pd

from studies.engine.case import Row
from studies.engine.results import Tables

#: Values that agree to this share are the same: long tables have seven digits.
SAME = 1.0e-6
#: A row that shares fewer columns with every table is in none.
LEAST = 3
#: Of the columns that the best table shares; a study may put its rows into several.
NEARLY = 0.6


def compared(
    rows: Sequence[Row], tables: Tables, is_time: Callable[[str], Any], within: float = SAME
) -> tuple[int, list[str]]:
    """How many of ``rows`` are of a table's kind, and in words which of these are not there.

    ``within``: relative difference of values that are the same.
    """
    count, differ = 0, list[str]()
    for k, row in enumerate(rows):
        given = {name: value for name, value in row.items() if _says(value) and not is_time(name)}
        found = [_difference(given, each, max(within, SAME)) for each in _tables_of(given, tables)]
        count += bool(found)
        if found and all(found):
            differ.append(f"row {k + 1}, {found[0]}")
    return count, differ


def _says(value: Any) -> bool:
    """True for a text or number that is there."""
    if isinstance(value, str):
        return value != ""
    return isinstance(value, bool | int | float) and not math.isnan(value)


def _tables_of(row: Mapping[str, Any], tables: Tables) -> list[pd.DataFrame]:
    """Those that the row may stand in, the likeliest first."""

    def shared(table: pd.DataFrame) -> int:
        names = row.keys() & set(table)
        return len(names) if any(isinstance(row[name], float) for name in names) else 0

    likely = sorted(tables.values(), key=shared, reverse=True)
    least = max(LEAST, NEARLY * shared(likely[0]))
    return [table for table in likely if shared(table) >= least]


def _difference(row: Mapping[str, Any], table: pd.DataFrame, within: float) -> str:
    """Empty where a row of ``table`` has all values of ``row`` that it has a column for."""
    names = [name for name in row if name in table]
    texts = [name for name in names if isinstance(row[name], str | bool)]
    numbers = [name for name in names if name not in texts]
    alike = table
    for name in texts:
        # A column of truths with gaps is read as one of texts, and a study may say more.
        said = alike[name].astype(str)
        exact = said == str(row[name])
        alike = alike[exact if exact.any() else said.str.startswith(str(row[name]))]
    if len(alike) == 0:
        return f"none with {', '.join(f'{name} = {row[name]}' for name in texts)}"
    off = pd.DataFrame({name: _off(alike[name], float(row[name])) for name in numbers})
    closest = (off > within).sum(axis=1).idxmin()
    wrong = [name for name in numbers if off.loc[closest, name] > within]
    if not wrong:
        return ""
    name = wrong[0]
    return f"{name}: {row[name]!r}, in the report {float(alike.loc[closest, name])!r}"


def _off(column: pd.Series, value: float) -> pd.Series:
    """Relative difference of each value of ``column``; none where the report has no number."""
    found = pd.to_numeric(column, errors="coerce")
    size = max(abs(value), 1.0e-12 / SAME)
    return ((found - value).abs() / size).where(found != value, 0.0).fillna(0.0)
