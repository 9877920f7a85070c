"""Compiled element loops of the tetrahedron with nodal pressures; see ``nodal_pressure_tet``.

``nodes (B, 4, LANES)``; ``inverse (B, 9, LANES)`` of the matrix whose columns are the undeformed
edges from corner 0, so its rows are the gradients of the other three shapes; ``V (B, LANES)``.
"""

from __future__ import annotations

from fem_reference.lanes import LANES, pick
from sphsolid.compiled import inlined, kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import (
    axpy,
    cofactor,
    determinant,
    multiply,
    scale,
    transpose,
)
from sphsolid.continuum.wave_speed import smallest_stretch


@inlined
def _deformation(x, nodes, inverse, lane):  # type: ignore[no-untyped-def]
    """``F`` of the tetrahedron in ``lane``."""
    a, b, c, d = nodes[0, lane], nodes[1, lane], nodes[2, lane], nodes[3, lane]
    edges = (
        x[b, 0] - x[a, 0], x[c, 0] - x[a, 0], x[d, 0] - x[a, 0],
        x[b, 1] - x[a, 1], x[c, 1] - x[a, 1], x[d, 1] - x[a, 1],
        x[b, 2] - x[a, 2], x[c, 2] - x[a, 2], x[d, 2] - x[a, 2],
    )  # fmt: skip
    return multiply(edges, pick(inverse, 0, lane))


@kernel
def deformed_volumes(x, nodes, inverse, V, given):  # type: ignore[no-untyped-def]
    """``given (B, 4, LANES)``: a quarter of ``V_e det F_e`` for every corner."""
    for b in prange(nodes.shape[0]):
        for lane in range(LANES):
            F = _deformation(x, nodes[b], inverse[b], lane)
            quarter = 0.25 * V[b, lane] * determinant(F)
            for c in range(4):
                given[b, c, lane] = quarter


@kernel
def element_forces(  # type: ignore[no-untyped-def]
    material, at_nodes, nodes, inverse, V, smallest_J, shrinkage, force
):
    """Corner forces ``force (B, 12, LANES)`` [N]; ``smallest_J``, ``shrinkage (B, LANES)``.

    ``at_nodes`` are positions ``(N, 3)`` [m] and pressures ``(N,)`` [Pa].
    """
    x, p = at_nodes
    for b in prange(nodes.shape[0]):
        for lane in range(LANES):
            F = _deformation(x, nodes[b], inverse[b], lane)
            H, J = cofactor(F), determinant(F)
            mean = 0.25 * (
                p[nodes[b, 0, lane]] + p[nodes[b, 1, lane]]
                + p[nodes[b, 2, lane]] + p[nodes[b, 3, lane]]
            )  # fmt: skip
            excess = mean - law.volumetric_pressure(material, J)
            P = axpy(excess, H, law.first_piola(material, F, H, J))
            # Columns are the forces of corners 1, 2, 3.
            f = scale(V[b, lane], multiply(P, transpose(pick(inverse[b], 0, lane))))
            for i in range(3):
                force[b, i, lane] = -(f[3 * i] + f[3 * i + 1] + f[3 * i + 2])
                force[b, 3 + i, lane] = f[3 * i]
                force[b, 6 + i, lane] = f[3 * i + 1]
                force[b, 9 + i, lane] = f[3 * i + 2]
            smallest_J[b, lane] = J
            shrinkage[b, lane] = smallest_stretch(F) / max(1.0, J * law.stiffening(material, J))


@kernel
def isochoric_energies(material, x, nodes, inverse, V, energies):  # type: ignore[no-untyped-def]
    """``V_e [W - U(det F_e)] (B, LANES)`` [J]."""
    for b in prange(nodes.shape[0]):
        for lane in range(LANES):
            F = _deformation(x, nodes[b], inverse[b], lane)
            J = determinant(F)
            W = law.stored_energy(material, F, cofactor(F), J)
            energies[b, lane] = V[b, lane] * (W - law.volumetric_energy(material, J))
