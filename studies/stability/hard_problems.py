"""The problems of the hard cases, each an object that a method runs, and how a run is followed."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

import fem_reference as fem
import sphsolid as sph
from sphsolid.continuum.wave_speed import reference_p_wave_speed
from sphsolid.errors import Diverged, FoldingWarning
from sphsolid.record import EnergyBudget, Positions, Recorder, Snapshot
from sphsolid.record.plain import plain
from sphsolid.scenes import (
    Box,
    Constraint,
    HeldVelocity,
    InitialVelocity,
    Scene,
    punch,
    twisting_column,
)
from studies.engine.case import Row
from studies.measures.indicators import pressure_noise, twist_of_top, whole_turns
from studies.measures.run import run
from studies.methods import Method

Array = NDArray[np.float64]
#: The solid of the columns and the blocks: Young's modulus [Pa] and density [kg/m^3].
YOUNG, DENSITY = 17.0e6, 1100.0
#: Instants at which a run is looked at.
RECORDS = 50
#: The end of the paper's column [s]: longer ones say the energy that was left then.
TENTH = 0.1
#: A step this much below the first means that a particle is about to collapse.
COLLAPSED = 1.0 / 200.0
#: Seeds are small beside everything, so the solid answers linearly: velocity over wave speed,
#: or relative change of volume.  They are followed for so many transits of a p-wave.
SEED, CROSSINGS = 1.0e-4, 100
#: Of the pulled block: noise, velocity over p-wave speed, and the speed [m/s] of either end, a
#: twentieth of its shear wave speed.
PULL_NOISE, PULL = 1.0e-3, 5.0
#: What an answer is; criteria differ by it.
SEED_LEFT, NOISE_GROWTH = "seed left [-]", "noise growth [-]"


@dataclass(frozen=True)
class Measured:
    """A recorder made of functions of the snapshot, by the names of their columns."""

    columns: Mapping[str, Callable[[Snapshot], float]]

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """All columns."""
        return {name: float(measure(snapshot)) for name, measure in self.columns.items()}


@dataclass(frozen=True)
class Kept:
    """Keeps every snapshot; adds no column."""

    #: Not in its repr, which every record asks for: all arrays would be printed each time.
    shots: list[Snapshot] = field(default_factory=list, repr=False)

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """No column."""
        self.shots.append(snapshot)
        return {}


HEALTH = Measured(
    {"J_min": lambda shot: shot.J.min(), "J_max": lambda shot: shot.J.max(),
     "noise": pressure_noise}
)  # fmt: skip


def give_up_on_collapse(solver: Any) -> None:
    """Let ``solver`` raise ``Diverged`` when its stable step falls below ``COLLAPSED`` of it now.

    Otherwise a method whose particles fold, and never turn inside out, takes ever smaller steps.
    """
    usual = solver.stable_time_step
    least = COLLAPSED * usual()

    def stable_time_step() -> float:
        dt = float(usual())
        if dt < least:
            shot = solver.snapshot()
            stretch = np.linalg.svd(shot.F, compute_uv=False)[:, -1]
            a = int(np.argmin(stretch))
            x, y, z = (float(c) for c in shot.stress_X[a])
            raise Diverged(
                f"the stable step collapsed (stretch {stretch[a]:.2g})",
                shot.time, shot.step, a, (x, y, z), "more dissipation or a finer spacing",
            )  # fmt: skip
        return dt

    solver.stable_time_step = stable_time_step


def followed(solver: Any, *recorders: Recorder) -> tuple[dict[str, Array], Row]:
    """Run to the end of the scene: its history as arrays, and the columns of its row.

    That positions fold is in the row, and no warning.
    """
    give_up_on_collapse(solver)
    until = solver.scene.end_time
    record: list[Recorder] = [EnergyBudget(), HEALTH, Positions(), *recorders]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FoldingWarning)
        ran = run(solver, until=until, every=until / RECORDS, record=record)
    history = {name: ran.history[name].to_numpy() for name in ran.history}
    noise = history["noise"]
    row = ran.columns() | settings(solver) | energy_shares(history) | {
        "end_time": until, "particles": len(solver.snapshot().X),
        "J_min": np.min(history["J_min"]), "J_max": np.max(history["J_max"]),
        "unseen_rms": np.max(history["unseen_rms [-]"]),
        "unseen_max": np.max(history["unseen_max [-]"]),
        "inside_out": np.max(history["inside_out_share [-]"]),
        "smallest_det": np.min(history["smallest_det [-]"]),
        # Early on hardly any pressure is there, and its noise says nothing.
        "noise_end": noise[-1], "noise_max": np.max(noise[len(noise) // 2 :]),
    }  # fmt: skip
    return history, row


def energy_shares(history: Mapping[str, Array]) -> Row:
    """Shares of the largest energy put in so far: what is kept, dissipated, made, and by whom.

    Put in: what was there and the works of loads and prescribed motion.  ``kept`` at the end;
    ``gain`` the largest excess over what was put in, at any record; ``projection``, ``defect``
    and ``rest`` (the time integrator) at the end, positive where energy was made; dissipated by
    ``D(p)``, by ``D(J)`` and by a restraint, negative where the stabilisation made energy.
    """
    total = history["total_energy [J]"]
    work = sum(history[f"work_{name} [J]"] for name in ("traction", "body_force", "constraint"))
    put_in = total[0] + work
    scale = np.maximum.accumulate(np.maximum(put_in, np.finfo(float).tiny))
    end = {
        "energy_kept": total, "dissipated_p": -history["dissipation_p [J]"],
        "dissipated_J": -history["dissipation_J [J]"],
        "dissipated_restraint": 0.0 - _column(history, "dissipation_restraint [J]"),
        "energy_projection": history["work_projection [J]"],
        "energy_defect": history["work_adjoint_defect [J]"],
        "energy_rest": history["energy_rest [J]"],
    }  # fmt: skip
    shares = {name: float(values[-1] / scale[-1]) for name, values in end.items()}
    return shares | {"energy_gain": float(np.max((total - put_in) / scale))}


def _column(history: Mapping[str, Array], name: str) -> Array:
    """A work that not every method has; zeros where it has none."""
    return history.get(name, np.zeros_like(history["total_energy [J]"]))


def settings(solver: sph.Simulation | fem.Simulation) -> Row:
    """The options of a particle method, as columns; of finite elements none."""
    if isinstance(solver, fem.Simulation):
        return {}
    return {
        "formulation": solver.formulation.name, "stabilisation": plain(solver.stabilisation),
        "operator": plain(solver.operator), "h_over_dx": solver.h_over_dx,
        "integrator": solver.integrator.name,
    }  # fmt: skip


class Problem(Protocol):
    """A problem that a method runs with points ``h`` [m] apart."""

    def row(self, method: Method, h: float) -> Row:
        """What became of the run, with its ``answer`` and what that is."""
        ...


@dataclass(frozen=True)
class Column:
    """The twisting column; answer: the largest twist of its top [rad]."""

    angular_velocity: float = 105.0
    poisson_ratio: float = 0.495
    jitter: float = 0.0
    end_time: float = 0.1

    def row(self, method: Method, h: float) -> Row:
        """Whole turns are followed from record to record."""
        scene = twisting_column(
            angular_velocity=self.angular_velocity, poisson_ratio=self.poisson_ratio,
            end_time=self.end_time,
        )  # fmt: skip
        body = replace(scene.body, jitter=self.jitter)  # type: ignore[type-var]
        solver = method.simulation(replace(scene, body=body), spacing=h)
        history, row = followed(solver, Measured({"angle": twist_of_top, "height": height_of_top}))
        twist = itertools.accumulate(
            history["angle"], lambda last, angle: whole_turns(angle, last), initial=0.0
        )
        energy = history["total_energy [J]"]
        at = np.isclose(history["time [s]"], TENTH)
        return row | {
            "answer": max(map(abs, twist)), "answer_is": "largest twist [rad]",
            "top_height": float(history["height"][-1]) if row["survived"] else math.nan,
            "energy_at_tenth": float(energy[at][0] / energy[0]) if at.any() else math.nan,
        }  # fmt: skip


def height_of_top(shot: Snapshot) -> float:
    """Mean height [m] of the particles of the top face."""
    return float(shot.x[np.isclose(shot.X[:, 1], shot.X[:, 1].max()), 1].mean())


@dataclass(frozen=True)
class Punch:
    """The punch; answer: how high its top stands at the end over the undeformed one [m]."""

    held: bool
    end_time: float = 0.03

    def row(self, method: Method, h: float) -> Row:
        """The height of the last state."""
        press = HeldVelocity() if self.held else InitialVelocity()
        solver = method.simulation(punch(press=press, end_time=self.end_time), spacing=h)
        _, row = followed(solver)
        end = solver.snapshot()
        height = np.max(end.x[:, 2]) - np.max(end.X[:, 2])
        return row | {"answer": height, "answer_is": "bulge of the top [m]"}


def alternating(X: Array, spacing: float, axes: str = "xyz") -> Array:
    """``(-1)^(i+j+k) (n,)`` over the lattice numbers of ``X (n, 3)`` along ``axes``."""
    number = np.rint(X[:, ["xyz".index(axis) for axis in axes]] / spacing)
    return np.asarray((-1.0) ** number.sum(axis=1))


def solid(nu: float) -> sph.NeoHookean:
    """The material of the columns with another Poisson's ratio."""
    return sph.NeoHookean.from_young(young_modulus=YOUNG, poisson_ratio=nu, density=DENSITY)


