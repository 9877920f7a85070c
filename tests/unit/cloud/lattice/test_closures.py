"""Differences that sum by parts: exact identities, and weights known from the literature."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from sphsolid.cloud.lattice.closures import central, difference, points_needed
from sphsolid.errors import InputError

SIZES = [(2, n) for n in (2, 3, 5, 9)] + [(4, n) for n in range(4, 14)] + [
    (6, n) for n in (*range(6, 15), 20)
]  # fmt: skip


@pytest.mark.parametrize(("order", "n"), SIZES)
def test_it_sums_by_parts_exactly(order, n):
    Q = difference(order, n).products
    for i in range(n):
        for j in range(n):
            boundary = {0: -1, n - 1: 1}.get(i, 0) if i == j else 0
            assert Q[i][j] + Q[j][i] == boundary


@pytest.mark.parametrize(("order", "n"), SIZES)
def test_weights_are_positive_and_polynomials_are_differentiated_exactly(order, n):
    made = difference(order, n)
    assert min(made.weights) > 0
    assert made.exactness >= order // 2
    assert made.weights == made.weights[::-1]
    assert sum(made.weights) == n - 1


@pytest.mark.parametrize(("order", "n"), SIZES)
def test_the_weights_are_the_quadrature_that_goes_with_it(order, n):
    """``sum h x^k`` is the integral for ``k < order``: what makes totals of that order."""
    h = difference(order, n).weights
    for k in range(order):
        total = sum((w * Fraction(i) ** k for i, w in enumerate(h)), Fraction(0))
        assert total == Fraction((n - 1) ** (k + 1), k + 1)


def test_weights_of_long_axes_are_those_of_the_literature():
    """[Strand1994]: the norm of a diagonal closure is unique."""
    four = [Fraction(w, 48) for w in (17, 59, 43, 49)]
    six = [Fraction(w, 43200) for w in (13649, 60065, 27110, 53590, 39385, 43801)]
    for n in (12, 20, 33):
        assert list(difference(4, n).weights[:4]) == four
        assert list(difference(6, n).weights[:6]) == six
        assert set(difference(4, n).weights[4:-4]) <= {1}


def test_inside_it_is_the_central_difference():
    assert central(4) == (Fraction(2, 3), Fraction(-1, 12))
    assert central(6) == (Fraction(3, 4), Fraction(-3, 20), Fraction(1, 60))
    row = difference(6, 20).products[9]
    assert list(row[6:13]) == [
        Fraction(-1, 60), Fraction(3, 20), Fraction(-3, 4), 0, Fraction(3, 4), Fraction(-3, 20),
        Fraction(1, 60),
    ]  # fmt: skip
    assert not any(row[:6] + row[13:])


def test_the_same_ends_on_every_long_axis():
    for order in (2, 4, 6):
        ends = points_needed(order) // 2
        one, two = (difference(order, n).products for n in (points_needed(order), 25))
        for i in range(ends):
            assert one[i][:ends] == two[i][:ends]


@pytest.mark.parametrize("order", [2, 4, 6])
def test_errors_inside_fall_with_the_order_and_at_the_ends_with_half_of_it(order):
    errors = []
    for n in (20, 40):
        _, D = difference(order, n + 1).arrays()
        x = np.linspace(0.0, 1.0, n + 1)
        error = np.abs(n * D @ np.sin(3.0 * x) - 3.0 * np.cos(3.0 * x))
        errors.append((error[n // 3 : -n // 3].max(), error.max()))
    inside, everywhere = np.log2(np.array(errors[0]) / errors[1])
    assert inside > order - 0.1
    assert everywhere > order // 2 - 0.2


def test_too_few_points_and_other_orders_are_refused():
    with pytest.raises(InputError, match="3 points in a row"):
        difference(4, 3)
    with pytest.raises(InputError, match="must be 2, 4 or 6"):
        difference(3, 9)
