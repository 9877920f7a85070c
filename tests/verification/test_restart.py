"""N steps, a checkpoint, a fresh object and N steps give the bits of 2N steps."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.record import (
    AngularMomentum,
    Energy,
    EnergyBudget,
    History,
    MomentumDrift,
    Reactions,
    RunFolder,
    checkpoint,
    write_checkpoint,
)
from sphsolid.scenes import HeldVelocity, punch, twisting_column
from tests.oracles.blocks import loaded_block

RECORD = (Energy(), AngularMomentum(), EnergyBudget(), MomentumDrift(), Reactions())
#: Every load, a driven face, disordered particles: whatever a state can depend on is there.
MAKE: dict[str, Callable[[], Any]] = {
    "{p,F}": lambda: sph.Simulation(loaded_block(), spacing=0.25, formulation=sph.PF()),
    "{p,F,H,J} with tau_p": lambda: sph.Simulation(
        loaded_block(),
        spacing=0.25,
        formulation=sph.PFHJ(),
        stabilisation=sph.SUPG(tau_p=0.1, fine_scale=sph.FullHessian(tau_H=0.1, tau_J=0.1)),
        operator=sph.Consistent(use="force"),
    ),
    "displacement": lambda: sph.Simulation(
        loaded_block(), spacing=0.25, formulation=sph.Displacement()
    ),
    "{p,F,J} with three stages": lambda: sph.Simulation(
        loaded_block(), spacing=0.25, formulation=sph.PFJ(), integrator=sph.SSPRK3()
    ),
    "B-bar": lambda: fem.Simulation(loaded_block(), spacing=0.25),
}


def gap_of(sim: Any) -> float:
    """Four steps and a bit, so that steps are shortened to meet the records."""
    return float(4.3 * sim.stable_time_step())


def bits(sim: Any) -> dict[str, bytes]:
    """State and derived stress, as bytes; time and step."""
    found = {name: np.ascontiguousarray(a).tobytes() for name, a in sim.state_arrays().items()}
    clock = np.array([sim.time, sim.step]).tobytes()
    return found | {"P": sim.snapshot().P.tobytes(), "clock": clock}


def differing(one: dict[str, bytes], other: dict[str, bytes]) -> list[str]:
    assert one.keys() == other.keys()
    return [name for name in one if one[name] != other[name]]


def files(folder: Path) -> dict[str, bytes]:
    names = ["history.csv", "frames.pvd"]
    names += [f"frames/{file.name}" for file in (folder / "frames").iterdir()]
    return {name: (folder / name).read_bytes() for name in sorted(names)}


def run(sim: Any, records: int, gap: float, folder: Path, **options: Any) -> History:
    output = RunFolder(folder, **options)
    return sim.run(until=records * gap, every=gap, record=RECORD, output=output)


@pytest.mark.parametrize("case", list(MAKE))
def test_a_resumed_run_has_the_bits_of_one_that_never_stopped(case: str, tmp_path: Path) -> None:
    whole, first, second = (MAKE[case]() for _ in range(3))
    gap = gap_of(whole)
    history = run(whole, 6, gap, tmp_path / "whole")
    run(first, 3, gap, tmp_path / "parts")
    joined = run(second, 6, gap, tmp_path / "parts", resume=True)
    assert whole.step > 25
    assert differing(bits(second), bits(whole)) == []
    assert list(joined.table) == list(history.table)
    assert joined.table.to_numpy().tobytes() == history.table.to_numpy().tobytes()
    assert files(tmp_path / "parts") == files(tmp_path / "whole")
    # The comparison would see it: three more steps change every field that is evolved.
    before = bits(second)
    second.run(until=second.time + gap)
    assert {"x", "P", "clock"} <= set(differing(bits(second), before))


@pytest.mark.parametrize("case", list(MAKE))
def test_restore_goes_on_from_any_step(case: str, tmp_path: Path) -> None:
    whole, other = MAKE[case](), MAKE[case]()
    dt = 0.7 * whole.stable_time_step()
    for _ in range(5):
        whole.advance(dt)
    write_checkpoint(whole, tmp_path / "state.npz")
    other.restore(tmp_path / "state.npz")
    assert differing(bits(other), bits(whole)) == []
    assert other.stable_time_step() == whole.stable_time_step()
    for _ in range(5):
        whole.advance(dt)
        other.advance(dt)
    assert differing(bits(other), bits(whole)) == []


def test_restore_overwrites_whatever_was_computed_before(tmp_path: Path) -> None:
    sim = MAKE["{p,F}"]()
    sim.run(until=gap_of(sim))
    write_checkpoint(sim, tmp_path / "state.npz")
    saved = bits(sim)
    sim.run(until=3.0 * sim.time)
    assert differing(bits(sim), saved) != []
    sim.restore(tmp_path / "state.npz")
    assert differing(bits(sim), saved) == []


def next_bits(sim: Any, dt: float) -> dict[str, bytes]:
    sim.advance(dt)
    return bits(sim)


def test_an_incomplete_checkpoint_would_be_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Planted omissions: the evolved volume map of SPH, the acceleration of FEM."""
    for case, what in (("{p,F,J} with three stages", "J"), ("B-bar", "a")):
        whole, other = MAKE[case](), MAKE[case]()
        dt = 0.7 * whole.stable_time_step()
        for _ in range(5):
            whole.advance(dt)
        with monkeypatch.context() as planted:
            complete = type(other).state_arrays
            planted.setattr(
                type(other),
                "state_arrays",
                lambda self, complete=complete, what=what: {
                    k: v for k, v in complete(self).items() if k != what
                },
            )
            write_checkpoint(whole, tmp_path / "state.npz")
            other.restore(tmp_path / "state.npz")
        assert differing(next_bits(other, dt), next_bits(whole, dt)) != [], what


