"""Compiled element loops of the Q2-Q1 hexahedron; formulas in ``taylor_hood_hex``.

``nodes (B, 27, LANES)`` and ``corners (B, 8, LANES)`` of blocks of elements, ``maps`` their
reference maps.  Corner fields are numbered ``i + 2 j + 4 k``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fem_reference.hex_maps import are_distorted, pulled, pushed, volume
from fem_reference.lanes import LANES, choose, fill, gather_nodes, pick, put
from fem_reference.triquadratic import (
    ROWS,
    SCRATCH,
    corner_moments,
    derivatives,
    interpolate_corners,
    node_sums,
)
from sphsolid.compiled import inlined, kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import axpy, cofactor, contract, determinant
from sphsolid.continuum.wave_speed import smallest_stretch

Array = NDArray[Any]

# Rows of the scratch array.  Derivatives come first and the rest stands clear of them, so that
# the tests for overlap, which LLVM puts before a loop whose rows are not known, always pass.
_POINTS = 0
_NODES = _POINTS + 3 * ROWS
_OWN = _NODES + 81
_THETA = _OWN + SCRATCH
_CORNERS = _THETA + 27
_LEAST = _CORNERS + 8
_THICKNESS = _LEAST + 1
_LARGEST = _LEAST + 2
_THINNEST = _LEAST + 3
_REFERENCE = _THINNEST + 9
_BRICK_SCRATCH = _REFERENCE
_SCRATCH = _REFERENCE + 3 * ROWS


class Fields(NamedTuple):
    """What forces are made of: positions of the nodes, dilatation and pressure at the corners."""

    x: Array
    theta: Array
    pressure: Array


class Forces(NamedTuple):
    """What :func:`element_forces` writes."""

    smallest_J: Array
    shrinkage: Array
    force: Array


@inlined
def _at(w, first, g, lane):  # type: ignore[no-untyped-def]
    """``dx/dxi`` at point ``g``."""
    r = first + g
    return (
        w[r, lane], w[r + 27, lane], w[r + 54, lane],
        w[r + 81, lane], w[r + 108, lane], w[r + 135, lane],
        w[r + 162, lane], w[r + 189, lane], w[r + 216, lane],
    )  # fmt: skip


@inlined
def _replace(A, w, first, g, lane):  # type: ignore[no-untyped-def]
    """Write ``A`` where :func:`_at` reads."""
    r = first + g
    w[r, lane] = A[0]
    w[r + 27, lane] = A[1]
    w[r + 54, lane] = A[2]
    w[r + 81, lane] = A[3]
    w[r + 108, lane] = A[4]
    w[r + 135, lane] = A[5]
    w[r + 162, lane] = A[6]
    w[r + 189, lane] = A[7]
    w[r + 216, lane] = A[8]


@inlined
def _reference(nodes, maps, b, w):  # type: ignore[no-untyped-def]
    """Fill the derivatives of the reference map of a block, where its elements are no bricks."""
    if are_distorted(maps):
        gather_nodes(maps.X, nodes[b], w[_NODES:])
        derivatives(maps.along, w, _NODES, _REFERENCE, _OWN)


@inlined
def _strains(x, nodes, maps, b, w):  # type: ignore[no-untyped-def]
    """Fill the derivatives of a block at the Gauss points."""
    _reference(nodes, maps, b, w)
    gather_nodes(x, nodes[b], w[_NODES:])
    derivatives(maps.along, w, _NODES, _POINTS, _OWN)


@inlined
def _at_points(field, corners, b, w):  # type: ignore[no-untyped-def]
    """A field ``(Nc,)`` of the corners at the Gauss points of a block."""
    for c in range(8):
        for lane in range(LANES):
            w[_CORNERS + c, lane] = field[corners[b, c, lane]]
    interpolate_corners(w, _CORNERS, _THETA, _OWN)


@inlined
def _expansion(material, theta, corners, b, w):  # type: ignore[no-untyped-def]
    """The largest ``s theta`` of a corner and 1; ``s`` of ``law.stiffening``."""
    fill(w, _LARGEST, 1, 1.0)
    for c in range(8):
        for lane in range(LANES):
            value = 1.0 + theta[corners[b, c, lane]]
            expansion = value * law.stiffening(material, value)
            w[_LARGEST, lane] = max(w[_LARGEST, lane], expansion)


@kernel
def dilatation_moments(x, nodes, maps, excess):  # type: ignore[no-untyped-def]
    """``integral N_a (J - 1) dV (B, 8, LANES)`` [m^3] of the corners' linear shapes ``N_a``."""
    for b in prange(nodes.shape[0]):
        w = np.empty((_SCRATCH if are_distorted(maps) else _BRICK_SCRATCH, LANES))
        _strains(x, nodes, maps, b, w)
        for g in range(27):
            share = maps.weights[g]
            for lane in range(LANES):
                A = _at(w, _REFERENCE, g, lane)
                J = determinant(pushed(maps, _at(w, _POINTS, g, lane), A))
                w[_THETA + g, lane] = volume(maps, share, A) * (J - 1.0)
        corner_moments(w, _THETA, _CORNERS, _OWN)
        for c in range(8):
            for lane in range(LANES):
                excess[b, c, lane] = w[_CORNERS + c, lane]


