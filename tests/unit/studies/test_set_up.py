"""The set-up study: its table, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from studies import set_up
from studies.engine.study import main, parse


def test_the_table_has_both_operators_at_both_sizes():
    listed = set_up.cases(parse(set_up.STUDY, ["--cells", "6", "4"]))
    table = set_up.tables([row for case in listed for row in case.run(**case.arguments)])["table"]
    assert table["operator"].tolist() == ["Consistent"] * 2 + ["SummationByParts"] * 2
    assert table["particles"].tolist() == [125, 343] * 2
    assert (table[["C0", "C1", "D0"]] < 1e-11).all(axis=None)
    assert (table["SBP"] < 1e-3).tolist() == [False, False, True, True]
    assert table["growth"].isna().tolist() == [True, False, True, False]


def test_growth_is_the_exponent_of_the_time():
    N = np.array([100, 1000, 5000])
    rows = [
        {"operator": name, "particles": n, "seconds": 2.0 * n**power}
        for name, power in (("a", 1.2), ("b", 0.7)) for n in N
    ]  # fmt: skip
    growth = set_up.tables(rows)["table"]["growth"]
    np.testing.assert_allclose(growth, [np.nan, 1.2, 1.2, np.nan, 0.7, 0.7])


def test_what_is_asked_is_run_one_at_a_time_and_too_few_cells_are_refused(capsys):
    options = parse(set_up.STUDY, ["--operators", "Consistent", "--cells", "8"])
    assert [case.key for case in set_up.cases(options)] == ["Consistent 1/8"]
    assert options.jobs == 1
    with pytest.raises(SystemExit):
        main(set_up.STUDY, ["--cells", "many"])
    assert main(set_up.STUDY, ["--cells", "2"]) == 2
    assert "give at least 4" in capsys.readouterr().err