def block(*, poisson_ratio: float = 0.495) -> Scene:
    """A unit cube at rest, clamped at ``X = 0``, for :data:`CROSSINGS` transits of a p-wave."""
    material = solid(poisson_ratio)
    return Scene(
        name="seeded_block",
        body=Box(),
        material=material,
        end_time=CROSSINGS / reference_p_wave_speed(material),
        constraints=(Constraint("X-", "all"),),
        provenance="Ours: the twisting column's solid, a seed of 1e-4.",
    )


@dataclass(frozen=True)
class Seed:
    """A velocity that a sound method damps or at least keeps bounded.

    ``sawtooth``: ``v_x`` alternates along X (no gradient at particles, one at cell centroids);
    ``hourglass``: ``v_x`` alternates along all axes (no gradient at either); ``noise``: random.
    Answer: its share in the last quarter over that at the start, or for ``noise``, which is no one
    mode, the root of the energy over that at the start.
    """

    pattern: Literal["sawtooth", "hourglass", "noise"]

    def velocity(self, X: Array, spacing: float) -> Array:
        """``(n, 3)``, of size one."""
        if self.pattern == "noise":
            return np.random.default_rng(7).standard_normal(X.shape)
        return np.outer(self._mode(X, spacing), [1.0, 0.0, 0.0])

    def _mode(self, X: Array, spacing: float) -> Array:
        return alternating(X, spacing, "x" if self.pattern == "sawtooth" else "xyz")

    def row(self, method: Method, h: float) -> Row:
        """The block with the seed."""
        still = block()
        size = SEED * reference_p_wave_speed(still.material)
        scene = replace(still, initial_velocity=lambda X: size * self.velocity(X, h))
        solver = method.simulation(scene, spacing=h)
        mode = self._mode(solver.snapshot().X, h)
        share = _share(mode, lambda shot: shot.velocity[:, 0])
        history, row = followed(solver, share)
        energy = np.sqrt(np.abs(history["total_energy [J]"]))
        return row | _left(energy if self.pattern == "noise" else history["share"])


