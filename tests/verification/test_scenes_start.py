"""Scenes as the solvers see them: what a lattice makes of the known momenta and energies."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.record import AngularMomentum, Energy, Probe
from sphsolid.scenes import (
    HeldVelocity,
    InitialVelocity,
    bending_column,
    l_shaped_block,
    punch,
    spinning_cube,
    twisting_column,
)

#: ``rho0 Omega^2 / 4`` [J] and ``rho0 Omega 2 / pi`` [kg m^2/s] of the twisting column.
COLUMN_ENERGY, COLUMN_MOMENTUM = 1100.0 * 105.0**2 / 4.0, 1100.0 * 105.0 * 2.0 / math.pi


#: Particles whose volumes are those of the cells around them.
particles = partial(sph.Simulation, formulation=sph.PF())


@pytest.mark.parametrize("cells", [3, 4, 5, 10])
@pytest.mark.parametrize("solver", [particles, fem.Simulation])
def test_twisting_column_on_every_lattice(solver, cells):
    """Both exceed the exact integrals by 2 dx^2 of the cross-section; 22 %, 12.5 %, 8 %, 2 %.

    Along the length the sine is integrated with an error of dx^2 / (12 L^2) pi^2 / 4, its square
    exactly.
    """
    sim = solver(twisting_column(), spacing=1.0 / cells)
    s = sim.snapshot()
    assert len(s.X) == (cells + 1) ** 2 * (6 * cells + 1)
    section = 1.0 + 2.0 / cells**2
    along = math.pi / (24.0 * cells) / math.tan(math.pi / (24.0 * cells))
    row = {**Energy().record(s, sim.scene), **AngularMomentum().record(s, sim.scene)}
    assert row["kinetic_energy [J]"] == pytest.approx(COLUMN_ENERGY * section, rel=1e-12)
    L = [row[f"angular_momentum_{k} [kg m^2/s]"] for k in "xyz"]
    np.testing.assert_allclose(L[1], COLUMN_MOMENTUM * section * along, rtol=1e-12)
    np.testing.assert_allclose([L[0], L[2]], 0.0, atol=1e-9 * COLUMN_MOMENTUM)
    assert row["strain_energy [J]"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("angular_velocity", [-105.0, 0.0, 150.0, 200.0, 300.0])
@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.499, 0.4999])
def test_twisting_column_takes_any_speed_and_poisson_ratio(angular_velocity, poisson_ratio):
    scene = twisting_column(angular_velocity=angular_velocity, poisson_ratio=poisson_ratio)
    sim = fem.Simulation(scene, spacing=1.0 / 3.0)
    expected = 1100.0 * angular_velocity**2 / 4.0 * (1.0 + 2.0 / 9.0)
    assert sim.snapshot().kinetic_energy == pytest.approx(expected, rel=1e-12)
    sim.advance(sim.stable_time_step())


@pytest.mark.parametrize("solver", [particles, fem.Simulation])
def test_spinning_cube_keeps_its_angular_momentum_for_a_turn(solver):
    sim = solver(spinning_cube(turns=1.0), spacing=0.25)
    table = sim.run(every=0.01, record=[AngularMomentum()]).table
    L = table["angular_momentum_z [kg m^2/s]"].to_numpy()
    assert L[0] == pytest.approx(19_250.0 * 1.125, rel=1e-13)
    np.testing.assert_allclose(L, L[0], rtol=1e-12)


#: Scene, spacing [m], time [s], and how far the solvers may differ in the root mean square of
#: displacement, over its largest value.  The punch starts with a jump in velocity.
SCENES = {
    "l_shaped_block": (l_shaped_block(), 0.85, 0.2, 0.03),
    "punch": (punch(), 1 / 20, 1e-3, 0.08),
    "bending_column": (bending_column(), 1 / 3, 0.02, 0.02),
    "spinning_cube": (spinning_cube(), 1 / 4, 5e-3, 0.03),
}


@pytest.mark.parametrize("name", SCENES)
def test_both_solvers_agree_at_the_start_of_a_run(name):
    """The same statement, read by both: no load or condition on another face."""
    scene, spacing, until, most = SCENES[name]
    found = []
    for solver in (sph.Simulation, fem.Simulation):
        # Steps short enough that what differs is the scheme in space.
        sim = solver(scene, spacing=spacing, cfl=0.2)
        sim.run(until=until)
        found.append(sim.snapshot().displacement)
    difference = math.sqrt(np.mean(np.sum((found[0] - found[1]) ** 2, axis=1)))
    assert difference < most * np.abs(found[1]).max()


@pytest.mark.slow
def test_bending_column_peak():
    """B-bar on 8 x 48 x 8: 2.989 m at 0.453 s, the figure of an independent code."""
    sim = fem.Simulation(bending_column(), spacing=1 / 8)
    table = sim.run(until=0.5, every=1e-3, record=[Probe("top_centre")]).table
    u = table["top_centre_u_x [m]"].to_numpy()
    assert u.max() == pytest.approx(2.989, rel=2e-3)
    assert table["time [s]"][int(u.argmax())] == pytest.approx(0.453, abs=2e-3)


@pytest.mark.slow
def test_punch_readings_are_those_of_the_independent_figures():
    """Top face at 0.015 s: [0.455, 0.541] m started, [0.350, 0.744] m held and sliding."""
    for press, low, high in (
        (InitialVelocity(), 0.455, 0.541),
        (HeldVelocity(), 0.350, 0.744),
    ):
        sim = fem.Simulation(punch(press=press), spacing=1 / 40)
        sim.run(until=0.015)
        s = sim.snapshot()
        top = s.x[np.isclose(s.X[:, 2], 0.5), 2]
        assert (top.min(), top.max()) == pytest.approx((low, high), abs=1e-3)
