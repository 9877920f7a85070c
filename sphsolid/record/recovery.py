"""Recovered fields: a local least-squares polynomial through what a method computed.

On a disordered cloud the stress of a particle has an error of ``O(dx)`` that changes from one
particle to the next, and more of it beside the boundary.  Much of it cancels over a
neighbourhood, because the operators that made it sum by parts: what one particle has too much its
neighbours have too little.  The polynomial ``q`` of degree two that minimises

    sum_b V_b W(|X_b - X_a| / radius) |q(X_b) - P_b|^2

keeps that mean and leaves out the rest; ``q(X_a)`` is the recovered value, at the boundary too,
where the fit is one-sided.  This is patch recovery [Zienkiewicz1992] with a patch around each
particle.  It is done on what a run hands out, and changes nothing in the run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.compiled import kernel, prange
from sphsolid.errors import InputError, require
from sphsolid.geometry.hidden import hidden_points
from sphsolid.geometry.mesh import Mesh
from sphsolid.geometry.outline import Outline
from sphsolid.record.snapshot import PointField

Array = NDArray[np.float64]
#: Terms of a polynomial of degree 0, 1, 2 in three variables.
_TERMS = (1, 4, 10)
#: Points of a patch, at least, over the terms of its polynomial.
_ENOUGH = 1.5
#: Least ratio of the smallest to the largest eigenvalue of a patch's scaled moments.
_FLATNESS = 1.0e-8


@dataclass(frozen=True)
class Recovery:
    """Patches of ``radius`` spacings around every point, polynomials of ``degree`` 1 or 2.

    The default had the smallest errors in trials; ``studies.clouds`` measures what it gains.  It
    needs 15 points within 3.5 spacings of every point.
    """

    radius: float = 3.5
    degree: int = 2

    def __post_init__(self) -> None:
        require(
            self.degree in (1, 2) and 1.0 < self.radius < float("inf"),
            f"Recovery: degree = {self.degree} must be 1 or 2 and radius = {self.radius} a finite "
            "number of spacings above 1; 2 and 3.5 are the defaults",
        )

    def __call__(
        self, field: PointField, *, spacing: float, mesh: Mesh | None = None
    ) -> PointField:
        """The recovered field at the same points; ``spacing`` [m] of the points.

        With the ``mesh`` of the body (``Snapshot.mesh``) a patch ends where the body does: it
        takes nothing from across a slot, a notch or a gap.  Exact for polynomials of ``degree``.

        Raises ``InputError`` for values that are not finite and where a patch does not determine
        its polynomial, naming the point and what to do.
        """
        require(
            np.isfinite(spacing) and spacing > 0.0,
            f"Recovery: spacing = {spacing} m must be positive",
        )
        values = field.values.reshape(len(field.X), -1)
        lost = np.flatnonzero(~np.isfinite(values).all(axis=1))
        require(
            len(lost) == 0,
            f"Recovery: values at {len(lost)} of {len(values)} points are not finite, the first "
            f"at X = {field.X[lost[:1]].tolist()} m; recover an earlier snapshot",
        )
        reach = self.radius * spacing
        near = cKDTree(field.X).query_ball_point(field.X, reach, return_sorted=True)
        row = np.repeat(np.arange(len(near)), [len(found) for found in near])
        indices = np.concatenate(near).astype(np.int64)
        if mesh is not None:
            seen = ~hidden_points(Outline.of(mesh), field.X, row, indices)
            row, indices = row[seen], indices[seen]
        count = np.bincount(row, minlength=len(near))
        self._refuse(count < _ENOUGH * _TERMS[self.degree], field.X)
        indptr = np.concatenate([[0], np.cumsum(count)])
        shares = np.empty(len(indices))
        spread = np.empty(len(count))
        # Kernels are compiled for arrays that could be written to; a snapshot's cannot.
        X, V = (np.require(array, requirements=("C", "W")) for array in (field.X, field.V))
        _shares(indptr, indices, X, V, reach, _TERMS[self.degree], shares, spread)
        self._refuse(~(spread > _FLATNESS), field.X)
        out = np.empty_like(values)
        _sums(indptr, indices, shares, np.require(values, requirements=("C", "W")), out)
        return PointField(field.X, field.V, out.reshape(field.values.shape))

    def _refuse(self, bad: NDArray[np.bool_], X: Array) -> None:
        if np.any(bad):
            first = int(np.argmax(bad))
            raise InputError(
                f"Recovery: {int(bad.sum())} of {len(X)} patches, the first around X = "
                f"{X[first].tolist()} m, have too few points within {self.radius:g} spacings for a "
                f"polynomial of degree {self.degree}; raise radius, or use degree = 1"
            )


@kernel
def _shares(indptr, indices, X, V, reach, terms, shares, spread):  # type: ignore[no-untyped-def]
    """``shares``: what each point of a patch counts in its polynomial's value at the middle."""
    for a in prange(len(indptr) - 1):
        first, last = indptr[a], indptr[a + 1]
        psi = np.empty((last - first, terms))
        moment = np.zeros((terms, terms))
        weight = np.empty(last - first)
        for k in range(first, last):
            b = indices[k]
            x = (X[b, 0] - X[a, 0]) / reach
            y = (X[b, 1] - X[a, 1]) / reach
            z = (X[b, 2] - X[a, 2]) / reach
            r = min(1.0, np.sqrt(x * x + y * y + z * z))
            # Wendland C2; a point on the rim counts a little, so that it can be enough.
            weight[k - first] = V[b] * ((1.0 - r) ** 4 * (1.0 + 4.0 * r) + 1.0e-6)
            row = psi[k - first]
            row[0] = 1.0
            row[1], row[2], row[3] = x, y, z
            if terms == 10:
                row[4], row[5], row[6] = x * x, y * y, z * z
                row[7], row[8], row[9] = x * y, x * z, y * z
            for i in range(terms):
                for j in range(terms):
                    moment[i, j] += weight[k - first] * row[i] * row[j]
        scale = np.empty(terms)
        for i in range(terms):
            scale[i] = 1.0 / np.sqrt(moment[i, i]) if moment[i, i] > 0.0 else 1.0
        for i in range(terms):
            for j in range(terms):
                moment[i, j] *= scale[i] * scale[j]
        eigenvalue = np.linalg.eigvalsh(moment)
        spread[a] = eigenvalue[0] / eigenvalue[terms - 1]
        if spread[a] > _FLATNESS:
            unit = np.zeros(terms)
            unit[0] = scale[0]
            coefficient = np.linalg.solve(moment, unit) * scale
            for k in range(first, last):
                total = 0.0
                for i in range(terms):
                    total += psi[k - first, i] * coefficient[i]
                shares[k] = weight[k - first] * total


@kernel
def _sums(indptr, indices, shares, values, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        for c in range(values.shape[1]):
            total = 0.0
            for k in range(indptr[a], indptr[a + 1]):
                total += shares[k] * values[indices[k], c]
            out[a, c] = total
