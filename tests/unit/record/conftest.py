"""A solver that solves nothing, with a state known at every time."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.continuum import NeoHookean
from sphsolid.errors import Diverged
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh
from sphsolid.record import Placement, PositionWatch, Snapshot
from sphsolid.scenes import swinging_cube

NO_MESH = HexMesh(np.zeros((0, 3)), np.zeros((0, 8), dtype=np.int64), {}, 1.0, True)


def snapshot_of(
    X, V, velocity, *, x=None, time=0.0, step=0, density=2.0, P=None, energy=0.0, mesh=NO_MESH
):
    """A snapshot at particles; ``F = I`` and no stress unless given."""
    identity = np.broadcast_to(np.eye(3), (len(X), 3, 3)).copy()
    return Snapshot(
        time=time,
        step=step,
        material=NeoHookean(mu=1.0, kappa=2.0, density=density),
        mesh=mesh,
        X=X,
        V=V,
        x=X.copy() if x is None else x,
        velocity=velocity,
        stress_X=X,
        stress_V=V,
        F=identity,
        J=np.ones(len(X)),
        P=np.zeros_like(identity) if P is None else P,
        strain_energy=energy,
    )


CUBE = HexMesh(CORNERS.astype(float), np.arange(8)[None, :], {}, 1.0, True)


class FakeSolver:
    """A cube of one cell that moves with speed ``t``; ``dt(t)`` is the stable step."""

    def __init__(self, *, dt=lambda t: 0.03, fails_at=np.inf, scene=None):
        self.scene = swinging_cube() if scene is None else scene
        self.time = 0.0
        self.step = 0
        self.positions = PositionWatch(every=2)
        self.steps = []
        self.name = "fake"
        self.x = CUBE.vertices.copy()
        self.changed = 0
        self.seconds = 1.0
        self.load = 1.0
        self.tracks = False
        self._dt = dt
        self._fails_at = fails_at

    def stable_time_step(self) -> float:
        if self.time >= self._fails_at:
            raise Diverged("negative Jacobian", self.time, self.step, 1, (0.0, 0.0, 1.0), "less")
        return self._dt(self.time)

    def advance(self, dt: float) -> None:
        self.steps.append(dt)
        self.x += dt * self.time
        self.time += dt
        self.step += 1

    def check_state(self) -> None:
        self.stable_time_step()

    def placement(self) -> Placement:
        return Placement(self.time, CUBE, self.x)

    def snapshot(self) -> Snapshot:
        velocity = np.full((8, 3), self.time)
        return snapshot_of(
            CUBE.vertices, np.full(8, 0.125), velocity,
            x=self.x.copy(), time=self.time, step=self.step, mesh=CUBE,
        )  # fmt: skip

    def plan(self) -> str:
        return "nothing\nto speak of"

    def identity(self) -> dict[str, str]:
        return {"scene": self.scene.name, "method": "fake"}

    def samples(self, times):
        return {"load": np.array([[self.load, 0.0, 0.0, self.load, 0.0, 0.0, 0.0] for _ in times])}

    def totals(self):
        return {"run_seconds": self.seconds}

    def go_on_from(self, totals) -> None:
        self.seconds = totals["run_seconds"]

    def track_budget(self) -> None:
        self.tracks = True

    def state_arrays(self):
        return {"x": self.x}

    def state_changed(self) -> None:
        self.changed += 1


@pytest.fixture
def fake_solver():
    return FakeSolver


@pytest.fixture
def make_snapshot():
    return snapshot_of
