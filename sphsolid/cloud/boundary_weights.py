"""Area vectors that integrate quadratics over the boundary exactly, one a boundary particle.

Let a pair sum by parts, ``C + C^T = B``, with first-order exact rows ``C 1 = 0`` and
``C^d X_e = delta_de V``.  It exists only if for all polynomials ``p, q`` of degree one

    p^T B^d q = int_boundary p q n_d dA:

``B`` must integrate *quadratics* exactly.  The consistent mass ``int N_a N_b n dA`` does.  But it
averages over neighbours on the boundary, while nothing averages normal to it.  This difference is
an error ``O(dx)`` of the normal derivative, which on a lattice doubles the errors of momentum and
stress.  Lumped areas ``B = diag(A_a N_a)`` have no such average, but integrate quadratics with an
error of ``O(dx^2)``.  The smallest relative change of the areas removes that error:

    A_a N_a  <-  A_a N_a [1 + N_a . lambda q(X_a)],    q the ten quadratics,

30 numbers in all.  On a lattice box the errors of opposite faces cancel and the change is zero.
Elsewhere it is ``O(dx^2)``.  (Exactness face by face is too much to ask: it changes the areas near
edges, and costs as much accuracy as the consistent mass.)

Where a tag's particles all lie on one quadric, as on a cylinder, no areas that keep their sums and
first moments change its moment.  What is then missing is 1e-6 of the boundary.  The pair sums by
parts as far as that (``skew_change``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from sphsolid.geometry.integrals import area_vectors, boundary_mass
from sphsolid.geometry.mesh import Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Singular values below this share of the largest belong to conditions that depend on each other.
#: Far from the origin a plane is flat to the round-off of its positions only: 1e-10 of a metre at
#: 1e6 m.  Taken for conditions of their own, such bumps would change the areas by chance.
_DEPENDENT = 1.0e-8
_PAIRS = [(i, j) for i in range(4) for j in range(i, 4)]


def _linears(X: Array, chosen: Indices) -> Array:
    """``1, x, y, z`` in coordinates that run from -1 to 1 over the chosen of ``X (N, 4)``."""
    low, high = X[chosen].min(axis=0), X[chosen].max(axis=0)
    size = np.maximum(high - low, 1.0e-12 * np.max(high - low))
    # From the middle first: that difference is exact, wherever the body lies.
    x = (X - 0.5 * (low + high)) * (2.0 / size)
    return np.concatenate([np.ones((len(x), 1)), x], axis=1)


def _products(values: Array, normals: Array) -> Array:
    """``q_i n_d`` of every particle ``(n, 3 i)``."""
    return (values[:, :, None] * normals[:, None, :]).reshape(len(values), -1)


def _least_norm(asked: Array, right: Array, kept: Array) -> Array:
    """Smallest ``f`` with ``kept^T f = 0`` and ``asked^T f = right`` as far as it can.

    Conditions depend on each other on planes and in small tags.  By orthogonal factors: the square
    of these matrices would leave 1e-7 of the conditions, and a pair that sums by parts exists only
    where they hold.
    """
    basis, sizes, _ = np.linalg.svd(kept, full_matrices=False)
    basis = basis[:, sizes > _DEPENDENT * sizes[0]]
    free = asked - basis @ (basis.T @ asked)
    f = np.zeros(len(asked))
    # The second time takes what round-off left of the first.
    for _ in range(2):
        f += np.linalg.lstsq(free.T, right - free.T @ f, rcond=_DEPENDENT)[0]
    return np.asarray(f - basis @ (basis.T @ f))


def quadratic_moments(mesh: Mesh) -> tuple[Array, Array]:
    """Quadratics ``q (N, 10)`` at the vertices and ``int_boundary q n dA (10, 3)``, exact."""
    linear = _linears(mesh.vertices, np.arange(len(mesh.vertices)))
    return _quadratics(linear), _exact(mesh, mesh.boundary, linear)


def _quadratics(linear: Array) -> Array:
    return np.stack([linear[:, i] * linear[:, j] for i, j in _PAIRS], axis=1)


def _exact(mesh: Mesh, facets: Indices, linear: Array) -> Array:
    exact = np.empty((len(_PAIRS), 3))
    for d, mass in enumerate(boundary_mass(mesh, facets)):
        table = linear.T @ (mass @ linear)
        exact[:, d] = [table[i, j] for i, j in _PAIRS]
    return exact


def quadratically_exact_areas(mesh: Mesh) -> dict[str, Array]:
    """``A_a N_a (N, 3)`` [m^2] of every tag: together exact for all quadratics on the boundary.

    ``sum_a A_a N_a`` and ``sum_a A_a N_a (x) X_a`` of each tag are those of its facets, so that
    force and moment of a constant traction do not change.  Each part of a body is one by itself.
    """
    part = _parts(mesh)
    areas = {name: np.zeros_like(mesh.vertices) for name in mesh.faces}
    for number in range(int(part.max()) + 1):
        facets = {
            name: tagged[part[tagged[:, 0]] == number] for name, tagged in mesh.faces.items()
        }
        # A tag may lie on some parts only.
        facets = {name: tagged for name, tagged in facets.items() if len(tagged)}
        if not facets:
            continue
        for name, area in _areas_of_part(mesh, facets, np.flatnonzero(part == number)).items():
            areas[name] += area
    return areas


def _parts(mesh: Mesh) -> Indices:
    """Number of the connected part ``(N,)`` that a vertex belongs to."""
    size, corners = len(mesh.vertices), mesh.cells.shape[1]
    first = np.repeat(mesh.cells[:, 0], corners - 1)
    others = mesh.cells[:, 1:].ravel()
    links = coo_array((np.ones(len(first), dtype=np.int8), (first, others)), shape=(size, size))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def _areas_of_part(
    mesh: Mesh, facets: dict[str, Indices], particles: Indices
) -> dict[str, Array]:
    """The areas of a part with the ``facets`` of every tag and these ``particles``."""
    linear = _linears(mesh.vertices, particles)
    values = _quadratics(linear)
    exact = _exact(mesh, np.concatenate(list(facets.values())), linear)
    areas = {name: area_vectors(mesh, tagged) for name, tagged in facets.items()}
    whole = np.sum(list(areas.values()), axis=0)
    # The change is A f with the least sum of A f^2; it lies along A, so that a plane keeps its
    # normal.  Unknowns sqrt(A) f, of all tags one after the other.
    total = float(np.sum(np.linalg.norm(whole, axis=1)))
    sizes = {name: np.linalg.norm(area, axis=1) for name, area in areas.items()}
    there = {name: np.flatnonzero(size > 0.0) for name, size in sizes.items()}
    kept = np.zeros((sum(map(len, there.values())), 12 * len(areas)))
    asked, roots = [], {}
    first = 0
    for k, (name, area) in enumerate(areas.items()):
        at = there[name]
        size = sizes[name][at, None]
        roots[name] = np.sqrt(size / total)
        normal = area[at] / size
        last = first + len(at)
        kept[first:last, 12 * k : 12 * (k + 1)] = _products(linear[at], roots[name] * normal)
        asked.append(_products(values[at], roots[name] * normal))
        first = last
    right = ((exact - values.T @ whole) / total).ravel()
    f = _least_norm(np.concatenate(asked), right, kept)
    ends = np.cumsum([len(at) for at in there.values()])[:-1]
    for (name, at), change in zip(there.items(), np.split(f, ends), strict=True):
        areas[name][at] *= 1.0 + change[:, None] / roots[name]
    return areas
