"""The study of operators: its variants, and what its table makes of planted rows."""

from __future__ import annotations

import numpy as np
import pytest

from studies import operators
from studies.engine.study import parse


def planted(variant, order, *, diverged=False):
    """Rows of a variant whose errors fall with ``order``, one stress component more slowly."""
    rows = [
        {"scene": "cube", "variant": variant, "family": family, "component": name, "h": h,
         "error": h ** (order - slower), "wall_s": 1.0}
        for family in ("A+B+C=0", "A=B=C") for h in (1 / 8, 1 / 16)
        for name, slower in (("p_x", 0.0), ("P_xx", 0.1), ("P_xy", 0.3))
    ]  # fmt: skip
    found = {} if diverged else {"twist": 5.9, "energy": 0.9, "pressure_99": 2.0}
    column = {"scene": "column", "variant": variant, "cells": 3, "folded": diverged}
    return [*rows, column | found]


def test_the_table_has_the_worst_slope_and_a_gap_for_a_run_that_diverged():
    table = operators.tables([*planted("a", 2.0), *planted("b", 1.0, diverged=True)])["table"]
    assert table["variant"].tolist() == ["a", "b"]
    np.testing.assert_allclose(table["slope_p"], [2.0, 1.0])
    np.testing.assert_allclose(table["slope_P"], [1.7, 0.7])
    np.testing.assert_allclose(table["P_xx_17"], [(1 / 16) ** 1.9, (1 / 16) ** 0.9])
    np.testing.assert_allclose(table["energy_4x19x4"], [0.9, np.nan])
    assert table["twist_6x31x6"].isna().all()
    assert table["folded"].tolist() == [False, True]


def test_every_variant_differs_from_every_other_in_what_is_run():
    listed = operators.cases(parse(operators.STUDY, []))
    assert len({case.key for case in listed}) == len(listed)
    recipes = [repr(method.recipe) for method in operators.VARIANTS]
    assert len(set(recipes)) == len(recipes)
    quick = operators.cases(parse(operators.STUDY, ["--quick"]))
    assert {case.arguments["method"].name for case in quick} == set(operators.SHORT_FORM)


@pytest.mark.filterwarnings("ignore::sphsolid.errors.FoldingWarning")
def test_a_coarse_column_gives_its_numbers_and_says_that_it_folded():
    (row,) = operators.column(method=operators.BASE, cells=2)
    assert row["survived"]
    assert row["folded"]
    assert row["twist"] == pytest.approx(5.9, abs=1.0)
    assert 0.5 < row["energy"] <= 1.0 + 1e-9
    assert row["pressure_1"] < row["pressure_99"]
