"""Materials and deformations that the checks of this folder share."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.continuum import MooneyRivlin, NeoHookean, SaintVenantKirchhoff

STEEL_LIKE_RUBBER = {"young_modulus": 17.0e6, "poisson_ratio": 0.3, "density": 1100.0}
RUBBER = {"young_modulus": 1.0e6, "poisson_ratio": 0.499, "density": 1000.0}


def _polyconvex():
    for name, values in (("0.3", STEEL_LIKE_RUBBER), ("0.499", RUBBER)):
        yield pytest.param(NeoHookean.from_young(**values), id=f"neo-Hookean nu={name}")
        for share in (0.5, 1.0):
            material = MooneyRivlin.from_young(**values, cofactor_share=share)
            yield pytest.param(material, id=f"Mooney-Rivlin share={share:g} nu={name}")


def _materials():
    yield from _polyconvex()
    for name, values in (("0.3", STEEL_LIKE_RUBBER), ("0.499", RUBBER)):
        linear = SaintVenantKirchhoff.from_young(**values)
        yield pytest.param(linear, id=f"Saint Venant-Kirchhoff nu={name}")


@pytest.fixture(params=_materials())
def material(request):
    """Every law, compressible and nearly incompressible."""
    return request.param


@pytest.fixture(params=_polyconvex())
def polyconvex(request):
    """The laws of [Lee2017]."""
    return request.param


@pytest.fixture
def deformations():
    """Random ``F (50, 3, 3)`` with ``J > 0.2``, stretches from about 0.3 to 2."""
    rng = np.random.default_rng(7)
    F = np.eye(3) + 0.45 * rng.uniform(-1.0, 1.0, (400, 3, 3))
    return F[np.linalg.det(F) > 0.2][:50]


@pytest.fixture
def rotations():
    """Random proper rotations ``(50, 3, 3)``."""
    Q, R = np.linalg.qr(np.random.default_rng(8).normal(size=(50, 3, 3)))
    Q = Q * np.sign(np.einsum("nii->ni", R))[:, None, :]
    return Q * np.linalg.det(Q)[:, None, None]
