"""What a step costs, counted: no second is measured here."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.scenes import swinging_cube
from studies.speed.passes import pairs_of, passes
from studies.speed.plain_step import PlainStepper

PAPER = sph.SUPG(tau_F=1.0, xi_F=0.0)


def cube(cells: int, **options: object) -> sph.Simulation:
    return sph.Simulation(
        swinging_cube(amplitude=0.05), spacing=1.0 / cells,
        **{"formulation": sph.PF(), "stabilisation": PAPER, "integrator": sph.TVDRK2(), **options},
    )  # fmt: skip


def test_the_step_of_the_kernels_is_that_of_sparse_matrices() -> None:
    """Stencils, tiles and threads on one side, scipy on the other."""
    sim = cube(10)
    plain = PlainStepper(sim)
    for _ in range(3):
        dt = sim.stable_time_step()
        sim.advance(dt)
        plain.advance(dt)
    for mine, other in ((sim.state.p, plain.p), (sim.state.x, plain.x), (sim.state.F, plain.F)):
        np.testing.assert_allclose(mine, other, rtol=0, atol=1e-12 * np.max(np.abs(other)))


@pytest.mark.parametrize(
    "integrator", [sph.TVDRK2(), sph.SSPRK3(), sph.PositionVerlet(), sph.SymplecticRKN4()]
)
def test_a_step_allocates_no_field(integrator: object) -> None:
    """Nothing as long as the particles is made anew in the time loop."""
    sim = cube(16, integrator=integrator, stabilisation=sph.SUPG(weighting=sph.SelfAdjoint()))
    for _ in range(2):
        sim.advance(sim.stable_time_step())
    tracemalloc.start()
    for _ in range(3):
        sim.advance(sim.stable_time_step())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 24 * sim.cloud.size, "a vector field takes as much"


def test_absent_fields_and_terms_cost_nothing() -> None:
    """Bytes a particle and operations of an evaluation grow with what is asked for."""
    none = cube(8, stabilisation=sph.NoStabilisation(), angular_momentum=sph.NoProjection())
    rising = [
        none,
        cube(8, stabilisation=sph.NoStabilisation()),
        cube(8),
        cube(8, stabilisation=sph.SUPG(weighting=sph.SelfAdjoint(), xi_F=0.0)),
        cube(8, stabilisation=sph.SUPG(secondary=sph.H6(), xi_F=0.0)),
    ]
    flops = [sum(each.flops for each in passes(sim)) for sim in rising]
    assert flops == sorted(flops)
    memory = [
        cube(8, formulation=formulation).memory_bytes()
        for formulation in (sph.PF(), sph.PFJ(), sph.PFHJ())
    ]
    assert memory == sorted(memory)
    assert len({*memory}) == 3


def test_a_lattice_stores_few_of_its_pairs() -> None:
    """Memory of the operators: less than two thirds of what every pair would take."""
    sim, other = cube(24), cube(24)
    assert other.memory_bytes() == sim.memory_bytes()
    A = sim.cloud.kinematic
    assert A.coefficient.nbytes + A.own_value.nbytes < 0.66 * 24 * sim.cloud.pairs.pairs
    assert pairs_of(A) < 1.3 * sim.cloud.pairs.pairs