# ------------------------------------------------------------------ what does not fit
def column(**options: Any) -> Any:
    scene = {k: options.pop(k) for k in ("angular_velocity", "poisson_ratio") if k in options}
    given = {"spacing": 0.5, "formulation": sph.PFJ(), **options}
    return sph.Simulation(twisting_column(**scene), **given)


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("restart") / "column.npz"
    sim = column()
    sim.run(until=1e-3)
    write_checkpoint(sim, path)
    return path


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"formulation": sph.PF()}, r"formulation: PFJ\(\) there, PF\(\) here"),
        (
            {"stabilisation": sph.SUPG(tau_F=0.7)},
            r"stabilisation: .*tau_F=OfMesh\(c=0.4.*tau_F=OfStep\(c=0.7\)",
        ),
        ({"operator": sph.Literal()}, "operator"),
        ({"smoothing": sph.CubicSpline()}, "smoothing"),
        ({"h_over_dx": 0.8}, "h_over_dx: 0.77 there, 0.8 here"),
        ({"cfl": 0.2}, "cfl: 0.7 there, 0.2 here"),
        ({"angular_momentum": sph.NoProjection()}, "angular_momentum"),
        ({"spacing": 0.4}, "points: .*initial velocity differs"),
        ({"angular_velocity": 100.0}, r"\(initial velocity differs: its .* there and .* here"),
        ({"poisson_ratio": 0.49}, "material"),
    ],
)
def test_another_simulation_is_refused(saved: Path, options: dict[str, Any], named: str) -> None:
    sim = column(**options)
    before = bits(sim)
    with pytest.raises(sph.InputError, match=rf"does not fit this simulation.*{named}"):
        sim.restore(saved)
    assert differing(bits(sim), before) == []


def test_the_other_method_is_refused(saved: Path) -> None:
    with pytest.raises(sph.InputError, match="method: SPH there, FEM here"):
        fem.Simulation(twisting_column(), spacing=0.5).restore(saved)


def test_other_sources_are_refused(saved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checkpoint, "SOURCE_HASH", "0123456789abcdef")
    with pytest.raises(sph.InputError, match=r"sources: .* there, 0123456789abcdef here"):
        column().restore(saved)


def test_an_account_cannot_be_taken_up_where_none_was_kept(saved: Path) -> None:
    sim = column()
    sim.track_budget()
    with pytest.raises(sph.InputError, match=r"no array 'budget.*same recorders"):
        sim.restore(saved)
    column().restore(saved)


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_the_account_seconds_and_steps_go_on_after_a_restart(solver: Any, tmp_path: Path) -> None:
    ledger = (EnergyBudget(),)
    sim = solver(loaded_block(), spacing=0.25)
    gap = gap_of(sim)
    sim.run(until=gap, record=ledger)
    write_checkpoint(sim, tmp_path / "c.npz")
    spent, summary = sim.totals(), sim.summary()
    whole = sim.run(until=2 * gap, record=ledger)
    other = solver(loaded_block(), spacing=0.25)
    other.restore(tmp_path / "c.npz")
    assert other.totals() == spent
    assert other.summary().split(" steps")[0] == summary.split(" steps")[0]
    parts = other.run(until=2 * gap, record=ledger)
    assert parts.table.iloc[-1].equals(whole.table.iloc[-1])
    assert other.totals()["run_seconds"] > spent["run_seconds"]


def test_a_probe_elsewhere_and_another_load_are_refused_by_name(tmp_path: Path) -> None:
    def block(**parts: Any) -> Any:
        return dataclasses.replace(loaded_block(), **parts)

    for solver in (sph.Simulation, fem.Simulation):
        path = tmp_path / "c.npz"
        write_checkpoint(solver(block(probes={"tip": (1.0, 0.0, 0.0)}), spacing=0.5), path)
        for parts, named in (
            ({"probes": {"tip": (0.0, 0.0, 1.0)}}, r"probe tip: X = \[1.0, .* there, X = \[0.0, "),
            ({"body_force": lambda X, t: 0.0 * X}, "body force differs"),
            ({"initial_velocity": lambda X: 0.0 * X}, "initial velocity differs"),
        ):
            other = solver(block(**({"probes": {"tip": (1.0, 0.0, 0.0)}} | parts)), spacing=0.5)
            with pytest.raises(sph.InputError, match=named):
                other.restore(path)


def test_a_larger_punch_of_the_same_name_is_refused(tmp_path: Path) -> None:
    """A fixed condition says nothing that could be sampled: its place does."""

    def held(limit: float) -> Any:
        return sph.Simulation(punch(press=HeldVelocity(limit)), spacing=0.1)

    write_checkpoint(held(0.5), tmp_path / "c.npz")
    held(0.5).restore(tmp_path / "c.npz")
    with pytest.raises(sph.InputError, match="boundary pressed: "):
        held(0.7).restore(tmp_path / "c.npz")
