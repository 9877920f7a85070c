"""The vector updates of an explicit step, each one pass over the nodes."""

from __future__ import annotations

from sphsolid.compiled import kernel, prange


@kernel
def add_scaled(s, b, a):  # type: ignore[no-untyped-def]
    """``a += s b`` for ``a, b (N, 3)``."""
    for n in prange(a.shape[0]):
        a[n, 0] += s * b[n, 0]
        a[n, 1] += s * b[n, 1]
        a[n, 2] += s * b[n, 2]


@kernel
def divide_by_mass(mass, force):  # type: ignore[no-untyped-def]
    """``force (N, 3)`` becomes ``-force / mass``, ``mass (N, 1)``."""
    for n in prange(force.shape[0]):
        m = -mass[n, 0]
        force[n, 0] /= m
        force[n, 1] /= m
        force[n, 2] /= m


@kernel
def keep_free(nodes, free, velocity):  # type: ignore[no-untyped-def]
    """``v_a <- free_a v_a`` at ``nodes (n,)``, ``free (n, 3, 3)``, in ``velocity (N, 3)``."""
    for k in prange(nodes.shape[0]):
        n = nodes[k]
        x, y, z = velocity[n, 0], velocity[n, 1], velocity[n, 2]
        velocity[n, 0] = free[k, 0, 0] * x + free[k, 0, 1] * y + free[k, 0, 2] * z
        velocity[n, 1] = free[k, 1, 0] * x + free[k, 1, 1] * y + free[k, 1, 2] * z
        velocity[n, 2] = free[k, 2, 0] * x + free[k, 2, 1] * y + free[k, 2, 2] * z
