"""Areas that a traction acts over: of each smooth side of a tag, with the facets' own resultant.

An operator may have areas of its own, which integrate smooth functions over a whole side well.  Of
a tag that ends within a side, or of one side of a tag that goes round an edge, they need not have
the area, and a load would have another resultant than its user stated.  So

- at an edge every side has the components of the operator's area that its facets have, where no
  component belongs to two sides; else what the operator adds to the facets is shared by size;
- areas ``A_a`` of a flat side are changed by ``A_a (l + m . X_a)``, with the ``l, m`` that give
  ``sum A_a`` and ``sum A_a (x) X_a`` of the facets.  Where they have these already, as of whole
  sides, nothing is changed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Lack of area or moment, over the area, that is round-off; and how far a side may be from flat.
_EXACT, _FLAT = 1.0e-12, 1.0e-9


def loaded_areas(X: Array, facets: Sequence[Array], whole: Array) -> list[Array]:
    """Area vectors ``(N, 3)`` [m^2] of the sides of a tag at particles ``X (N, 3)`` [m].

    ``facets`` are those of each side by its facets alone, ``whole`` the operator's of the tag.
    """
    sides = [whole] if len(facets) == 1 else _shared(facets, whole)
    return [_with_resultant(X, *each) for each in zip(facets, sides, strict=True)]


def _shared(facets: Sequence[Array], whole: Array) -> list[Array]:
    total = np.sum(facets, axis=0)
    owners = np.sum([np.abs(side) > 1.0e-9 * np.abs(side).max() for side in facets], axis=0)
    if owners.max() <= 1:
        return [
            np.divide(side * whole, total, out=np.zeros_like(whole), where=total != 0.0)
            for side in facets
        ]
    sizes = [np.linalg.norm(side, axis=1) for side in facets]
    size = np.sum(sizes, axis=0)
    share = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    more = whole - total
    return [
        side + (each * share)[:, None] * more for side, each in zip(facets, sizes, strict=True)
    ]


def _with_resultant(X: Array, facets: Array, side: Array) -> Array:
    """A flat ``side`` with area and moments of its ``facets``; any other as it is."""
    size = np.linalg.norm(side, axis=1)
    rows = np.flatnonzero(size > 0.0)
    normal = np.sum(facets, axis=0)
    normal = normal / (np.linalg.norm(normal) or 1.0)
    along = side[rows] @ normal
    if len(rows) == 0 or np.max(np.abs(along - size[rows])) > _FLAT * np.max(size):
        return side
    middle = X[rows].mean(axis=0)
    reach = float(np.max(np.abs(X[rows] - middle))) or 1.0
    basis = np.column_stack([np.ones(len(rows)), (X[rows] - middle) / reach])
    lack = basis.T @ (facets[rows] @ normal - along)
    if np.max(np.abs(lack)) <= _EXACT * float(np.sum(along)):
        return side
    # On a plane one of the four functions depends on the others.
    G = basis.T @ (along[:, None] * basis)
    factor = basis @ (np.linalg.pinv(G, rcond=1.0e-10, hermitian=True) @ lack)
    changed = side.copy()
    changed[rows] *= (1.0 + factor)[:, None]
    return changed
