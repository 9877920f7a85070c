"""Limits of sequences of lattices."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.errors import InputError
from studies.measures.extrapolate import extrapolate, sign_changes

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
