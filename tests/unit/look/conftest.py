"""Short runs of both methods in folders, made once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.record import Energy, RunFolder
from tests.oracles.blocks import loaded_block


@dataclass(frozen=True)
class Ran:
    simulation: Any
    folder: Path


@pytest.fixture(scope="session")
def ran(tmp_path_factory) -> dict[str, Ran]:
    """A loaded block after four records, by particles and by elements."""
    made = {}
    for name, method in (("sph", sph), ("fem", fem)):
        simulation = method.Simulation(loaded_block(), spacing=0.5)
        folder = tmp_path_factory.mktemp(name)
        step = simulation.stable_time_step()
        simulation.run(
            until=6 * step, every=2 * step, record=[Energy()], output=RunFolder(folder)
        )
        made[name] = Ran(simulation, folder)
    return made