@kernel
def element_forces(material, fields, nodes, corners, maps, found):  # type: ignore[no-untyped-def]
    """Node forces ``force (B, 81, LANES)`` [N], row ``3 n + i``.

    ``theta - 1 (Nc,)`` and ``pressure (Nc,)`` [Pa] at the corners.  ``smallest_J (B, LANES)``;
    ``shrinkage (B, LANES)`` is ``lambda / max(1, s theta)``, ``lambda`` the smallest principal
    stretch and ``s = sqrt(max(1, U''(theta) / kappa))``.
    """
    x, theta, pressure = fields
    smallest_J, shrinkage, force = found
    for b in prange(nodes.shape[0]):
        w = np.empty((_SCRATCH if are_distorted(maps) else _BRICK_SCRATCH, LANES))
        _strains(x, nodes, maps, b, w)
        _at_points(pressure, corners, b, w)
        _expansion(material, theta, corners, b, w)
        fill(w, _LEAST, 2, np.inf)
        for g in range(27):
            share = maps.weights[g]
            for lane in range(LANES):
                A = _at(w, _REFERENCE, g, lane)
                F = pushed(maps, _at(w, _POINTS, g, lane), A)
                H = cofactor(F)
                J = determinant(F)
                excess = w[_THETA + g, lane] - law.volumetric_pressure(material, J)
                P = axpy(excess, H, law.first_piola(material, F, H, J))
                _replace(pulled(maps, share, P, A), w, _POINTS, g, lane)
                # nan must stay: a plain minimum would forget it.
                least = w[_LEAST, lane]
                w[_LEAST, lane] = J if (least > J or J != J) else least
                # Only the point that looks thinnest gets the closed form, as in ``b_bar_kernels``.
                thickness = J * J / contract(H, H)
                before = w[_THICKNESS, lane]
                thinner = thickness < before
                w[_THICKNESS, lane] = thickness if thinner else before
                put(choose(thinner, F, pick(w, _THINNEST, lane)), w, _THINNEST, lane)
        node_sums(maps.along, w, _POINTS, _NODES, _OWN)
        for row in range(81):
            for lane in range(LANES):
                force[b, row, lane] = w[_NODES + row, lane]
        for lane in range(LANES):
            smallest_J[b, lane] = w[_LEAST, lane]
            stretch = smallest_stretch(pick(w, _THINNEST, lane))
            shrinkage[b, lane] = stretch / w[_LARGEST, lane]


@kernel
def isochoric_energies(material, x, nodes, maps, energies):  # type: ignore[no-untyped-def]
    """``sum_g w_g [W - U(J)] (B, LANES)`` [J]."""
    for b in prange(nodes.shape[0]):
        w = np.empty((_SCRATCH if are_distorted(maps) else _BRICK_SCRATCH, LANES))
        _strains(x, nodes, maps, b, w)
        for lane in range(LANES):
            total = 0.0
            for g in range(27):
                A = _at(w, _REFERENCE, g, lane)
                F = pushed(maps, _at(w, _POINTS, g, lane), A)
                J = determinant(F)
                W = law.stored_energy(material, F, cofactor(F), J)
                swap = law.volumetric_energy(material, J)
                total += volume(maps, maps.weights[g], A) * (W - swap)
            energies[b, lane] = total


@kernel
def remainder_moments(material, theta, nodes, corners, maps, moments):  # type: ignore[no-untyped-def]
    """``integral N_a R'(theta) dV (B, 8, LANES)`` [N m], ``R' = U'(theta) - kappa (theta - 1)``."""
    kappa = law.volumetric_stiffness(material, 1.0)
    for b in prange(nodes.shape[0]):
        w = np.empty((_SCRATCH if are_distorted(maps) else _BRICK_SCRATCH, LANES))
        _reference(nodes, maps, b, w)
        _at_points(theta, corners, b, w)
        for g in range(27):
            share = maps.weights[g]
            for lane in range(LANES):
                A = _at(w, _REFERENCE, g, lane)
                e = w[_THETA + g, lane]
                beyond = law.volumetric_pressure(material, 1.0 + e) - kappa * e
                w[_THETA + g, lane] = volume(maps, share, A) * beyond
        corner_moments(w, _THETA, _CORNERS, _OWN)
        for c in range(8):
            for lane in range(LANES):
                moments[b, c, lane] = w[_CORNERS + c, lane]


@kernel
def remainder_energies(material, theta, nodes, corners, maps, energies):  # type: ignore[no-untyped-def]
    """``integral R(theta) dV (B, LANES)`` [J], ``R = U(theta) - kappa/2 (theta - 1)^2``."""
    kappa = law.volumetric_stiffness(material, 1.0)
    for b in prange(nodes.shape[0]):
        w = np.empty((_SCRATCH if are_distorted(maps) else _BRICK_SCRATCH, LANES))
        _reference(nodes, maps, b, w)
        _at_points(theta, corners, b, w)
        for lane in range(LANES):
            total = 0.0
            for g in range(27):
                A = _at(w, _REFERENCE, g, lane)
                e = w[_THETA + g, lane]
                beyond = law.volumetric_energy(material, 1.0 + e) - 0.5 * kappa * e * e
                total += volume(maps, maps.weights[g], A) * beyond
            energies[b, lane] = total
