"""The standing wave: it solves linear elasticity, and the manufactured loads make it solve the
nonlinear equations, checked with a sympy derivation that shares nothing with the package.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import sympy as sp

from sphsolid.continuum.moduli import first_lame
from sphsolid.errors import InputError
from sphsolid.scenes import NoBodyForce, amplitude_of_gradient, swinging_cube
from sphsolid.scenes.constraint import essential_parts
from sphsolid.scenes.swinging_cube import COEFFICIENTS

FAMILIES = list(COEFFICIENTS)
RNG = np.random.default_rng(21)
POINTS = RNG.uniform(0.05, 0.95, (6, 3))


@pytest.fixture(params=FAMILIES)
def family(request):
    return request.param


def test_published_frequencies(family):
    wave = swinging_cube(family=family).exact
    published = {"A=B=C": (392.42, 16.01e-3), "A+B+C=0": (209.76, 29.95e-3)}[family]
    assert wave.frequency == pytest.approx(published[0], rel=1e-4)
    assert wave.period == pytest.approx(published[1], rel=5e-4)
    assert swinging_cube(family=family).end_time == wave.period


def central(function, X, axis, step=1e-4):
    shift = np.zeros(3)
    shift[axis] = step
    return (function(X + shift) - function(X - shift)) / (2.0 * step)


@pytest.mark.parametrize("phase", [0.13, 0.4])
def test_wave_solves_linear_elasticity(family, phase):
    scene = swinging_cube(family=family)
    wave, t = scene.exact, phase * scene.exact.period
    divergence = sum(
        central(lambda X: wave.first_piola(X, t), POINTS, axis)[:, :, axis] for axis in range(3)
    )
    acceleration = -(wave.frequency**2) * wave.displacement(POINTS, t)
    inertia = scene.material.density * acceleration
    np.testing.assert_allclose(inertia, divergence, atol=1e-6 * np.max(np.abs(inertia)))


def test_a_wrong_frequency_is_noticed():
    """The check above, fed with the frequency of the other family, must not pass."""
    scene, other = (swinging_cube(family=name) for name in FAMILIES)
    wave = scene.exact
    divergence = sum(
        central(lambda X: wave.first_piola(X, 0.0), POINTS, axis)[:, :, axis] for axis in range(3)
    )
    inertia = -scene.material.density * other.exact.frequency**2 * wave.displacement(POINTS, 0.0)
    assert np.max(np.abs(inertia - divergence)) > 0.1 * np.max(np.abs(inertia))


@pytest.mark.parametrize("manufactured", [False, True])
def test_fields_are_derivatives_of_the_displacement(family, manufactured):
    wave = swinging_cube(family=family, amplitude=0.05, manufactured=manufactured).exact
    t, step = 0.3 * wave.period, 1e-6 * wave.period
    rate = (wave.displacement(POINTS, t + step) - wave.displacement(POINTS, t - step)) / (2 * step)
    np.testing.assert_allclose(wave.velocity(POINTS, t), rate, rtol=1e-7)
    gradient = np.stack(
        [central(lambda X: wave.displacement(X, t), POINTS, axis) for axis in range(3)], axis=2
    )
    np.testing.assert_allclose(wave.displacement_gradient(POINTS, t), gradient, atol=1e-8)
    F = wave.deformation_gradient(POINTS, t)
    np.testing.assert_allclose(F, np.eye(3) + gradient, atol=1e-8)


def test_linear_stress_is_hooke(family):
    scene = swinging_cube(family=family)
    wave, m, t = scene.exact, scene.material, 0.1 * scene.exact.period
    G = wave.displacement_gradient(POINTS, t)
    lam = first_lame(m.mu, m.kappa)
    hooke = lam * np.trace(G, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    hooke = hooke + m.mu * (G + np.swapaxes(G, 1, 2))
    np.testing.assert_allclose(wave.first_piola(POINTS, t), hooke, atol=1e-12 * np.max(abs(hooke)))


def test_nonlinear_stress_tends_to_the_linear_one(family):
    ratios = []
    for amplitude in (1e-3, 1e-4):
        linear = swinging_cube(family=family, amplitude=amplitude).exact
        full = swinging_cube(family=family, amplitude=amplitude, manufactured=True).exact
        difference = full.first_piola(POINTS, 0.0) - linear.first_piola(POINTS, 0.0)
        ratios.append(np.max(abs(difference)) / np.max(abs(linear.first_piola(POINTS, 0.0))))
    assert ratios[0] / ratios[1] == pytest.approx(10.0, rel=0.05)


@cache
def derived(family):
    """``f0`` and ``P`` from the energy, by symbols only: ``W = mu/2 det(F)^(-2/3) F:F + ...``."""
    X = sp.symbols("X0:3", real=True)
    U, w, mu, kappa, rho = sp.symbols("U w mu kappa rho", real=True)
    s, c = ([f(sp.pi * x / 2) for x in X] for f in (sp.sin, sp.cos))
    u = [
        U * coefficient * sp.prod([s[d] if d == i else c[d] for d in range(3)])
        for i, coefficient in enumerate(COEFFICIENTS[family])
    ]
    F = sp.Matrix(3, 3, sp.symbols("F0:9", real=True))
    J = F.det()
    W = mu / 2 * J ** sp.Rational(-2, 3) * sum(e**2 for e in F) + kappa / 2 * (J - 1) ** 2
    P = [[sp.diff(W, F[i, k]) for k in range(3)] for i in range(3)]
    gradient = [[(1 if i == k else 0) + sp.diff(u[i], X[k]) for k in range(3)] for i in range(3)]
    # DIV P by the chain rule: the second derivatives of W times those of u.
    divergence = [
        sum(
            sp.diff(P[i][k], F[j, m]) * sp.diff(u[j], X[m], X[k])
            for k in range(3)
            for j in range(3)
            for m in range(3)
        )
        for i in range(3)
    ]
    force = [-rho * w**2 * u[i] - divergence[i] for i in range(3)]
    known = (*X, U, w, mu, kappa, rho)
    at = sp.lambdify(known, gradient)
    return (
        at,
        sp.lambdify((*F, *known), force, cse=True),
        sp.lambdify((*F, *known), P, cse=True),
    )


@pytest.mark.parametrize("phase", [0.0, 0.2, 0.5])
def test_manufactured_loads_against_sympy(family, phase):
    amplitude = amplitude_of_gradient(family, 0.2)
    scene = swinging_cube(family=family, amplitude=amplitude, manufactured=True)
    wave, m, t = scene.exact, scene.material, phase * scene.exact.period
    # The inertia is -rho w^2 u at every instant, so one symbol for U0 cos(w t) is enough.
    now = amplitude * math.cos(wave.frequency * t)
    force, stress = scene.body_force(POINTS, t), wave.first_piola(POINTS, t)
    gradient, exact_force, exact_stress = derived(family)
    for X, f, P in zip(POINTS, force, stress, strict=True):
        known = (*X, now, wave.frequency, m.mu, m.kappa, m.density)
        F = np.ravel(gradient(*known))
        f_exact = np.array(exact_force(*F, *known), dtype=float)
        P_exact = np.array(exact_stress(*F, *known), dtype=float)
        np.testing.assert_allclose(f, f_exact, atol=1e-9 * np.max(np.abs(f_exact)))
        np.testing.assert_allclose(P, P_exact, atol=1e-11 * np.max(np.abs(P_exact)))


def test_manufactured_tractions(family):
    scene = swinging_cube(family=family, amplitude=0.05, manufactured=True)
    wave, t = scene.exact, 0.1 * scene.exact.period
    assert sorted(load.face for load in scene.tractions) == ["X+", "X-", "Y+", "Y-", "Z+", "Z-"]
    N = RNG.normal(size=POINTS.shape)
    exact = (wave.first_piola(POINTS, t) @ N[:, :, None])[:, :, 0]
    for load in scene.tractions:
        np.testing.assert_allclose(load.value(POINTS, N, t), exact, rtol=1e-12)


def test_the_linear_scene_has_no_loads_and_needs_none(family):
    """The components that the constraints leave free carry no traction in the linear wave."""
    scene = swinging_cube(family=family)
    assert scene.tractions == ()
    assert isinstance(scene.body_force, NoBodyForce)
    wave, t = scene.exact, 0.1 * scene.exact.period
    atol = 1e-12 * scene.material.mu * wave.amplitude
    for axis in range(3):
        face = POINTS.copy()
        face[:, axis] = 0.0
        P = wave.first_piola(face, t)
        tangential = [k for k in range(3) if k != axis]
        np.testing.assert_allclose(P[:, tangential, axis], 0.0, atol=atol)
        face[:, axis] = 1.0
        np.testing.assert_allclose(wave.first_piola(face, t)[:, axis, axis], 0.0, atol=atol)


@pytest.mark.parametrize("manufactured", [False, True])
def test_the_wave_keeps_its_boundary_conditions(family, manufactured):
    scene = swinging_cube(family=family, manufactured=manufactured)
    mesh = scene.body.mesh(0.25)
    velocity = scene.exact.velocity(mesh.vertices, 0.2 * scene.end_time)
    for part in essential_parts(scene.constraints, mesh):
        held = np.einsum("nij,nj->ni", part.projector, velocity[part.particles])
        np.testing.assert_allclose(held, 0.0, atol=1e-13 * np.max(np.abs(velocity)))


def test_initial_state_is_the_wave_at_time_zero(family):
    scene = swinging_cube(family=family)
    u, v = scene.initial_state(POINTS)
    np.testing.assert_array_equal(u, scene.exact.displacement(POINTS, 0.0))
    np.testing.assert_array_equal(v, 0.0)


@pytest.mark.parametrize("manufactured", [False, True])
def test_a_moving_start_is_the_same_wave_a_quarter_of_its_period_later(family, manufactured):
    options = {"family": family, "amplitude": 0.05, "manufactured": manufactured}
    still, moving = (swinging_cube(start=s, **options).exact for s in ("displaced", "moving"))
    t = 0.13 * still.period
    for field in ("displacement", "velocity", "displacement_gradient", "first_piola", "body_force"):
        ours = getattr(moving, field)(POINTS, t)
        theirs = getattr(still, field)(POINTS, t - 0.25 * still.period)
        np.testing.assert_allclose(ours, theirs, atol=1e-11 * np.max(np.abs(theirs)))


def test_a_moving_start_has_no_displacement_and_no_strain(family):
    scene = swinging_cube(family=family, start="moving")
    u, v = scene.initial_state(POINTS)
    np.testing.assert_array_equal(u, 0.0)
    np.testing.assert_array_equal(scene.exact.deformation_gradient(POINTS, 0.0) - np.eye(3), 0.0)
    np.testing.assert_array_equal(v, scene.exact.velocity(POINTS, 0.0))
    assert np.abs(v).max() > 0.0
    with pytest.raises(InputError, match="'displaced' or 'moving'"):
        swinging_cube(start="late")


def test_scales_are_norms_of_the_amplitude(family):
    """Gauss quadrature of the largest momentum component, and the stress scale of the text."""
    scene = swinging_cube(family=family, amplitude=0.01)
    wave, m = scene.exact, scene.material
    x, weight = np.polynomial.legendre.leggauss(12)
    grid = np.stack(np.meshgrid(*[0.5 * (x + 1.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    volume = np.prod(np.meshgrid(*[0.5 * weight] * 3, indexing="ij"), axis=0).ravel()
    amplitude = m.density * wave.velocity(grid, 0.25 * wave.period)
    norms = np.sqrt(volume @ amplitude**2)
    assert wave.momentum_scale == pytest.approx(norms.max(), rel=1e-12)
    assert wave.stress_scale == pytest.approx(m.mu * math.pi * 0.01 / math.sqrt(8.0), rel=1e-12)


def test_amplitude_of_gradient(family):
    scene = swinging_cube(family=family, amplitude=amplitude_of_gradient(family, 0.2))
    origin = scene.exact.displacement_gradient(np.zeros((1, 3)), 0.0)[0]
    assert np.max(np.abs(np.linalg.eigvalsh(origin))) == pytest.approx(0.2, rel=1e-14)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"family": "A=B"}, "family"),
        ({"amplitude": 0.0}, "amplitude"),
        ({"amplitude": math.nan}, "amplitude"),
        ({"amplitude": 0.4}, "amplitude"),
        ({"poisson_ratio": 0.5}, "poisson_ratio"),
        ({"young_modulus": -1.0}, "young_modulus"),
        ({"density": 0.0}, "density"),
    ],
)
def test_bad_input_is_refused(arguments, named):
    with pytest.raises(InputError, match=named):
        swinging_cube(**arguments)


def test_errors_do_not_change_sign_with_the_amplitude():
    waves = [swinging_cube(amplitude=amplitude).exact for amplitude in (5e-4, -5e-4)]
    assert waves[0].momentum_scale == waves[1].momentum_scale > 0.0
    assert waves[0].stress_scale == waves[1].stress_scale > 0.0
