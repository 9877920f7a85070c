"""Compiled element loops of the Q1-P0 hexahedron; formulas in ``b_bar_hex``.

``gradients`` and ``weights`` hold one row for all elements, or one per element.
"""

from __future__ import annotations

import numpy as np

from sphsolid.compiled import kernel, prange, register_jitable
from sphsolid.continuum import law
from sphsolid.continuum.tensor import axpy, cofactor, contract, determinant, load, scale, store
from sphsolid.continuum.wave_speed import smallest_stretch


@register_jitable
def _corner_positions(x, cells, e, corners):  # type: ignore[no-untyped-def]
    """Copy the positions of element ``e`` next to each other: eight points read them."""
    for a in range(8):
        node = cells[e, a]
        corners[a, 0] = x[node, 0]
        corners[a, 1] = x[node, 1]
        corners[a, 2] = x[node, 2]


@register_jitable
def _deformation_gradient(corners, gradient):  # type: ignore[no-untyped-def]
    """``F = sum_a x_a (x) dN_a/dX`` from ``corners (8, 3)`` and ``gradient (8, 3)``."""
    F0 = F1 = F2 = F3 = F4 = F5 = F6 = F7 = F8 = 0.0
    for a in range(8):
        g0, g1, g2 = gradient[a, 0], gradient[a, 1], gradient[a, 2]
        x0, x1, x2 = corners[a, 0], corners[a, 1], corners[a, 2]
        F0 += x0 * g0
        F1 += x0 * g1
        F2 += x0 * g2
        F3 += x1 * g0
        F4 += x1 * g1
        F5 += x1 * g2
        F6 += x2 * g0
        F7 += x2 * g1
        F8 += x2 * g2
    return (F0, F1, F2, F3, F4, F5, F6, F7, F8)


@register_jitable
def _gauss_gradients(corners, gradients, weights, F):  # type: ignore[no-untyped-def]
    """Fill ``F (8, 3, 3)`` and return the mean Jacobian ``Jbar``."""
    deformed = 0.0
    undeformed = 0.0
    for g in range(8):
        F_g = _deformation_gradient(corners, gradients[g])
        store(F_g, F, g)
        deformed += weights[g] * determinant(F_g)
        undeformed += weights[g]
    return deformed / undeformed


@register_jitable
def _forces(material, gradients, weights, Jbar, F, force):  # type: ignore[no-untyped-def]
    """Corner forces ``(8, 3)``; returns the smallest ``J`` and the shrinkage of ``length``."""
    force[:] = 0.0
    least = np.inf
    thinnest = np.inf
    thin = 0
    for g in range(8):
        F_g = load(F, g)
        H = cofactor(F_g)
        J = determinant(F_g)
        P = axpy(material.kappa * (Jbar - J), H, law.first_piola(material, F_g, H, J))
        P = scale(weights[g], P)
        for a in range(8):
            g0, g1, g2 = gradients[g, a, 0], gradients[g, a, 1], gradients[g, a, 2]
            force[a, 0] += P[0] * g0 + P[1] * g1 + P[2] * g2
            force[a, 1] += P[3] * g0 + P[4] * g1 + P[5] * g2
            force[a, 2] += P[6] * g0 + P[7] * g1 + P[8] * g2
        # nan must stay: a plain minimum would forget it.
        if least > J or J != J:
            least = J
        # J/|cof F| is within sqrt(3) of the smallest stretch and nearly free; the closed form
        # costs as much as a stress, so only the Gauss point that looks thinnest gets it.
        thickness = J * J / contract(H, H)
        if thickness < thinnest:
            thinnest = thickness
            thin = g
    # The volumetric part of the acoustic tensor is kappa |cof F N|^2 <= kappa (J / lambda)^2:
    # a body pulled to J > 1 carries faster waves than lambda alone says.
    return least, smallest_stretch(load(F, thin)) / max(1.0, Jbar)


@kernel
def element_forces(  # type: ignore[no-untyped-def]
    material, x, cells, gradients, weights, smallest_J, shrinkage, force
):
    """Corner forces ``force (E, 8, 3)`` [N]; ``smallest_J (E,)``; ``shrinkage (E,)``.

    ``shrinkage`` is ``lambda / max(1, Jbar)``, ``lambda`` the smallest principal stretch.
    """
    for e in prange(cells.shape[0]):
        r = np.int64(e) if weights.shape[0] > 1 else 0
        corners = np.empty((8, 3))
        F = np.empty((8, 3, 3))
        _corner_positions(x, cells, e, corners)
        Jbar = _gauss_gradients(corners, gradients[r], weights[r], F)
        least, shrunk = _forces(material, gradients[r], weights[r], Jbar, F, force[e])
        smallest_J[e] = least
        shrinkage[e] = shrunk


@kernel
def element_energies(  # type: ignore[no-untyped-def]
    material, x, cells, gradients, weights, energies
):
    """``Pi_e (E,)`` [J]."""
    for e in prange(cells.shape[0]):
        r = np.int64(e) if weights.shape[0] > 1 else 0
        corners = np.empty((8, 3))
        F = np.empty((8, 3, 3))
        _corner_positions(x, cells, e, corners)
        Jbar = _gauss_gradients(corners, gradients[r], weights[r], F)
        total = 0.0
        for g in range(8):
            F_g = load(F, g)
            J = determinant(F_g)
            W = law.stored_energy(material, F_g, cofactor(F_g), J)
            # U(Jbar) - U(J) as a product: no digits are lost where both are close to one.
            swap = 0.5 * material.kappa * (Jbar - J) * (Jbar + J - 2.0)
            total += weights[r, g] * (W + swap)
        energies[e] = total


@kernel
def centroid_stresses(  # type: ignore[no-untyped-def]
    material, x, cells, gradients, weights, centroid_gradients, F_out, J_out, P_out
):
    """``F (E, 3, 3)``, ``Jbar (E,)`` and ``P (E, 3, 3)`` [Pa] at the centroids."""
    for e in prange(cells.shape[0]):
        r = np.int64(e) if weights.shape[0] > 1 else 0
        corners = np.empty((8, 3))
        scratch = np.empty((8, 3, 3))
        _corner_positions(x, cells, e, corners)
        Jbar = _gauss_gradients(corners, gradients[r], weights[r], scratch)
        F = _deformation_gradient(corners, centroid_gradients[r])
        H = cofactor(F)
        J = determinant(F)
        P = axpy(material.kappa * (Jbar - J), H, law.first_piola(material, F, H, J))
        store(F, F_out, e)
        store(P, P_out, e)
        J_out[e] = Jbar
