"""The pair sums of upwind SPH (see ``upwind`` for the equations)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.continuum.tensor import cofactor
from sphsolid.scheme.restraint_pairs import apart, mean_with
from sphsolid.scheme.tile import tensor_of

Array = NDArray[np.float64]


class Faces(NamedTuple):
    """Row ``a`` has the pairs ``indptr[a] .. indptr[a + 1]``.

    They are ``indices`` with ``area (3, P)`` [m^2].  ``X (3, .)`` [m] are the particles, ``V (N,)``
    [m^3] their volumes.
    """

    indptr: NDArray[np.uint64]
    indices: NDArray[np.uint32]
    area: Array
    X: Array
    V: Array


class Speeds(NamedTuple):
    """Impedances over the density [m/s], along the normal and across it; what the normal is."""

    along: float
    across: float
    of_pair: bool


@kernel
def limiters(faces, p, gradient, density, phi):  # type: ignore[no-untyped-def]
    """``phi (3, .)``: how much of each slope keeps half-way values between those of neighbours.

    [Barth1989].  ``gradient`` is ``grad v``, ``p = density v (3, .)``.
    """
    for a in prange(len(faces.V)):
        L = tensor_of(gradient, a)
        for i in range(3):
            low = high = here = p[i, a]
            for k in range(faces.indptr[a], faces.indptr[a + 1]):
                there = p[i, faces.indices[k]]
                low, high = min(low, there), max(high, there)
            share = 1.0
            for k in range(faces.indptr[a], faces.indptr[a + 1]):
                X = apart(faces.X, a, faces.indices[k])
                rise = 0.5 * density * (L[3 * i] * X[0] + L[3 * i + 1] * X[1] + L[3 * i + 2] * X[2])
                if rise > high - here:
                    share = min(share, (high - here) / rise)
                elif rise < low - here:
                    share = min(share, (low - here) / rise)
            phi[i, a] = share


@kernel
def upwind(faces, speeds, motion, phi, density, out):  # type: ignore[no-untyped-def]
    """``D(p) (3, .)`` [N/m^3] of ``motion = (x, p, F, L)``, ``L = grad v``.

    Of zero length are ``L`` where nothing is reconstructed and ``phi`` where nothing is limited.
    """
    x, p, F, L = motion
    reconstructs, limits = L.size > 0, phi.size > 0
    for a in prange(len(faces.V)):
        f0 = f1 = f2 = 0.0
        F_a = tensor_of(F, a)
        L_a = tensor_of(L, a) if reconstructs else F_a
        for k in range(faces.indptr[a], faces.indptr[a + 1]):
            b = faces.indices[k]
            j0, j1, j2 = apart(p, a, b)
            if reconstructs:
                X = apart(faces.X, a, b)
                L_b = tensor_of(L, b)
                h = 0.5 * density
                u0 = h * (L_a[0] * X[0] + L_a[1] * X[1] + L_a[2] * X[2])
                u1 = h * (L_a[3] * X[0] + L_a[4] * X[1] + L_a[5] * X[2])
                u2 = h * (L_a[6] * X[0] + L_a[7] * X[1] + L_a[8] * X[2])
                w0 = h * (L_b[0] * X[0] + L_b[1] * X[1] + L_b[2] * X[2])
                w1 = h * (L_b[3] * X[0] + L_b[4] * X[1] + L_b[5] * X[2])
                w2 = h * (L_b[6] * X[0] + L_b[7] * X[1] + L_b[8] * X[2])
                if limits:
                    u0, u1, u2 = phi[0, a] * u0, phi[1, a] * u1, phi[2, a] * u2
                    w0, w1, w2 = phi[0, b] * w0, phi[1, b] * w1, phi[2, b] * w2
                # Both ends add the same two numbers, so the forces of a pair cancel to the bit.
                j0, j1, j2 = j0 - (u0 + w0), j1 - (u1 + w1), j2 - (u2 + w2)
            A0, A1, A2 = faces.area[0, k], faces.area[1, k], faces.area[2, k]
            size = math.sqrt(A0 * A0 + A1 * A1 + A2 * A2)
            if speeds.of_pair:
                n0, n1, n2 = apart(x, a, b)
            else:
                H = cofactor(mean_with(F, F_a, b))
                n0 = H[0] * A0 + H[1] * A1 + H[2] * A2
                n1 = H[3] * A0 + H[4] * A1 + H[5] * A2
                n2 = H[6] * A0 + H[7] * A1 + H[8] * A2
            normal = (j0 * n0 + j1 * n1 + j2 * n2) / (n0 * n0 + n1 * n1 + n2 * n2)
            normal *= speeds.along - speeds.across
            f0 += size * (speeds.across * j0 + normal * n0)
            f1 += size * (speeds.across * j1 + normal * n1)
            f2 += size * (speeds.across * j2 + normal * n2)
        out[0, a] = f0 / faces.V[a]
        out[1, a] = f1 / faces.V[a]
        out[2, a] = f2 / faces.V[a]
