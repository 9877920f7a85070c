"""The spectrum: against the stepper, known systems, plane waves, a run, and planted patterns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.errors import InputError
from sphsolid.scenes import Box, Scene, Traction
from studies.engine.case import execute
from studies.engine.results import Results
from studies.methods import PAPER, SUPG
from studies.stability.spectrum import Linearisation, PlaneWaves, brillouin_zone, take_times_at
from studies.stability.spectrum_cases import (
    BODIES,
    INTERIOR,
    RATIOS,
    Block,
    _case,
    _variants,
    contraction,
    default_limits_figure,
    limits_figure,
    map_figure,
    spectrum_cases,
    spectrum_tables,
)
from studies.stability.spectrum_growth import (
    decades,
    largest_modulus,
    lattice_places,
    limits,
    name_of_wave,
    shape,
)

#: The paper's settings of a compressible solid, xi_F > 0 so that the geometry is felt.
PLAIN = PAPER.but(formulation=sph.PF(), operator=sph.Consistent(), h_over_dx=0.77, xi_F=0.1)
RK3, VERLET = sph.SSPRK3(), sph.PositionVerlet()
#: With ``tau_p`` the rates are of the second degree in the step.
SELF_ADJOINT = {"weighting": sph.SelfAdjoint()}
WITH_J = {"formulation": sph.PFJ(), "tau_p": sph.OfStep(0.1)}


def built(side=3, body="free", *, nu=0.3, jitter=0.0, stretch=1.0, **changes):
    scene = Block(body, nu, jitter, stretch).scene(side - 1)
    return PLAIN.but(**changes).simulation(scene, spacing=1.0)


def linearised(side=3, body="free", **changes):
    return Linearisation(built(side, body, **changes))


def material(nu=0.3):
    return sph.NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=nu, density=1100.0)


def sorted_moduli(linear, cfl):
    g = linear.eigenvalues(cfl)
    return np.sort(np.abs(g[np.abs(g - 1.0) > 1e-5]))


def random_state(linear, seed=0):
    return np.random.default_rng(seed).standard_normal(linear.layout.rows)


def disturb(linear, y):
    """Put the state of the simulation at its base plus ``y``, strains those of ``w``."""
    sim, base = linear.simulation, linear._base
    w, v, J = linear.fields(y)
    state = sim.state
    state.p[:] = sim.scene.material.density * linear.length / linear.unit_time * v
    sim._rhs.kinematic_gradient(base.x + linear.length * w, 1.0, state.F)
    x = linear.layout.position(y[:, None])[:, 0]
    u = np.zeros(w.size)
    u[linear.free] = x
    state.x[:] = base.x + linear.length * u.reshape(w.shape)
    if sim.formulation.evolves_H:
        state.H[:] = join(cofactor(split(state.F)))
    if sim.formulation.evolves_J:
        state.J[:] = base.J + J if linear.has_J else determinant(split(state.F))


def observed(linear):
    """Position, velocity, ``F`` and ``J`` of the simulation, less the base."""
    sim, base = linear.simulation, linear._base
    x = ((sim.state.x - base.x) / linear.length).reshape(-1)[linear.free]
    speed = sim.scene.material.density * linear.length / linear.unit_time
    v = (sim.state.p / speed).reshape(-1)[linear.free]
    parts = [x, v, (sim.state.F - base.F).reshape(-1)]
    return np.concatenate([*parts, sim.state.J - base.J] if linear.has_J else parts)


def predicted(linear, y):
    """The same of a disturbance; positions are seen only where the map has them."""
    w, v, J = linear.fields(y)
    F = np.empty((len(w), 3, 3))
    linear.rhs.kinematic_gradient(linear.length * w, 1.0, F)
    x = linear.layout.position(y[:, None])[:, 0]
    parts = [x, v.reshape(-1)[linear.free], F.reshape(-1)]
    return np.concatenate([*parts, J] if linear.has_J else parts)


def agrees(linear, found, y, cfl, tolerance=2e-7):
    """One real step along ``y`` is what the map says, in all that the map holds."""
    expected, seen = predicted(linear, found), one_step(linear, y, cfl)
    # With SSP-RK3 the positions are not w; where they are not felt they are left out of the map.
    holds_x = linear.layout.own_x or linear.layout.strains_follow_x or (
        not isinstance(linear.simulation.integrator, sph.SSPRK3)
    )  # fmt: skip
    first = 0 if holds_x else linear.moves
    return np.max(np.abs(expected - seen)[first:]) < tolerance * np.max(np.abs(expected))


def one_step(linear, y, cfl, size=1.0e-5):
    """The derivative of the real stepper along ``y``."""
    step = cfl * linear.unit_time
    take_times_at(linear.simulation, step)
    ends = []
    for sign in (1.0, -1.0):
        disturb(linear, sign * size * y)
        linear.simulation._stepper.advance(step, 0.0)
        ends.append(observed(linear))
    return (ends[0] - ends[1]) / (2.0 * size)


@pytest.mark.parametrize("operator", [sph.Consistent(), sph.Literal()])
def test_without_stabilisation_an_adjoint_pair_only_oscillates(operator):
    plain = {"stabilisation": sph.NoStabilisation(), "operator": operator}
    linear = linearised(4, **plain)
    values = np.linalg.eigvals(linear.elastic.T @ linear.generator(0.3) @ linear.elastic)
    assert linear.rigid.shape == (192, 6)
    assert len(values) == 2 * (192 - 6)
    assert np.max(np.abs(values.real)) < 1e-12
    assert np.min(np.abs(values.imag)) > 0.1, "no mode is left without stiffness"
    # Growth of an undamped oscillation in two stages and decay in three, in closed form.
    cfl = 0.3
    z = cfl * np.sort(np.abs(values.imag))
    assert sorted_moduli(linear, cfl) == pytest.approx(np.sqrt(1.0 + z**4 / 4.0), abs=1e-10)
    three = linearised(4, integrator=RK3, **plain)
    expected = np.sort(np.abs(1.0 + 1j * z - z**2 / 2.0 - 1j * z**3 / 6.0))
    assert sorted_moduli(three, cfl) == pytest.approx(expected, abs=1e-10)


def test_a_force_that_is_not_the_adjoint_makes_energy():
    linear = linearised(
        4, stabilisation=sph.NoStabilisation(), operator=sph.Consistent(use="force")
    )
    values = np.linalg.eigvals(linear.elastic.T @ linear.generator(0.3) @ linear.elastic)
    assert np.max(values.real) > 0.01


@pytest.mark.parametrize("integrator", [sph.TVDRK2(), RK3, VERLET])
@pytest.mark.parametrize(
    ("body", "changes"),
    [
        ("free", {}),
        ("free", SELF_ADJOINT | WITH_J | {"nu": 0.45}),
        ("rollers", {"formulation": sph.Displacement()}),
        ("free", WITH_J | {"formulation": sph.PFHJ(), "secondary": sph.H6(), "nu": 0.45}),
        ("clamped", WITH_J | {"formulation": sph.PJ(), "operator": sph.Consistent(use="force")}),
        ("free", {"xi_F": 0.0}),
    ],
)
def test_the_map_is_the_derivative_of_the_stepper(body, changes, integrator):
    linear = linearised(3, body, integrator=integrator, **changes)
    y = random_state(linear)
    assert agrees(linear, linear.step_matrix(0.4) @ y, y, 0.4)


@pytest.mark.parametrize(
    "integrator", [sph.TVDRK2(), sph.SSPRK3(), sph.PositionVerlet(), sph.SymplecticRKN4()]
)
def test_the_map_about_a_stretched_state_is_the_derivative_of_the_stepper(integrator):
    m = material(0.45)
    across = contraction(m, 1.5)
    F = (1.5, 0.0, 0.0, 0.0, across, 0.0, 0.0, 0.0, across)
    P = law.first_piola(m, F, cofactor(F), determinant(F))
    assert abs(P[4]) < 1e-6 * P[0]
    scene = Scene(
        name="stretched", body=Box(upper=(3.0, 3.0, 3.0)), material=m, end_time=1.0,
        initial_displacement=lambda X: X * (np.array([1.5, across, across]) - 1.0),
        constraints=BODIES["rollers"],
        tractions=(Traction("X+", lambda X, N, t: P[0] * N),),
    )  # fmt: skip
    stabilisation = sph.SUPG(tau_p=0.1)
    sim = sph.Simulation(
        scene, spacing=1.0, formulation=sph.PFJ(), stabilisation=stabilisation,
        integrator=integrator,
    )  # fmt: skip
    linear = Linearisation(sim)
    y = random_state(linear)
    assert agrees(linear, linear.step_matrix(0.3) @ y, y, 0.3)


@pytest.mark.slow
def test_only_the_pressure_term_tells_the_formulations_apart():
    plain = sorted_moduli(linearised(3), 0.3)
    for formulation in (sph.PFJ(), sph.PFHJ(), sph.PJ(), sph.Displacement()):
        other = linearised(3, formulation=formulation)
        assert sorted_moduli(other, 0.3) == pytest.approx(plain, abs=1e-8)
    with_J = sorted_moduli(linearised(3, **WITH_J), 0.3)
    for formulation in (sph.PFHJ(), sph.PJ()):
        other = linearised(3, **(WITH_J | {"formulation": formulation}))
        assert sorted_moduli(other, 0.3) == pytest.approx(with_J, abs=1e-8)
    assert np.max(np.abs(with_J[-len(plain) :] - plain)) > 1e-3


def test_times_of_the_mesh_are_those_of_the_step_at_every_step():
    own = SELF_ADJOINT | WITH_J | {"nu": 0.495, "xi_F": 0.05, "integrator": VERLET}
    mesh = linearised(3, tau_F=sph.OfMesh(0.5), **own)
    for cfl in (0.3, 0.8):
        step = linearised(3, tau_F=sph.OfStep(0.5 / cfl), **own)
        largest = np.max(np.abs(step.step_matrix(cfl)))
        apart = mesh.step_matrix(cfl) - step.step_matrix(cfl)
        assert np.max(np.abs(apart)) < 1e-10 * largest


@pytest.mark.parametrize("tau_F", [0.5, 4.0])
def test_only_the_self_adjoint_damping_takes_energy_whatever_its_time(tau_F):
    """In the norm of the energy: velocities of the damping alone, ``v . D`` has no other sign."""
    for weighting, definite in ((sph.SelfAdjoint(), True), (sph.AsPrinted(), False)):
        times = {"tau_F": sph.OfStep(tau_F), "xi_F": 0.0}
        linear = linearised(4, weighting=weighting, nu=0.495, **times)
        m = linear.moves
        damping = linear.generator(1.0)[m : 2 * m, m : 2 * m]
        V = np.repeat(linear.simulation.cloud.V, 3)[linear.free]
        power = V[:, None] * damping
        largest = np.max(np.linalg.eigvalsh(0.5 * (power + power.T)))
        assert (largest < 1e-10 * np.max(np.abs(power))) == definite
        asymmetry = np.max(np.abs(power - power.T)) / np.max(np.abs(power))
        assert (asymmetry < 1e-9) == definite


@pytest.mark.parametrize(
    "changes",
    [
        {"secondary": sph.H6(), "stretch": 1.3},
        WITH_J | {"operator": sph.Literal()},
        SELF_ADJOINT | WITH_J | {"nu": 0.45, "stretch": 1.2},
    ],
)
def test_plane_waves_see_the_interior_of_a_block(changes):
    """The rates of a whole wave on the block, at its middle particle."""
    linear = linearised(15, **changes)
    k, cfl = np.array([[0.7, -1.9, 2.4]]), 0.3
    waves = PlaneWaves(linear, k)
    rates, a = waves.rates(cfl), waves.inner
    rng = np.random.default_rng(3)
    y = rng.standard_normal(waves.size) + 1j * rng.standard_normal(waves.size)
    z = rng.standard_normal(3) + 0j
    X = linear.simulation.cloud.X
    phase = np.exp(1j * (X - X[a]) @ k[0] / linear.length)
    parts = [np.outer(phase, y[:3]).ravel(), np.outer(phase, y[3:6]).ravel()]
    wave = np.concatenate([*parts, phase * y[6]] if linear.has_J else parts)
    moved = np.outer(phase, z).ravel()
    rate = linear.rate(wave.real, moved.real, cfl) + 1j * linear.rate(wave.imag, moved.imag, cfl)
    u, v, J = linear.fields(rate)
    found = np.concatenate([u[a], v[a], [J[a]] if linear.has_J else []])
    assert found == pytest.approx(rates.A[0] @ y + rates.B[0] @ z, abs=1e-8)


def test_long_plane_waves_travel_at_the_speeds_of_the_solid():
    waves = PlaneWaves(linearised(15), np.array([[0.02, 0.0, 0.0]]))
    speed = np.sort(np.abs(np.angle(waves.eigenvalues(0.1)[0]))) / 0.1 / 0.02
    m = material()
    ratio = np.sqrt(m.mu / (m.kappa + 4.0 / 3.0 * m.mu))
    assert speed == pytest.approx([ratio] * 4 + [1.0] * 2, rel=2e-4)


def test_half_the_zone_has_a_wave_of_every_pair():
    k = brillouin_zone(5)
    assert len(k) == 5 * 5 * 3 - 1
    assert np.abs(k).max() == np.pi


def test_a_run_grows_as_the_spectrum_says():
    linear = linearised(4, nu=0.45, **WITH_J)
    cfl, steps = 0.3, 60
    g, modes = linear.modes(cfl)
    assert abs(g[0]) > 1.01, "the corner mode of the short support"
    mode = modes[:, 0] / np.max(np.abs(modes[:, 0]))
    disturb(linear, 1.0e-7 * mode.real)
    seen = predicted(linear, mode.real), -predicted(linear, mode.imag)
    basis = np.stack(seen, axis=1)
    sizes = []
    for _ in range(steps):
        part = np.linalg.lstsq(basis, observed(linear), rcond=None)[0]
        sizes.append(np.hypot(*part))
        linear.simulation.advance(cfl * linear.unit_time)
    growth = (sizes[-1] / sizes[0]) ** (1.0 / (steps - 1))
    assert growth - 1.0 == pytest.approx(abs(g[0]) - 1.0, rel=1e-4)


@pytest.mark.parametrize("jitter", [0.0, 0.2])
@pytest.mark.parametrize(
    ("axes", "name"),
    [
        ((1, 1, 1), "checkerboard"),
        ((1, 1, 0), "hourglass"),
        ((0, 1, 0), "layers"),
        ((0, 0, 0), "smooth"),
    ],
)
def test_planted_patterns_are_recognised(axes, name, jitter):
    body = Box(upper=(6.0, 5.0, 4.0), jitter=jitter, seed=1)
    scene = replace(Block().scene(2), body=body)
    sim = PLAIN.but(h_over_dx=0.9).simulation(scene, spacing=1.0)
    place = lattice_places(sim)
    sign = 1.0 - 2.0 * ((place @ np.array(axes)) % 2)
    envelope = 1.0 + 0.1 * place[:, 0] - 0.15 * place[:, 2]
    nothing = np.zeros(sim.cloud.size)
    u = np.outer(sign * envelope, [0.3, -0.5, 1.0 + 0.5j])
    noise = 0.1 * np.random.default_rng(0).standard_normal(u.shape)
    assert shape(sim, u + noise, nothing).name == name
    assert shape(sim, 0.0 * u, sign * envelope).name == name + " of J"


def test_corners_surfaces_and_unseen_modes_are_recognised():
    sim = built(7)
    place, nothing = lattice_places(sim), np.zeros(sim.cloud.size)
    outer = np.count_nonzero((place == 0) | (place == 6), axis=1)
    random = np.random.default_rng(0).standard_normal((sim.cloud.size, 3))
    assert shape(sim, random * (outer >= 2)[:, None], nothing).name == "corner"
    assert shape(sim, random * (outer == 1)[:, None], nothing).name == "surface"
    assert shape(sim, random, nothing).name == "short wave"
    # (-1)^(j+k) cos(pi i / 2): no gradient at centroids, too short for a pattern times a linear.
    wave = (-1.0) ** (place[:, 1] + place[:, 2]) * np.cos(0.5 * np.pi * place[:, 0])
    assert shape(sim, np.outer(wave, [1.0, 0.0, 0.0]), nothing).name == "hourglass"
    gradient = shape(sim, sim.cloud.X @ np.ones((3, 3)), nothing)
    assert gradient.seen == pytest.approx(1.0, rel=1e-9)


def test_waves_are_named():
    pi = np.pi
    names = [name_of_wave(pi * np.array(k)) for k in
             ((1, -1, 1), (1, 0.5, -1), (0.2, 1, 0), (0.5, 0.5, 0), (0.2, 0, 0.1))]  # fmt: skip
    assert names == ["checkerboard", "hourglass", "layers", "short wave", "smooth"]


def test_limits_are_found():
    def modulus(cfl):
        return 1.0 + max(0.0, cfl - 0.123) ** 2 + (10.0 if cfl > 0.777 else 0.0)

    scanned = {cfl: modulus(cfl) for cfl in (0.1, 0.4, 0.7, 1.0)}
    wanted = {"strict": 1.0 + 1e-8, "slow": 1.0025, "fast": 2.0, "never": 20.0}
    found = limits(modulus, scanned, wanted)
    expected = {"strict": 0.123, "slow": 0.173, "fast": 0.777, "never": 1.0}
    for name, value in expected.items():
        assert value - 0.005 < found[name] <= value + 1e-4, name
    assert limits(lambda cfl: 2.0, {0.1: 2.0}, {"strict": 1.0}) == {"strict": 0.0}
    assert largest_modulus(np.array([1.0 + 1e-9j, 0.9j, -0.5])) == 0.9
    assert decades(10.0**0.002) == pytest.approx(2.0)


def test_what_cannot_be_linearised_is_refused():
    k = brillouin_zone(3)
    with pytest.raises(InputError, match="no interior with one stencil"):
        PlaneWaves(linearised(5), k)
    with pytest.raises(InputError, match="need a free lattice"):
        PlaneWaves(linearised(5, jitter=0.2, h_over_dx=0.9), k)
    scene = replace(Block().scene(2), initial_velocity=np.ones_like)
    with pytest.raises(InputError, match="start it without velocity"):
        Linearisation(sph.Simulation(scene, spacing=1.0))


@pytest.mark.slow
def test_cases_make_tables_and_figures(tmp_path):
    cases = [
        _case("base", "base", SUPG.name, SUPG, Block(), 3),
        _case("base", "base", SUPG.name, SUPG, Block(INTERIOR), 3),
        _case("map", "0.9", "a", SUPG.but(h_over_dx=0.9), Block(), 3),
        _case("limits", "{p,F}", "position Verlet", SUPG.but(formulation=sph.PF()),
              Block(nu=0.3), 3),
        _case("larger", "base", SUPG.name, SUPG, Block(), 3),
    ]  # fmt: skip
    outcomes = [execute(case) for case in cases]
    assert [outcome.message for outcome in outcomes] == [""] * 5
    tables = spectrum_tables([row for outcome in outcomes for row in outcome.rows])
    found = tables["spectrum"]
    assert len(found) == 5
    assert found["max_g"][4] == found["max_g"][0], "the same block"
    named = sorted(tables["limits"]["formulation"])
    assert named == ["{p,F,J}", "{p,F}"], "without tau_p one run is the limit of both"
    assert tables["limits"]["cfl_slow"].nunique() == 1
    assert len(tables["spectrum_growth"]) == 3 * 10 + 12 + 1
    limit = found.set_index("body").loc[INTERIOR]
    assert 0.6 < limit["cfl_strict"] <= limit["cfl_slow"] <= limit["cfl_fast"] <= 1.2
    results = Results(tmp_path, tables, found, {})
    for figure in (map_figure, limits_figure, default_limits_figure):
        assert figure(results).axes
    nothing = Results(tmp_path, spectrum_tables([]), found, {})
    for figure in (map_figure, limits_figure, default_limits_figure):
        with pytest.raises(InputError, match="run studies"):
            figure(nothing)


def test_the_whole_list_covers_every_scan():
    listed = list(spectrum_cases(quick=False))
    keys = [case.key for case in listed]
    assert len(set(keys)) == len(keys)
    asked = {case.arguments["variant"] for case in listed}
    assert {variant for _, variant, _, _ in _variants(SUPG)} <= asked
    assert len(list(spectrum_cases(quick=True))) < 20


def test_every_limit_that_the_package_looks_up_is_asked_for():
    asked = {
        (case.arguments["base"], case.arguments["variant"])
        for case in spectrum_cases(quick=False) if case.arguments["scan_of"] == "limits"
    }  # fmt: skip
    for each in (sph.PositionVerlet(), sph.SSPRK3(), sph.TVDRK2()):
        for nu in RATIOS:
            assert (each.name, f"{{p,F}}, nu {nu:g}") in asked
            assert ((each.name, f"{{p,F,J}}, nu {nu:g}") in asked) == (nu >= 0.49)
