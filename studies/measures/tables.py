"""Choosing rows of a table."""

from __future__ import annotations

from typing import Any

import pandas as pd


def select(table: pd.DataFrame, **wanted: Any) -> pd.DataFrame:
    """Rows whose columns have the wanted values."""
    for column, value in wanted.items():
        table = table[table[column] == value]
    return table
