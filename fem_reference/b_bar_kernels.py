"""Compiled element loops of the Q1-P0 hexahedron; formulas in ``b_bar_hex``.

A block of :data:`~fem_reference.lanes.LANES` elements is worked on at once in one row-wise scratch
array; ``nodes (B, 8, LANES)`` are its corners and ``maps`` its reference maps.  ``mean_share`` is
one where ``U`` sees the mean Jacobian, and zero in ``full_hex``, where it sees that of the point.
"""

from __future__ import annotations

import numpy as np

from fem_reference.hex_maps import are_distorted, pulled, pushed, volume
from fem_reference.lanes import LANES, choose, fill, gather_nodes, pick, put
from fem_reference.trilinear import ROWS, add_point, corner_sums, derivatives, pick_point
from sphsolid.compiled import inlined, kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import axpy, cofactor, contract, determinant
from sphsolid.continuum.wave_speed import smallest_stretch

# Rows of the scratch array.
_CORNERS = 0
_DERIVATIVES = 24
_FORCES = _DERIVATIVES + 3 * ROWS
_MEAN = _FORCES + 3 * ROWS
_VOLUME = _MEAN + 1
_LEAST = _MEAN + 2
_THICKNESS = _MEAN + 3
_PRESSURE = _MEAN + 4
_THINNEST = _MEAN + 5
_REFERENCE = _THINNEST + 9
_SCRATCH = _REFERENCE + 3 * ROWS


@inlined
def _add_volume(maps, g, w):  # type: ignore[no-untyped-def]
    """Add the deformed and undeformed volume of Gauss point ``g``."""
    share = maps.weights[g]
    for lane in range(LANES):
        A = pick_point(w, g, _REFERENCE, lane)
        F = pushed(maps, pick_point(w, g, _DERIVATIVES, lane), A)
        V = volume(maps, share, A)
        w[_MEAN, lane] += V * determinant(F)
        w[_VOLUME, lane] += V


@inlined
def _strains(x, nodes, maps, b, w):  # type: ignore[no-untyped-def]
    """Fill the derivatives at the Gauss points and the mean Jacobian ``Jbar`` of a block."""
    if are_distorted(maps):
        gather_nodes(maps.X, nodes[b], w)
        derivatives(maps.along, w, _CORNERS, _REFERENCE)
    gather_nodes(x, nodes[b], w)
    derivatives(maps.along, w, _CORNERS, _DERIVATIVES)
    fill(w, _MEAN, 2, 0.0)
    # Written out, not looped: a row that is known when compiling is known not to overlap another,
    # and the loop over lanes becomes vector code.
    _add_volume(maps, 0, w)
    _add_volume(maps, 1, w)
    _add_volume(maps, 2, w)
    _add_volume(maps, 3, w)
    _add_volume(maps, 4, w)
    _add_volume(maps, 5, w)
    _add_volume(maps, 6, w)
    _add_volume(maps, 7, w)
    for lane in range(LANES):
        w[_MEAN, lane] /= w[_VOLUME, lane]


@inlined
def _add_stress(material, maps, mean_share, g, w):  # type: ignore[no-untyped-def]
    """Add ``w_g P cof A`` of Gauss point ``g``; keep the least ``J`` and the thinnest ``F``."""
    share = maps.weights[g]
    for lane in range(LANES):
        A = pick_point(w, g, _REFERENCE, lane)
        F = pushed(maps, pick_point(w, g, _DERIVATIVES, lane), A)
        H = cofactor(F)
        J = determinant(F)
        excess = mean_share * (w[_PRESSURE, lane] - law.volumetric_pressure(material, J))
        P = axpy(excess, H, law.first_piola(material, F, H, J))
        add_point(pulled(maps, share, P, A), w, g, _FORCES, lane)
        # nan must stay: a plain minimum would forget it.
        least = w[_LEAST, lane]
        w[_LEAST, lane] = J if (least > J or J != J) else least
        # J/|cof F| is within sqrt(3) of the smallest stretch and nearly free; the closed form
        # costs as much as a stress, so only the Gauss point that looks thinnest gets it.
        thickness = J * J / contract(H, H)
        before = w[_THICKNESS, lane]
        thinner = thickness < before
        w[_THICKNESS, lane] = thickness if thinner else before
        put(choose(thinner, F, pick(w, _THINNEST, lane)), w, _THINNEST, lane)


