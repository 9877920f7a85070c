"""The set-up study: its table, and what it refuses."""

from __future__ import annotations

import json

import pandas as pd
import pytest

from studies import set_up


def test_the_table_has_both_operators_at_both_sizes(tmp_path, capsys):
    assert set_up.main(["--cells", "6", "4", "--out", str(tmp_path)]) == 0
    table = pd.read_csv(tmp_path / "table.csv")
    assert table["operator"].tolist() == ["Consistent"] * 2 + ["SummationByParts"] * 2
    assert table["particles"].tolist() == [125, 343] * 2
    assert (table[["C0", "C1", "D0"]] < 1e-11).all(axis=None)
    assert (table["SBP"] < 1e-3).tolist() == [False, False, True, True]
    assert table["growth"].isna().tolist() == [True, False, True, False]
    assert json.loads((tmp_path / "run.json").read_text())["study"] == "set_up"
    assert "SummationByParts" in capsys.readouterr().out


def test_too_few_cells_are_refused(capsys):
    with pytest.raises(SystemExit):
        set_up.main(["--cells", "many"])
    assert set_up.main(["--cells", "2"]) == 2
    assert "give at least 4" in capsys.readouterr().err
