"""Differences that sum by parts, derived in exact rational arithmetic.

On ``n`` points at unit distance, ``D = H^-1 Q`` with a diagonal positive ``H`` and

    Q + Q^T = diag(-1, 0, ..., 0, 1),        D x^k = k x^(k-1),  k = 0 .. p

so that ``sum h (u Dv + v Du)`` is the boundary term, and ``H`` is the quadrature that goes with it
[Kreiss1974], [Strand1994].  Inside, rows are the central difference of ``order = 2 p``; ``2 p``
rows at each end, or all of them where there are fewer points than two ends take, are found here.
What freedom the conditions leave makes the error of ``D x^(p+1)`` least; on a short axis it keeps
nearest to the central difference.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import factorial

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.lattice.rational import Row, least_squares, solutions
from sphsolid.errors import InputError

#: Rows at an end that are not the central difference.
_ENDS = {2: 1, 4: 4, 6: 6}


@dataclass(frozen=True)
class Difference:
    """``H`` as ``weights (n,)`` and ``Q`` as ``products (n, n)``, both exact."""

    order: int
    weights: tuple[Fraction, ...]
    products: tuple[tuple[Fraction, ...], ...]

    @property
    def exactness(self) -> int:
        """Degree ``p`` of the polynomials that it differentiates exactly, boundary included."""
        n = len(self.weights)
        for k in range(1, n + 1):
            if any(
                sum((q * Fraction(j) ** k for j, q in enumerate(row)), Fraction(0))
                != k * h * Fraction(i) ** (k - 1)
                for i, (row, h) in enumerate(zip(self.products, self.weights, strict=True))
            ):
                return k - 1
        return n

    def arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """``h (n,)`` and ``D = H^-1 Q (n, n)``, rounded once."""
        h = np.array([float(weight) for weight in self.weights])
        D = np.array(
            [
                [float(q / weight) for q in row]
                for row, weight in zip(self.products, self.weights, strict=True)
            ]
        )
        return h, D


@cache
def central(order: int) -> tuple[Fraction, ...]:
    """Coefficients ``c_m`` of ``sum_m c_m (u_(i+m) - u_(i-m))``, ``m = 1 .. order / 2``."""
    p = order // 2
    return tuple(
        Fraction((-1) ** (m + 1) * factorial(p) ** 2, m * factorial(p - m) * factorial(p + m))
        for m in range(1, p + 1)
    )


def points_needed(order: int) -> int:
    """Points from which both ends and the interior have the rows of a long axis."""
    return 2 * _ENDS[order]


@cache
def difference(order: int, n: int) -> Difference:
    """The difference of ``order`` 2, 4 or 6 on ``n`` points, dense where ``n`` is small.

    Raises ``InputError`` for another order, and where ``n`` points admit no positive weights.
    """
    if order not in _ENDS:
        raise InputError(f"order = {order} of a lattice difference must be 2, 4 or 6")
    p = order // 2
    if n < 2 * p:
        raise InputError(
            f"{n} points in a row are too few for a difference of order {order}: it needs "
            f"{2 * p}; use a smaller spacing or a lower order"
        )
    found = _Unknowns(order, n)
    start, basis = solutions([row for k in range(p + 1) for row in found.conditions(k)])
    if basis:
        matrix, right = found.freedom(start, basis)
        share = least_squares(matrix, right)
        start = [
            value + _applied(share, [vector[i] for vector in basis])
            for i, value in enumerate(start)
        ]
    result = found.difference(start)
    if min(result.weights) <= 0:
        raise InputError(f"{n} points in a row have no positive weights of order {order}")
    return result


def _applied(row: Row, vector: Row) -> Fraction:
    return sum((a * b for a, b in zip(row, vector, strict=False)), Fraction(0))


class _Unknowns:
    """What is free: the weights and the skew products of the ends, mirror images of each other."""

    def __init__(self, order: int, n: int) -> None:
        self.order, self.n = order, n
        self.ends = min(_ENDS[order], (n + 1) // 2)
        self.dense = dense = n < points_needed(order)
        pairs = [(i, j) for i in range(n) for j in range(i + 1, n) if self._is_free(i, j, dense)]
        #: Each class of mirrored pairs is one unknown: Q_ij = -Q_ji = Q_(n-1-j)(n-1-i).
        self._of_pair: dict[tuple[int, int], int] = {}
        count = self.ends
        for i, j in pairs:
            mirror = (n - 1 - j, n - 1 - i)
            if mirror in self._of_pair:
                self._of_pair[i, j] = self._of_pair[mirror]
            else:
                self._of_pair[i, j] = count
                count += 1
        self.count = count

    def _is_free(self, i: int, j: int, dense: bool) -> bool:
        if dense:
            return True
        return j < self.ends or i >= self.n - self.ends

    def _weight(self, i: int) -> int | None:
        nearest = min(i, self.n - 1 - i)
        return nearest if nearest < self.ends else None

    def _fixed(self, i: int, j: int) -> Fraction:
        if i == j:
            return Fraction({0: -1, self.n - 1: 1}.get(i, 0), 2)
        distance = abs(j - i)
        known = central(self.order)
        if distance > len(known):
            return Fraction(0)
        return known[distance - 1] * (1 if j > i else -1)

    def conditions(self, k: int) -> list[Row]:
        """``sum_j Q_ij j^k - k h_i i^(k-1) = 0`` of every row that holds an unknown."""
        rows = []
        middle = Fraction(self.n - 1, 2)
        for i in range((self.n + 1) // 2):
            row = [Fraction(0)] * (self.count + 1)
            x = [Fraction(j) - middle for j in range(self.n)]
            for j in range(self.n):
                unknown = self._of_pair.get((min(i, j), max(i, j)))
                if i != j and unknown is not None:
                    row[unknown] += x[j] ** k * (1 if j > i else -1)
                else:
                    row[-1] -= self._fixed(i, j) * x[j] ** k
            slope = k * x[i] ** (k - 1) if k else Fraction(0)
            weight = self._weight(i)
            if weight is None:
                row[-1] += slope
            else:
                row[weight] -= slope
            if any(row[:-1]):
                rows.append(row)
        return rows

    def freedom(self, start: Row, basis: list[Row]) -> tuple[list[Row], Row]:
        """What the shares of ``basis`` should make small: ``matrix share - right``.

        The error of the next power, at the ends of a long axis.  On a short one, where that may
        ask for negative weights, the distance from the central difference with weights of one.
        """
        if self.dense:
            target = self.central()
            matrix = [[vector[i] for vector in basis] for i in range(self.count)]
            return matrix, [goal - value for goal, value in zip(target, start, strict=True)]
        errors = self.conditions(self.order // 2 + 1)
        matrix = [[_applied(row, vector) for vector in basis] for row in errors]
        return matrix, [row[-1] - _applied(row, start) for row in errors]

    def central(self) -> Row:
        """The unknowns of the interior: weights of one, and its products."""
        values = [Fraction(1)] * self.count
        for (i, j), unknown in self._of_pair.items():
            values[unknown] = self._fixed(i, j)
        return values

    def difference(self, values: Row) -> Difference:
        """The difference that the unknowns make."""
        weights = []
        for i in range(self.n):
            weight = self._weight(i)
            weights.append(Fraction(1) if weight is None else values[weight])
        products = tuple(
            tuple(
                values[self._of_pair[min(i, j), max(i, j)]] * (1 if j > i else -1)
                if i != j and (min(i, j), max(i, j)) in self._of_pair
                else self._fixed(i, j)
                for j in range(self.n)
            )
            for i in range(self.n)
        )
        return Difference(self.order, tuple(weights), products)
