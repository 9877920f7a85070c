"""Forces on a box lattice against the energy they belong to, and against rigid motions."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

from sphsolid.cloud.lattice.closures import difference
from sphsolid.cloud.lattice.line_filter import filter_matrix
from sphsolid.continuum.law import QUADRATIC, register_law
from sphsolid.continuum.wave_speed import GROWN
from sphsolid.scheme.restraint_term import RestraintParts
from tests.oracles.lattice_body import NONE, SOLID, LatticeBody

SPRING = RestraintParts(0.05 * SOLID.mu, 0.02 * SOLID.mu, 0.0, 0.0, 0.0, math.inf)
DASHPOT = RestraintParts(0.0, 0.0, 0.0, 0.0, 0.01 * 1100.0 * 50.0, math.inf)
ALL = RestraintParts(0.05 * SOLID.mu, 0.02 * SOLID.mu, 0.0, 0.0, 0.01 * 1100.0 * 50.0, math.inf)
BETA = 0.3 * SOLID.mu
#: Long axes, and short ones whose rows are dense or whose restraint is the second difference.
BODIES = {
    "long": LatticeBody(4, (9, 10, 12)),
    "short, no filter": LatticeBody(4, (4, 3, 7), smoothing=0),
    "short": LatticeBody(4, (4, 3, 7), smoothing=2, beta=BETA),
    "beam": LatticeBody(4, (5, 2, 110), smoothing=2, workers=3),
    "beta": LatticeBody(4, (6, 9, 13), smoothing=1, beta=BETA),
    "order two": LatticeBody(2, (5, 6, 9), smoothing=2),
    "order six": LatticeBody(6, (13, 4, 14), smoothing=1),
}


@pytest.fixture(scope="module", params=BODIES)
def body(request):
    return BODIES[request.param]


@pytest.mark.parametrize("parts", [NONE, SPRING], ids=["solid", "restrained"])
def test_the_force_is_that_of_the_energy(body, parts):
    f = body.force(parts)
    direction = np.random.default_rng(1).normal(size=body.x.shape)
    step = 1e-3 * min(body.dx)
    energies = [body.energy(body.x + s * step * direction, parts) for s in (-2, -1, 1, 2)]
    slope = np.dot(energies, [1.0, -8.0, 8.0, -1.0]) / (12.0 * step)
    size = np.linalg.norm(body.V * f) * np.linalg.norm(direction)
    assert abs(np.sum(body.V * f * direction) + slope) < 1e-8 * size


@pytest.mark.parametrize("parts", [NONE, SPRING, DASHPOT], ids=["solid", "spring", "dashpot"])
def test_neither_resultant_nor_moment(body, parts):
    f = body.force(parts) - (body.force(NONE) if parts is not NONE else 0.0)
    scale = np.sum(body.V * np.linalg.norm(f, axis=0))
    moments = np.cross(body.x, f, axis=0)
    assert np.abs(np.sum(body.V * f, axis=(1, 2, 3))).max() < 1e-13 * scale
    assert np.abs(np.sum(body.V * moments, axis=(1, 2, 3))).max() < 1e-13 * scale


def test_the_dashpot_is_symmetric_takes_energy_and_leaves_rigid_motions_alone(body):
    still = body.force(NONE)
    f = body.force(DASHPOT) - still
    other = 1100.0 * np.random.default_rng(9).normal(size=body.p.shape)
    g = body.force(DASHPOT, p=other) - still
    assert body.power(f, other) == pytest.approx(body.power(g), rel=1e-10)
    assert body.power(f) < 0.0
    shift = np.array([3.0, 1.0, -2.0]).reshape(3, 1, 1, 1)
    spin = np.cross([1.0, -2.0, 0.5], np.moveaxis(body.x, 0, -1))
    rigid = body.force(DASHPOT, p=1100.0 * (np.moveaxis(spin, -1, 0) + shift)) - still
    assert np.abs(rigid).max() < 1e-11 * np.abs(f).max()


def test_parts_add_up(body):
    still = body.force(NONE)
    apart = body.force(SPRING) + body.force(DASHPOT) - still
    assert np.abs(body.force(ALL) - apart).max() < 1e-12 * np.abs(apart).max()


def test_the_smallest_stretch_is_that_of_the_gradient(body):
    """Over the growth of the volume where that is more than ``GROWN``."""
    body.force(NONE)
    F = np.moveaxis(body.gradient(body.x), (0, 1), (-2, -1))
    least = np.linalg.svd(F, compute_uv=False)[..., -1]
    grown = np.maximum(1.0, np.linalg.det(F) / GROWN)
    assert np.any(grown > 1.0)
    assert np.abs(body.stretch - least / grown).max() < 1e-8


def test_what_is_no_state_is_marked():
    body = BODIES["long"]
    mirrored, broken = body.x * np.array([-1.0, 1.0, 1.0]).reshape(3, 1, 1, 1), body.x.copy()
    body.force(NONE, x=mirrored)
    assert np.all(body.stretch == -1.0)
    broken[1, 4, 5, 6] = np.nan
    body.force(NONE, x=broken)
    assert body.stretch[5, 5, 6] == -2.0
    assert body.stretch[0, 0, 0] > 0.0


@pytest.mark.parametrize("smoothing", [0, 1, 2])
def test_the_same_bits_however_many_share_the_work(smoothing):
    counts, beta = (9, 10, 12), BETA if smoothing else 0.0
    one, three = (
        LatticeBody(4, counts, smoothing=smoothing, beta=beta, workers=workers).force(ALL)
        for workers in (1, 3)
    )
    assert one.tobytes() == three.tobytes()


def test_an_affine_motion_has_a_force_at_the_boundary_alone():
    body = BODIES["long"]
    A = np.array([[1.2, 0.1, 0.0], [-0.1, 0.9, 0.2], [0.0, 0.1, 1.1]])
    f = body.force(SPRING, x=np.tensordot(A, body.X, 1))
    inside = (slice(None), slice(4, -4), slice(4, -4), slice(4, -4))
    assert np.abs(f[inside]).max() < 1e-11 * np.abs(f).max()


@pytest.mark.parametrize("smoothing", [0, 1, 2])
def test_at_rest_there_is_no_pressure_but_round_off(smoothing):
    body = LatticeBody(4, (9, 10, 12), smoothing=smoothing, beta=BETA if smoothing else 0.0)
    f = body.force(ALL, x=body.X, p=0.0 * body.p)
    assert np.abs(f).max() < 1e-12 * SOLID.kappa / min(body.dx)


@pytest.mark.parametrize("n", [2, 3, 4, 9, 12, 24])
@pytest.mark.parametrize("q", [1, 2])
def test_a_filter_is_symmetric_keeps_polynomials_and_takes_the_roughest(q, n):
    h, _ = difference(4 if n >= 4 else 2, n).arrays()
    S = filter_matrix(h, q)
    HS = h[:, None] * S
    k = np.arange(n)
    assert np.abs(HS - HS.T).max() < 1e-15
    # Lines with ends of their own keep quadratic functions, beside the ends too.
    kept = 2 if q == 2 and n >= 8 else q - 1
    for degree in range(kept + 1):
        f = (k / n) ** degree
        assert np.abs(S @ f - f).max() < 1e-13
    values = np.linalg.eigvals(S)
    assert np.abs(values.imag).max() < 1e-12
    assert values.real.max() < 1.0 + 1e-12
    if n == 24:
        rough = (-1.0) ** k
        assert np.abs((S @ rough)[7:-7]).max() < 1e-15


class Fibre(NamedTuple):
    """``W = (mu/2) F:F + (stiff/2) |F E_1|^2 + (kappa/2) (J - 1)^2``: stiff along one direction."""

    mu: float
    kappa: float
    density: float
    stiff: float
    depends_on_H: bool


def _energy(m: Any, F: Any, H: Any, J: Any) -> Any:
    along = F[0] * F[0] + F[3] * F[3] + F[6] * F[6]
    across = F[1] * F[1] + F[4] * F[4] + F[7] * F[7] + F[2] * F[2] + F[5] * F[5] + F[8] * F[8]
    volume = 0.5 * m.kappa * (J - 1.0) * (J - 1.0)
    return 0.5 * (m.mu + m.stiff) * along + 0.5 * m.mu * across + volume


def _conjugate(m: Any, F: Any, H: Any, J: Any) -> Any:
    a, b = m.mu + m.stiff, m.mu
    S = (a * F[0], b * F[1], b * F[2], a * F[3], b * F[4], b * F[5], a * F[6], b * F[7], b * F[8])
    return S, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), m.kappa * (J - 1.0)


def _piola(m: Any, F: Any, H: Any, J: Any) -> Any:
    a, b, p = m.mu + m.stiff, m.mu, m.kappa * (J - 1.0)
    return (
        a * F[0] + p * H[0], b * F[1] + p * H[1], b * F[2] + p * H[2],
        a * F[3] + p * H[3], b * F[4] + p * H[4], b * F[5] + p * H[5],
        a * F[6] + p * H[6], b * F[7] + p * H[7], b * F[8] + p * H[8],
    )  # fmt: skip


def _hessian(m: Any, F: Any, H: Any, J: Any, dF: Any, dH: Any, dJ: Any) -> Any:
    S, zero, _ = _conjugate(m, dF, dH, J)
    return S, zero, m.kappa * dJ


register_law(
    Fibre,
    energy=_energy,
    conjugate_stresses=_conjugate,
    first_piola=_piola,
    hessian_action=_hessian,
    volumetric=QUADRATIC,
)


def test_whatever_axis_is_the_slow_one():
    solid = Fibre(SOLID.mu, SOLID.kappa, 1100.0, 5.0 * SOLID.mu, False)
    first, *others = (LatticeBody(4, (8, 9, 10), slow=slow, solid=solid) for slow in range(3))
    f = first.force(ALL)
    for other in others:
        assert np.abs(other.force(ALL) - f).max() < 1e-11 * np.abs(f).max()
        assert np.abs(other.stretch - first.stretch).max() < 1e-9
