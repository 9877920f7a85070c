"""Orders and limits of sequences whose answers are known."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from sphsolid.errors import InputError
from studies.measures.order import extrapolate, fit_order, last_order, order_table, sign_changes


@pytest.mark.parametrize("order", [1.0, 1.7, 3.0])
@pytest.mark.parametrize("ratio", [2.0, 1.5])
@pytest.mark.parametrize("measure", [fit_order, last_order])
def test_recovers_a_known_order(measure, order, ratio):
    h = 0.25 / ratio ** np.arange(4)
    assert measure(h, 3.0 * h**order) == pytest.approx(order, abs=1e-12)
    shuffled = [2, 0, 3, 1]
    assert measure(h[shuffled], 3.0 * h[shuffled] ** order) == pytest.approx(order, abs=1e-12)


def test_last_order_sees_only_the_two_finest():
    h = np.array([1 / 4, 1 / 8, 1 / 16])
    error = np.array([1.0, 1.0, 0.25])
    assert last_order(h, error) == pytest.approx(2.0)
    assert fit_order(h, error) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("h", "error"),
    [
        ([0.1], [0.1]),
        ([], []),
        ([0.1, 0.1], [0.1, 0.2]),
        ([0.1, 0.2], [0.1, 0.0]),
        ([0.1, 0.2], [0.1, -0.1]),
        ([0.1, 0.2], [0.1, np.nan]),
        ([0.1, 0.0], [0.1, 0.2]),
        ([0.1, np.inf], [0.1, 0.2]),
        ([0.1, 0.2, 0.3], [0.1, 0.2]),
    ],
)
@pytest.mark.parametrize("measure", [fit_order, last_order])
def test_refuses_what_has_no_order(measure, h, error):
    with pytest.raises(InputError):
        measure(h, error)


def _table() -> pd.DataFrame:
    rows = [
        {"method": m, "component": c, "h": h, "particles": round(h**-3), "steps": 1, "wall_s": h,
         "error": h**p}
        for m, c, p in (("a", "p_x", 2.0), ("a", "P_xx", 1.0), ("b", "p_x", 3.0))
        for h in (0.25, 0.125, 0.0625)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def test_table_has_a_row_per_family_in_order_of_appearance():
    orders = order_table(_table())
    assert list(orders["method"]) == ["a", "a", "b"]
    assert list(orders["component"]) == ["p_x", "P_xx", "p_x"]
    np.testing.assert_allclose(orders["order_fitted"], [2.0, 1.0, 3.0])
    np.testing.assert_allclose(orders["order_last"], [2.0, 1.0, 3.0])
    assert list(orders["levels"]) == [3, 3, 3]
    np.testing.assert_allclose(orders["error_finest"], [0.0625**2, 0.0625, 0.0625**3])


@pytest.mark.parametrize(
    "errors", [(1.0, 1.0, 0.25), (1.0, 0.2, 0.15, 0.01), (0.5, 0.4, 0.1, 0.09)]
)
def test_a_fitted_order_in_a_table_uses_every_level(errors):
    h = 0.25 / 2.0 ** np.arange(len(errors))
    table = pd.DataFrame({"method": "a", "h": h, "error": errors})
    orders = order_table(table, by=["method"]).iloc[0]
    slope = np.polyfit(np.log(h), np.log(errors), 1)[0]
    assert orders["order_fitted"] == pytest.approx(slope)
    assert orders["order_last"] == pytest.approx(np.log2(errors[-2] / errors[-1]))
    assert abs(orders["order_fitted"] - orders["order_last"]) > 0.3


def test_table_gives_no_order_where_a_level_is_missing():
    table = _table()
    one_level = table[(table["method"] != "b") | (table["h"] == 0.25)].copy()
    orders = order_table(one_level)
    assert np.isnan(orders["order_last"].iloc[2])
    assert orders["levels"].iloc[2] == 1
    table.loc[0, "error"] = 0.0
    assert np.isnan(order_table(table)["order_fitted"].iloc[0])


def test_table_refuses_mixed_families():
    with pytest.raises(InputError, match="repeats"):
        order_table(_table(), by=["method"])
    with pytest.raises(InputError, match="error"):
        order_table(_table().drop(columns="error"))


# --- the limit of a sequence ----------------------------------------------------------------------

H = 1.0 / np.array([3.0, 4.0, 5.0, 6.0, 8.0, 10.0])


def test_two_terms_are_exact():
    found = extrapolate(H, 5.9 + 2.0 * H**2 - 30.0 * H**4)
    assert found.value == pytest.approx(5.9)
    # The second term is what an extrapolation with one misses.
    assert 1e-4 < found.within < 0.02


def test_one_term_is_known_exactly_in_any_order_of_lattices():
    mixed = [3, 0, 5, 1, 4, 2]
    found = extrapolate(H[mixed], (5.9 - 0.7 * H**2)[mixed])
    assert found.value == pytest.approx(5.9)
    assert found.within == pytest.approx(0.0, abs=1e-12)


def test_the_uncertainty_holds_the_limit_of_what_it_does_not_fit():
    for power, size in ((3, 1.0), (4, 30.0), (6, 100.0)):
        found = extrapolate(H, 5.9 + 2.0 * H**2 - size * H**power)
        assert abs(found.value - 5.9) <= found.within + 1e-12, power


def test_the_uncertainty_holds_the_limit_of_a_first_order_method():
    for slope, curve in ((1.0, 0.0), (-2.0, 0.0), (0.5, 0.3)):
        found = extrapolate(H, 5.9 + slope * H + curve * H**2)
        assert abs(found.value - 5.9) <= found.within + 1e-12, slope


def test_a_sequence_that_crosses_its_limit_is_not_taken_for_it():
    """Nearest to the limit on the third lattice, by chance, and further off on the next two."""
    values = 5.9 + 2.0 * H**2 - 45.0 * H**4
    errors = values / 5.9 - 1.0
    assert sign_changes(errors) == [1]
    assert abs(errors[2]) < min(abs(errors[3]), abs(errors[4]))
    assert extrapolate(H, values).value == pytest.approx(5.9)


def test_signs():
    assert sign_changes([-2.4, -0.8, 0.1, 0.3]) == [1]
    assert sign_changes([1.0, -1.0, 1.0]) == [0, 1]
    assert sign_changes([1.0, 0.5]) == []


def test_fewer_than_four_levels_have_no_limit():
    for h, values in (([0.1, 0.2, 0.3], [1.0] * 3), ([0.1, 0.1, 0.2, 0.3], [1.0] * 4),
                      ([0.1, 0.2, 0.3, 0.4], [1.0, np.nan, 1.0, 1.0])):  # fmt: skip
        with pytest.raises(InputError, match="extrapolate needs"):
            extrapolate(h, values)
