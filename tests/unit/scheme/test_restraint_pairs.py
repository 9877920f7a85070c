"""The sums over near pairs are those of their formula, in any layout and by any threads."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.compiled import set_threads, threads
from sphsolid.fields import components, tensor_field, vector_field
from sphsolid.geometry import TetBox
from sphsolid.geometry.edges import edges_of
from sphsolid.scenes import Box
from sphsolid.scheme import near_pairs
from sphsolid.scheme.restraint_pairs import FOOT, energies, make_scratch, restrain
from sphsolid.scheme.restraint_term import Measured, RestraintParts
from sphsolid.scheme.viscous_share import viscous_shares

PARTS = RestraintParts(
    quartic=40.0, elastic=0.02, pressed=1.1, sheared=0.4, viscosity=0.3, most=1.35
)
BODIES = {"hexahedra": Box(jitter=0.4), "tetrahedra": TetBox()}


class Motion:
    """Some particles in some motion; ``restrained`` is the force and the stress it has."""

    def __init__(self, body, parts=PARTS, *, damped=True, particle_major=True, spacing=0.15):
        mesh = body.mesh(spacing)
        self.X, self.edges, self.parts = mesh.vertices, edges_of(mesh), parts
        n, rng = len(self.X), np.random.default_rng(3)
        self.V = spacing**3 * (1.0 + rng.random(n))
        self.x = self.X + 0.05 * spacing * rng.normal(size=(n, 3))
        self.v, self.L = rng.normal(size=(n, 3)), rng.normal(size=(n, 3, 3)) / spacing
        self.F = np.eye(3) + 0.05 * rng.normal(size=(n, 3, 3))
        self.P = rng.normal(size=(n, 3, 3))
        self.damped = damped

        def tensor(values):
            field = tensor_field(len(values), particle_major=particle_major)
            field[:] = values
            return field

        def vector(values):
            field = vector_field(n)
            field[:] = values
            return components(field)

        self.tensor = tensor
        L = tensor(self.L if damped else self.L[:0])
        self.measured = Measured(
            vector(self.x), vector(self.v), components(tensor(self.F)), components(L)
        )

    def near(self):
        return near_pairs.near_pairs(self.edges, self.X, self.V)

    def restrained(self):
        near, direct, P = self.near(), vector_field(len(self.X)), self.tensor(self.P)
        restrain(
            near, self.parts, self.measured, components(direct), components(P), make_scratch(near)
        )
        return direct, P

    def by_definition(self):
        """The same, and the energies, from all pairs at once."""
        parts, edges = self.parts, self.edges
        a, b = np.concatenate([edges.a, edges.b]), np.concatenate([edges.b, edges.a])
        V_ab = np.concatenate([edges.volume, edges.volume])
        X, F = self.X[b] - self.X[a], 0.5 * (self.F[a] + self.F[b])
        e = self.x[b] - self.x[a] - np.einsum("nij,nj->ni", F, X)
        length = np.linalg.norm(X, axis=1)
        r2 = np.sum(e**2, axis=1) / length**2
        g, dg = pressing(parts, F)
        t = (V_ab / length**2 * (parts.quartic * r2 + parts.elastic + g))[:, None] * e
        stress = -0.5 * (V_ab * r2)[:, None, None] * dg
        taken = np.zeros(len(a))
        if self.damped:
            L = 0.5 * (self.L[a] + self.L[b])
            u = self.v[b] - self.v[a] - np.einsum("nij,nj->ni", L, X)
            s = np.einsum("nji,nj->ni", F, u) + np.einsum("nji,nj->ni", L, e)
            share = viscous_shares(F, parts.most)
            assert np.any(share < 1.0)
            assert np.any(share == 1.0)
            c = V_ab / length * parts.viscosity * share
            w = c[:, None] * s
            t += np.einsum("nij,nj->ni", F, w)
            stress -= np.einsum("ni,nj->nij", e, w)
            taken = -c * np.sum(s**2, axis=1)
        stress += np.einsum("ni,nj->nij", t, X)
        direct, P = np.zeros_like(self.X), np.zeros_like(self.P)
        np.add.at(direct, a, t / self.V[a, None])
        np.add.at(P, a, -0.5 * stress / self.V[a, None, None])
        stored = V_ab * (0.25 * parts.quartic * r2 + 0.5 * (parts.elastic + g)) * r2
        return direct, P, 0.5 * np.sum(stored), 0.5 * np.sum(taken)


def pressing(parts, F):
    """``g`` and its derivative by ``F (n, 3, 3)``."""
    if parts.pressed == 0.0:
        return np.zeros(len(F)), np.zeros_like(F)
    J, square = np.linalg.det(F), np.sum(F**2, axis=(1, 2))
    H = J[:, None, None] * np.swapaxes(np.linalg.inv(F), 1, 2)
    pressure, dp = ramp(1.0 - J, FOOT * parts.sheared / parts.pressed)
    shear, ds = ramp(square / 3.0 - J, FOOT)
    slope = -parts.pressed * dp[:, None, None] * H
    slope += parts.sheared * ds[:, None, None] * (2.0 / 3.0 * F - H)
    return parts.pressed * pressure + parts.sheared * shear, slope


def ramp(x, width):
    inside = np.clip(x, 0.0, width)
    return np.where(x < width, 0.5 * inside**2 / width, x - 0.5 * width), inside / width


def close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("particle_major", [False, True])
@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("parts", [PARTS, PARTS._replace(pressed=0.0, sheared=0.0)])
def test_it_is_the_sum_of_its_formula(body, particle_major, damped, parts):
    motion = Motion(BODIES[body], parts, damped=damped, particle_major=particle_major)
    direct, P = motion.restrained()
    force, stress, stored, taken = motion.by_definition()
    close(direct, force)
    close(P - motion.P, stress)
    out, given = np.zeros((len(motion.X), 2)), (motion.measured.v, motion.measured.L)
    energies(motion.near(), parts, motion.measured, given, out)
    assert out[:, 0].sum() == pytest.approx(stored, rel=1e-12)
    assert out[:, 1].sum() == pytest.approx(taken, rel=1e-12)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("damped", [False, True])
def test_neither_threads_nor_tiles_change_a_bit(body, damped, monkeypatch):
    motion = Motion(BODIES[body], damped=damped, spacing=0.1)
    direct, P = motion.restrained()
    assert np.abs(np.sum(motion.V[:, None] * direct, axis=0)).max() < 1e-13 * np.sum(
        motion.V[:, None] * np.abs(direct)
    )
    before = threads()
    try:
        for count in (1, 2):
            for particles in (7, 100, 10**6):
                set_threads(count)
                monkeypatch.setattr(near_pairs, "PARTICLES", particles)
                other, stress = motion.restrained()
                np.testing.assert_array_equal(other, direct)
                np.testing.assert_array_equal(stress, P)
    finally:
        set_threads(before)
