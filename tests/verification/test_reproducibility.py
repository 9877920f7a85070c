"""The same input gives the same bits, whatever the number of threads."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numba
import numpy as np
import pytest

import sphsolid as sph
from sphsolid.compiled import set_threads, threads
from sphsolid.record import AngularMomentum, Energy, Errors
from sphsolid.scenes import amplitude_of_gradient, swinging_cube, twisting_column
from tests.oracles.blocks import loaded_block

CUBE = {"family": "A=B=C", "amplitude": amplitude_of_gradient("A=B=C", 0.2), "manufactured": True}
CASES = {
    "manufactured cube, {p,F,H,J} H6 tau_p": (
        swinging_cube(**CUBE),
        {
            "formulation": sph.PFHJ(),
            "stabilisation": sph.SUPG(tau_F=1.0, xi_F=0.1, tau_p=0.1, secondary=sph.H6()),
        },
    ),
    "disordered cube, {p,F,J} H1 tau_p": (
        swinging_cube(**CUBE, jitter=0.2),
        {"formulation": sph.PFJ(), "stabilisation": sph.SUPG(tau_p=0.1)},
    ),
    "driven block, full Hessian": (
        loaded_block(),
        {
            "formulation": sph.PFHJ(),
            "stabilisation": sph.SUPG(
                tau_p=0.1, fine_scale=sph.FullHessian(tau_H=0.1, tau_J=0.1)
            ),
            "operator": sph.Consistent(use="force"),
        },
    ),
    "column, displacement": (
        twisting_column(),
        {"formulation": sph.Displacement(), "spacing": 0.25},
    ),
}


@pytest.fixture(autouse=True)
def _restore_threads() -> Iterator[None]:
    before = threads()
    yield
    set_threads(before)


def bits(case: str, count: int) -> dict[str, bytes]:
    """Set-up and 20 steps on ``count`` threads: every operator, field and record as bytes."""
    set_threads(count)
    assert threads() == count
    scene, options = CASES[case]
    options = {"spacing": 0.125, **options}
    sim = sph.Simulation(scene, **options)
    errors = [Errors()] if "cube" in case else []
    until = 20.5 * sim.stable_time_step()
    history = sim.run(until=until, every=until / 4.0, record=[Energy(), AngularMomentum(), *errors])
    found: dict[str, Any] = {f"state {k}": v for k, v in sim.state.items()}
    found |= {"kinematic": sim.cloud.gradients.kinematic, "force": sim.cloud.gradients.force}
    found |= {"P": sim.snapshot().P, "history": history.table.to_numpy()}
    assert np.all(np.isfinite(found["history"]))
    assert sim.step > 15
    return {name: np.ascontiguousarray(value).tobytes() for name, value in found.items()}


def differing(one: dict[str, bytes], other: dict[str, bytes]) -> list[str]:
    assert one.keys() == other.keys()
    return [name for name in one if one[name] != other[name]]


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="only one thread on this machine")
@pytest.mark.parametrize("case", list(CASES))
def test_one_and_two_threads_give_the_same_bits(case: str) -> None:
    assert differing(bits(case, 1), bits(case, 2)) == []


@pytest.mark.parametrize("case", list(CASES))
def test_two_equal_runs_give_the_same_bits(case: str) -> None:
    assert differing(bits(case, threads()), bits(case, threads())) == []


def test_the_comparison_sees_one_bit() -> None:
    one = {"x": np.ones(3).tobytes()}
    assert differing(one, {"x": np.nextafter(np.ones(3), [1, 2, 1]).tobytes()}) == ["x"]
