"""Exact linear algebra in rational numbers: small systems, solved without rounding."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

Row = list[Fraction]


def eliminate(rows: Sequence[Sequence[Fraction]]) -> tuple[list[Row], list[int]]:
    """Reduced row echelon form of an augmented matrix, and the pivot column of each row.

    Rows that say nothing are left out.  Raises ``ValueError`` where the system has no solution.
    """
    work = [list(row) for row in rows]
    width = len(work[0]) - 1
    pivots: list[int] = []
    top = 0
    for column in range(width):
        found = next((i for i in range(top, len(work)) if work[i][column]), None)
        if found is None:
            continue
        work[top], work[found] = work[found], work[top]
        factor = work[top][column]
        work[top] = [value / factor for value in work[top]]
        for i, row in enumerate(work):
            if i != top and row[column]:
                times = row[column]
                work[i] = [a - times * b for a, b in zip(row, work[top], strict=True)]
        pivots.append(column)
        top += 1
    if any(row[width] for row in work[top:]):
        raise ValueError("the system has no solution")
    return work[:top], pivots


def solutions(rows: Sequence[Sequence[Fraction]]) -> tuple[Row, list[Row]]:
    """A solution of an augmented system and a basis of its null space."""
    reduced, pivots = eliminate(rows)
    width = len(rows[0]) - 1
    particular = [Fraction(0)] * width
    for row, pivot in zip(reduced, pivots, strict=True):
        particular[pivot] = row[width]
    basis = []
    for free in (column for column in range(width) if column not in pivots):
        vector = [Fraction(0)] * width
        vector[free] = Fraction(1)
        for row, pivot in zip(reduced, pivots, strict=True):
            vector[pivot] = -row[free]
        basis.append(vector)
    return particular, basis


def least_squares(matrix: Sequence[Row], right: Sequence[Fraction]) -> Row:
    """``y`` that minimises ``|matrix y - right|^2``, the unknowns it does not see set to zero."""
    count = len(matrix[0])
    normal = [
        [sum((row[i] * row[j] for row in matrix), Fraction(0)) for j in range(count)]
        + [sum((row[i] * b for row, b in zip(matrix, right, strict=True)), Fraction(0))]
        for i in range(count)
    ]
    return solutions(normal)[0]
