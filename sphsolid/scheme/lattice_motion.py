"""Kick and drift of all particles in one pass, where nothing else has to see the state between."""

from __future__ import annotations

from sphsolid.compiled import kernel, prange


@kernel
def kick_and_drift(dt, f, a, b, p, x):  # type: ignore[no-untyped-def]
    """``p += dt f``, then ``x += a p`` and ``x += b p``, for flat arrays.

    The same bits as three passes: the drift that ends a step and the one that begins the next.
    """
    for i in prange(len(p)):
        p_i = p[i] + dt * f[i]
        p[i] = p_i
        x_i = x[i] + a * p_i
        x[i] = x_i + b * p_i


@kernel
def kick_and_half_drift(dt, f, a, p, x):  # type: ignore[no-untyped-def]
    """``p += dt f``, then ``x += a p``."""
    for i in prange(len(p)):
        p_i = p[i] + dt * f[i]
        p[i] = p_i
        x[i] += a * p_i