@inlined
def _stresses(material, maps, mean_share, w):  # type: ignore[no-untyped-def]
    """Sums over the Gauss points of a block."""
    fill(w, _FORCES, 3 * ROWS, 0.0)
    fill(w, _LEAST, 2, np.inf)
    for lane in range(LANES):
        w[_PRESSURE, lane] = law.volumetric_pressure(material, w[_MEAN, lane])
    _add_stress(material, maps, mean_share, 0, w)
    _add_stress(material, maps, mean_share, 1, w)
    _add_stress(material, maps, mean_share, 2, w)
    _add_stress(material, maps, mean_share, 3, w)
    _add_stress(material, maps, mean_share, 4, w)
    _add_stress(material, maps, mean_share, 5, w)
    _add_stress(material, maps, mean_share, 6, w)
    _add_stress(material, maps, mean_share, 7, w)


@kernel
def element_forces(  # type: ignore[no-untyped-def]
    material, mean_share, x, nodes, maps, smallest_J, shrinkage, force
):
    """Corner forces ``force (B, 24, LANES)`` [N], ``smallest_J`` and ``shrinkage (B, LANES)``.

    ``shrinkage`` is ``lambda / max(1, s Jbar)``, ``lambda`` the smallest principal stretch and
    ``s = sqrt(max(1, U''(Jbar) / kappa))``.
    """
    for b in prange(nodes.shape[0]):
        w = np.empty((_SCRATCH, LANES))
        _strains(x, nodes, maps, b, w)
        _stresses(material, maps, mean_share, w)
        corner_sums(maps.along, w, _FORCES, _CORNERS)
        for row in range(24):
            for lane in range(LANES):
                force[b, row, lane] = w[_CORNERS + row, lane]
        for lane in range(LANES):
            smallest_J[b, lane] = w[_LEAST, lane]
            # The volumetric part of the acoustic tensor is U'' |cof F N|^2 <= U'' (J/lambda)^2:
            # a body pulled to J > 1 carries faster waves than lambda alone says.
            Jbar = w[_MEAN, lane]
            expansion = max(1.0, Jbar * law.stiffening(material, Jbar))
            shrinkage[b, lane] = smallest_stretch(pick(w, _THINNEST, lane)) / expansion


@kernel
def element_energies(material, mean_share, x, nodes, maps, energies):  # type: ignore[no-untyped-def]
    """``Pi_e (B, LANES)`` [J]."""
    for b in prange(nodes.shape[0]):
        w = np.empty((_SCRATCH, LANES))
        _strains(x, nodes, maps, b, w)
        for lane in range(LANES):
            total = 0.0
            for g in range(8):
                A = pick_point(w, g, _REFERENCE, lane)
                F = pushed(maps, pick_point(w, g, _DERIVATIVES, lane), A)
                J = determinant(F)
                W = law.stored_energy(material, F, cofactor(F), J)
                U = law.volumetric_energy(material, w[_MEAN, lane])
                swap = mean_share * (U - law.volumetric_energy(material, J))
                total += volume(maps, maps.weights[g], A) * (W + swap)
            energies[b, lane] = total


@kernel
def mean_jacobians(x, nodes, maps, Jbar):  # type: ignore[no-untyped-def]
    """``Jbar (B, LANES)``."""
    for b in prange(nodes.shape[0]):
        w = np.empty((_SCRATCH, LANES))
        _strains(x, nodes, maps, b, w)
        for lane in range(LANES):
            Jbar[b, lane] = w[_MEAN, lane]
