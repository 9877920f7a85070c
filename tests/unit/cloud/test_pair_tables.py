"""The lists of pairs of a box lattice are made for those who ask, and only then."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud.pair_tables import KeptTables, Packed, TablesOnDemand
from sphsolid.record import EnergyBudget, LinearMomentum
from sphsolid.scenes import swinging_cube, twisting_column


@pytest.fixture
def packed(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """One entry for every time that tables are packed."""
    calls: list[int] = []
    of = Packed.of.__func__

    def counting(cls, tables, V, *, stencils):
        calls.append(len(V))
        return of(cls, tables, V, stencils=stencils)

    monkeypatch.setattr(Packed, "of", classmethod(counting))
    return calls


@pytest.mark.parametrize("order", [2, 4, 6])
def test_a_run_along_lines_never_asks(packed, order, tmp_path):
    sim = sph.Simulation(
        twisting_column(), spacing=0.5, operator=sph.LatticeDifference(order=order)
    )
    sim.run(until=2e-3, every=1e-3, record=[EnergyBudget(), LinearMomentum()])
    other = copy.deepcopy(sim)
    other.run(until=3e-3)
    other.save(tmp_path / "end.vtu")
    sim.plan(), sim.summary(), sim.placement()
    assert packed == []
    assert isinstance(sim.cloud.tables, TablesOnDemand)


def test_another_formulation_asks_once(packed):
    sim = sph.Simulation(
        swinging_cube(), spacing=1 / 4, operator=sph.LatticeDifference(), formulation=sph.PF(),
        stabilisation=sph.NoStabilisation(),
    )  # fmt: skip
    sim.run(until=1e-3)
    assert len(packed) == 1


def test_other_clouds_keep_theirs(packed):
    sim = sph.Simulation(swinging_cube(), spacing=1 / 4, operator=sph.Consistent())
    assert len(packed) == 1
    assert isinstance(sim.cloud.tables, KeptTables)
    before = sim.cloud.pairs
    sim.cloud.tables.forget()
    np.testing.assert_array_equal(sim.cloud.pairs.indices, before.indices)


def test_what_is_made_again_is_what_was_made():
    cloud = sph.Simulation(swinging_cube(), spacing=1 / 5).cloud
    first, G = cloud.pairs, cloud.gradients
    assert cloud.tables._made is None, "it was let go of after the set-up"
    # Asked for as sums, they are kept from then on.
    tables = cloud.tables.packed
    assert cloud.kinematic is tables.kinematic is cloud.force
    assert cloud.tables.packed is tables
    pairs, kinematic = cloud.pairs, cloud.gradients.kinematic
    np.testing.assert_array_equal(pairs.indptr, first.indptr)
    np.testing.assert_array_equal(pairs.indices, first.indices)
    np.testing.assert_array_equal(kinematic, G.kinematic)
    assert cloud.mean_neighbours == pytest.approx(tables.kinematic.mean_neighbours, rel=1e-12)
    assert cloud.is_adjoint
