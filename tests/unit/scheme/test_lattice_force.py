"""Forces on a box lattice against the energy they belong to, and against rigid motions."""

from __future__ import annotations

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud.lattice.closures import difference
from sphsolid.cloud.lattice.lines import Grid, lines, norm, order_of
from sphsolid.continuum import law
from sphsolid.scheme import lattice_force as lattice

SOLID = sph.NeoHookean.from_young(young_modulus=1.7e7, poisson_ratio=0.45, density=1100.0)
NONE = lattice.RestraintParts(0.0, 0.0)
SPRING = lattice.RestraintParts(0.05 * SOLID.mu, 0.0)
DASHPOT = lattice.RestraintParts(0.0, 0.01 * 1100.0 * 50.0)
SIDES = (1.0, 1.2, 1.5)
#: Long axes, and short ones whose rows are dense or whose restraint is the second difference.
SHAPES = [(4, (9, 10, 12)), (4, (4, 3, 7)), (4, (5, 2, 70))]
PADDING = 64


class Body:
    """A lattice with fields that are rough on the scale of its spacing."""

    def __init__(self, order, counts, workers=2):
        self.order, self.counts = order, counts
        self.dx = [side / (n - 1) for side, n in zip(SIDES, counts, strict=True)]
        self.grid = Grid(*(lines(order, n, dx) for n, dx in zip(counts, self.dx, strict=True)))
        self.V = norm(self.grid)
        rng = np.random.default_rng(3)
        axes = [np.linspace(0.0, side, n) for side, n in zip(SIDES, counts, strict=True)]
        X = np.stack(np.meshgrid(*axes, indexing="ij")).reshape(3, -1)
        self.size = X.shape[1]
        rough = 0.03 * min(self.dx) * rng.normal(size=X.shape)
        self.x = self.field(X + 0.05 * np.sin(2.0 * X[::-1]) + rough)
        self.p = self.field(1100.0 * rng.normal(size=X.shape))
        self.scratch = lattice.make_scratch(self.grid, workers)

    def field(self, values):
        return np.concatenate([values, np.zeros((len(values), PADDING))], axis=1)

    def force(self, parts, x=None, p=None):
        x, p = self.x if x is None else x, self.p if p is None else p
        J, pressure, P, R, f = (np.zeros((rows, x.shape[1])) for rows in (1, 1, 9, 9, 3))
        solid = law.in_kernels(SOLID)
        lattice.dilatation(*self.grid, x, J, self.scratch)
        lattice.smoothed_pressure(*self.grid, solid, J, pressure, self.scratch)
        lattice.stress(*self.grid, solid, parts, x, p, pressure, P, R, self.scratch)
        lattice.force(*self.grid, P, R, f, self.scratch)
        return f[:, : self.size]

    def energy(self, x, parts):
        """Written with whole matrices, independently of the kernels."""
        fields = x[:, : self.size].reshape(3, *self.counts)
        gradient, J_filters, springs = [], [], 0.0
        for axis, (n, dx) in enumerate(zip(self.counts, self.dx, strict=True)):
            h, D = difference(order_of(self.order, n), n).arrays()
            gradient.append(np.moveaxis(np.tensordot(D / dx, fields, (1, axis + 1)), 0, axis + 1))
            D1 = np.diff(np.eye(n), axis=0)
            J_filters.append(np.eye(n) - 0.25 * (D1.T @ D1) / h[:, None])
            q = 4 if n >= 5 else 2
            if n > q:
                e = np.diff(fields, n=q, axis=axis + 1)
                middle = [slice(q // 2, n - q // 2) if d == axis else slice(None) for d in range(3)]
                others = self.V.reshape(self.counts) / np.expand_dims(
                    h, tuple({0, 1, 2} - {axis})
                )
                spread = others[tuple(middle)] * np.sum(e * e, axis=0) ** 2 / dx**4
                springs += 0.25 * parts.stiffness * float(np.sum(spread))
        F = np.stack(gradient, axis=1)
        J = np.linalg.det(np.moveaxis(F, (0, 1), (-2, -1)))
        S = J
        for axis, matrix in enumerate(J_filters):
            S = np.moveaxis(np.tensordot(matrix, S, (1, axis)), 0, axis)
        W = 0.5 * SOLID.mu * J ** (-2.0 / 3.0) * np.sum(F * F, axis=(0, 1))
        W += 0.5 * SOLID.kappa * (S - 1.0) ** 2
        return float(np.sum(self.V * W.ravel())) + springs

    def power(self, f, p=None):
        return float(np.sum(self.V * f * (self.p if p is None else p)[:, : self.size])) / 1100.0


@pytest.fixture(scope="module", params=SHAPES, ids=[str(counts) for _, counts in SHAPES])
def body(request):
    return Body(*request.param)


@pytest.mark.parametrize("parts", [NONE, SPRING], ids=["solid", "restrained"])
def test_the_force_is_that_of_the_energy(body, parts):
    f = body.force(parts)
    direction = body.field(np.random.default_rng(1).normal(size=(3, body.size)))
    step = 1e-3 * min(body.dx)
    energies = [body.energy(body.x + s * step * direction, parts) for s in (-2, -1, 1, 2)]
    slope = np.dot(energies, [1.0, -8.0, 8.0, -1.0]) / (12.0 * step)
    size = np.linalg.norm(body.V * f) * np.linalg.norm(direction)
    assert abs(np.sum(body.V * f * direction[:, : body.size]) + slope) < 1e-8 * size


@pytest.mark.parametrize("parts", [NONE, SPRING, DASHPOT], ids=["solid", "spring", "dashpot"])
def test_neither_resultant_nor_moment(body, parts):
    f = body.force(parts) - (body.force(NONE) if parts is not NONE else 0.0)
    x = body.x[:, : body.size]
    scale = np.sum(body.V * np.linalg.norm(f, axis=0))
    assert np.abs(np.sum(body.V * f, axis=1)).max() < 1e-13 * scale
    assert np.abs(np.sum(body.V * np.cross(x, f, axis=0), axis=1)).max() < 1e-13 * scale


def test_the_dashpot_is_symmetric_takes_energy_and_leaves_rigid_motions_alone(body):
    still = body.force(NONE)
    f = body.force(DASHPOT) - still
    other = body.field(1100.0 * np.random.default_rng(9).normal(size=(3, body.size)))
    g = body.force(DASHPOT, p=other) - still
    assert body.power(f, other) == pytest.approx(body.power(g), rel=1e-10)
    assert body.power(f) < 0.0
    shift = np.array([[3.0], [1.0], [-2.0]])
    spin = np.cross([1.0, -2.0, 0.5], body.x.T).T + shift
    rigid = body.force(DASHPOT, p=body.field(1100.0 * spin[:, : body.size])) - still
    assert np.abs(rigid).max() < 1e-11 * np.abs(f).max()


def test_the_same_bits_however_many_share_the_work():
    one, three = (Body(4, (9, 10, 12), workers).force(SPRING) for workers in (1, 3))
    assert one.tobytes() == three.tobytes()


def test_an_affine_motion_has_a_force_at_the_boundary_alone():
    body = Body(4, (9, 10, 12))
    A = np.array([[1.2, 0.1, 0.0], [-0.1, 0.9, 0.2], [0.0, 0.1, 1.1]])
    axes = [np.linspace(0.0, side, n) for side, n in zip(SIDES, body.counts, strict=True)]
    X = np.stack(np.meshgrid(*axes, indexing="ij")).reshape(3, -1)
    f = body.force(SPRING, x=body.field(A @ X)).reshape(3, *body.counts)
    inside = (slice(None), slice(4, -4), slice(4, -4), slice(4, -4))
    assert np.abs(f[inside]).max() < 1e-11 * np.abs(f).max()