@dataclass(frozen=True)
class Checkerboard:
    """``J = 1 +- 1e-4`` in a checkerboard; answer: its share in the last quarter over the first.

    Seeded in ``F`` where ``J`` is ``det F``.  A method whose ``J`` follows from the positions has
    nothing to seed, its row says so.
    """

    def row(self, method: Method, h: float) -> Row:
        """The block with the seed."""
        solver = method.simulation(block(), spacing=h)
        if isinstance(solver, fem.Simulation) or not solver.formulation.evolves_F:
            return {"applicable": False, "why": "J follows from the positions"}
        pattern, state = alternating(solver.cloud.X, h), solver.state
        if len(state.J):
            state.J *= 1.0 + SEED * pattern
        else:
            state.F *= np.cbrt(1.0 + SEED * pattern)[:, None, None]
        history, row = followed(solver, _share(pattern, lambda shot: shot.J - 1.0))
        return row | _left(history["share"])


def _share(pattern: Array, of: Callable[[Snapshot], Array]) -> Measured:
    """How much of a pattern ``(n,)`` is in a field, by volume."""
    return Measured({"share": lambda shot: np.average(of(shot) * pattern, weights=shot.V)})


def _left(measure: Array) -> Row:
    last = np.max(np.abs(measure[-max(1, len(measure) // 4) :]))
    return {"answer": last / np.abs(measure[0]), "answer_is": SEED_LEFT}


@dataclass(frozen=True)
class Pulling:
    """``v_x = 2 PULL (X - 1/2)`` at all times: both ends move apart at :data:`PULL` [m/s]."""

    noise: float = 0.0

    def __call__(self, X: Array, t: float = 0.0) -> Array:
        """``(n, 3)`` [m/s]."""
        velocity = np.zeros_like(X)
        velocity[:, 0] = 2.0 * PULL * (X[:, 0] - 0.5)
        return velocity + self.noise * np.random.default_rng(7).standard_normal(X.shape)


@dataclass(frozen=True)
class Pulled:
    """A unit cube pulled along X to twice its length, free to become thinner, with and without
    noise in its initial velocity; answer: growth of the noise.

    The difference of the two runs' velocities, root mean square at its largest over that at the
    start; ``clumping`` is the largest change of a cell edge by the noise, over the edge.
    """

    def scene(self, *, noisy: bool) -> Scene:
        """Uniform tension to stretch 2, the seat of the tensile instability."""
        still = block(poisson_ratio=0.45)
        noise = PULL_NOISE * reference_p_wave_speed(still.material) if noisy else 0.0
        ends = tuple(Constraint(face, "normal", Pulling()) for face in ("X-", "X+"))
        return replace(
            still, name="pulled_block", end_time=0.5 / PULL, initial_velocity=Pulling(noise),
            constraints=ends, provenance="Ours: uniform tension to stretch 2.",
        )  # fmt: skip

    def row(self, method: Method, h: float) -> Row:
        """That of the noisy run, unless the other one diverged."""
        solvers = [method.simulation(self.scene(noisy=n), spacing=h) for n in (False, True)]
        start = _distance(*(solver.snapshot() for solver in solvers))
        kept = (Kept(), Kept())
        clean, noisy = (followed(*pair)[1] for pair in zip(solvers, kept, strict=True))
        row = noisy if clean["survived"] else clean
        both = list(zip(kept[0].shots, kept[1].shots, strict=False))
        growth = [_distance(*shots) / start for shots in both]
        return row | {
            "answer": max(growth), "answer_is": NOISE_GROWTH, "noise_left": growth[-1],
            "clumping": _clumping(*both[-1]),
        }  # fmt: skip


def _distance(clean: Snapshot, noisy: Snapshot) -> float:
    return float(np.sqrt(np.mean((clean.velocity - noisy.velocity) ** 2)))


def _clumping(clean: Snapshot, noisy: Snapshot) -> float:
    cells = clean.mesh.cells
    a, b = np.array(((0, 1), (1, 2), (3, 2), (0, 3), (4, 5), (5, 6), (7, 6), (4, 7), (0, 4), (1, 5),
                     (2, 6), (3, 7))).T  # fmt: skip
    before, after = (
        np.linalg.norm(shot.x[cells[:, b]] - shot.x[cells[:, a]], axis=-1)
        for shot in (clean, noisy)
    )
    return float(np.max(np.abs(after / before - 1.0)))
