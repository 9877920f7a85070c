"""Memory is counted once, by one rule, whoever wrote the class that holds it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.run.held_bytes import held_bytes
from sphsolid.scenes import swinging_cube


class Owner:
    """Of no package: a user's own."""

    def __init__(self) -> None:
        shared = np.zeros(1000)
        self.whole, self.view, self.deep = shared, shared[::2], shared.reshape(10, 100)[1:, 3:]
        self.inside = {"list": [shared, np.zeros((5, 5), np.float32)]}
        self.me = self


def test_every_array_counts_once():
    assert held_bytes(Owner()) == 8000 + 100
    assert held_bytes([Owner(), Owner()]) == 2 * 8100
    assert held_bytes((len, Owner, np, 1.0, "text")) == 0


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_a_simulation_holds_its_mesh_and_its_state(solver):
    sim = solver(swinging_cube(), spacing=1 / 6)
    snapshot = sim.snapshot()
    least = 3 * snapshot.X.nbytes + snapshot.mesh.cells.nbytes + snapshot.V.nbytes
    assert least < sim.memory_bytes() < 40 * least
    before = sim.memory_bytes()
    sim.own = np.zeros(12345)
    assert sim.memory_bytes() == before + 8 * 12345


def test_an_element_needs_not_say_what_it_holds():
    @dataclasses.dataclass(frozen=True)
    class Heavy:
        name: str = "heavy"
        base: object = dataclasses.field(default_factory=fem.BBarHex)

        def cell_size(self, spacing):
            return self.base.cell_size(spacing)

        def discretise(self, **given):
            made = self.base.discretise(**given)
            made.ballast = np.zeros(54321)
            return made

    light, heavy = (
        fem.Simulation(swinging_cube(), spacing=1 / 4, element=element)
        for element in (fem.BBarHex(), Heavy())
    )
    assert heavy.memory_bytes() == light.memory_bytes() + 8 * 54321
    assert f"{heavy.memory_bytes() / 1e6:.1f} MB" in heavy.plan()
