"""The history file: whole lines at any moment, the same doubles back."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from sphsolid.errors import InputError
from sphsolid.record import History, read_history
from sphsolid.record.history import HistoryFile, read_rows

ROWS = [
    {"time [s]": 0.0, "step": 0, "e, total [J]": 1.0 / 3.0},
    {"time [s]": 0.1, "step": 3, "e, total [J]": math.nan},
    {"time [s]": 0.1 + 0.2, "step": 7, "e, total [J]": -5e-324},
]


def filled(path, rows=ROWS):
    file = HistoryFile(path, keep=0)
    for row in rows:
        file.append(row)
    file.close()
    return path


def same(one, other):
    return repr(one) == repr(other)


def test_rows_come_back_bit_for_bit(tmp_path):
    assert same(read_rows(filled(tmp_path / "h.csv")), ROWS)
    assert list(read_history(tmp_path / "h.csv").table) == list(ROWS[0])


def test_the_file_is_what_a_finished_history_writes(tmp_path):
    History.of(ROWS).to_csv(tmp_path / "whole.csv")
    assert filled(tmp_path / "h.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_a_row_is_there_as_soon_as_it_was_appended(tmp_path):
    file = HistoryFile(tmp_path / "h.csv", keep=0)
    for k, row in enumerate(ROWS):
        file.append(row)
        assert len(read_rows(tmp_path / "h.csv")) == k + 1


@pytest.mark.parametrize("cut", range(1, 30))
def test_a_torn_last_line_is_left_out(tmp_path, cut):
    path = filled(tmp_path / "h.csv")
    text = path.read_bytes()
    path.write_bytes(text[:-cut])
    whole = text[:-cut].count(b"\n") - 1
    assert same(read_rows(path), ROWS[:whole])
    assert whole < 3


@pytest.mark.parametrize("keep", [1, 2, 3])
def test_rows_beyond_those_kept_are_cut_off(tmp_path, keep):
    path = filled(tmp_path / "h.csv")
    before = path.read_bytes()
    file = HistoryFile(path, keep=keep)
    assert same(read_rows(path), ROWS[:keep])
    for row in ROWS[keep:]:
        file.append(row)
    file.close()
    assert path.read_bytes() == before


def test_other_columns_are_refused(tmp_path):
    path = filled(tmp_path / "h.csv")
    file = HistoryFile(path, keep=3)
    with pytest.raises(InputError, match=r"differing: \['mass \[kg\]'\]"):
        file.append({**ROWS[0], "mass [kg]": 1.0})
    with pytest.raises(InputError, match="their order"):
        file.append(dict(reversed(ROWS[0].items())))
    assert same(read_rows(path), ROWS)


def test_what_is_no_history_is_refused(tmp_path):
    with pytest.raises(InputError, match="there is no history"):
        read_history(tmp_path / "none.csv")
    (tmp_path / "words.csv").write_text("time [s],step\nnoon,1\n")
    with pytest.raises(InputError, match="not a history"):
        read_history(tmp_path / "words.csv")


def test_other_programs_read_it(tmp_path):
    table = pd.read_csv(filled(tmp_path / "h.csv"))
    np.testing.assert_array_equal(table["step"], [0, 3, 7])
    assert table["e, total [J]"].isna().tolist() == [False, True, False]
