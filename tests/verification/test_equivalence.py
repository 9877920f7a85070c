"""Schemes that are one scheme in exact arithmetic, and schemes that are not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from tests.oracles.blocks import loaded_block, spinning_block

Array = NDArray[np.float64]
STEPS = 200


def path(formulation: Any, scene: Any, **options: Any) -> dict[str, Array]:
    """Final fields after equal steps, without stabilisation unless asked for."""
    # Only the paper's integrator moves x and F by the same formula.
    options = {
        "stabilisation": sph.NoStabilisation(), "integrator": sph.TVDRK2(), "cfl": 0.3, **options
    }  # fmt: skip
    sim = sph.Simulation(scene, spacing=0.25, formulation=formulation, **options)
    dt = 0.5 * sim.stable_time_step()
    for _ in range(STEPS):
        sim.advance(dt)
    s = sim.snapshot()
    assert np.all(np.isfinite(s.P))
    assert s.J.min() > 0.2
    return {"x": s.x, "v": s.velocity, "F": s.F, "P": s.P}


def difference(one: dict[str, Array], other: dict[str, Array]) -> float:
    """Largest difference of any field relative to its size."""
    return max(float(np.max(np.abs(one[k] - other[k])) / np.max(np.abs(one[k]))) for k in one)


@pytest.mark.parametrize("operator", [sph.Consistent(), sph.Literal()], ids=lambda o: o.name)
@pytest.mark.parametrize("scene", [spinning_block(), loaded_block()], ids=lambda s: s.name)
def test_pf_without_stabilisation_is_displacement_sph(scene: Any, operator: Any) -> None:
    """The law of ``F`` integrates what ``F = sum x (x) G`` states: only round-off differs."""
    pf = path(sph.PF(), scene, operator=operator)
    displacement = path(sph.Displacement(), scene, operator=operator)
    assert difference(pf, displacement) < 2e-13
    # Fields that moved: the agreement is not that of a body at rest.
    assert np.max(np.abs(pf["F"] - np.eye(3))) > 0.2


def test_pj_without_stabilisation_is_pfj() -> None:
    pfj = path(sph.PFJ(), spinning_block())
    assert difference(pfj, path(sph.PJ(), spinning_block())) < 2e-13


@pytest.mark.parametrize("formulation", [sph.PFJ(), sph.PFHJ()], ids=lambda f: f.name)
def test_the_other_mixed_formulations_are_methods_of_their_own(formulation: Any) -> None:
    """``J`` and ``H`` follow their own laws, exact only as ``dt`` goes to zero."""
    displacement = path(sph.Displacement(), spinning_block())
    assert difference(path(formulation, spinning_block()), displacement) > 1e-4


def test_so_they_are_with_stabilisation_which_changes_both() -> None:
    """Both interpolate the same ``F`` to the secondary particles."""
    supg = {"stabilisation": sph.SUPG(tau_F=1.0, xi_F=0.1)}
    pf = path(sph.PF(), spinning_block(), **supg)
    assert difference(pf, path(sph.Displacement(), spinning_block(), **supg)) < 2e-13
    assert difference(pf, path(sph.PF(), spinning_block())) > 1e-3


def test_a_rigid_turn_of_the_problem_turns_the_answer() -> None:
    """Objectivity of the whole scheme: spin the initial state, get the spun result."""
    Q, _ = np.linalg.qr(np.random.default_rng(29).normal(size=(3, 3)))
    Q = Q * np.linalg.det(Q)
    scene = spinning_block()
    options: dict[str, Any] = {
        "spacing": 0.25,
        "formulation": sph.PFHJ(),
        "stabilisation": sph.SUPG(tau_p=0.1),
    }
    plain, turned = sph.Simulation(scene, **options), sph.Simulation(scene, **options)
    s = turned.state
    s.x[:], s.p[:] = s.x @ Q.T, s.p @ Q.T
    s.F[:], s.H[:] = Q @ s.F, Q @ s.H
    dt = plain.stable_time_step()
    assert turned.stable_time_step() == pytest.approx(dt, rel=1e-12)
    for _ in range(50):
        plain.advance(dt)
        turned.advance(dt)
    a, b = plain.snapshot(), turned.snapshot()
    np.testing.assert_allclose(b.x, a.x @ Q.T, atol=1e-12)
    np.testing.assert_allclose(b.P, Q @ a.P, atol=1e-11 * np.max(np.abs(a.P)))
    np.testing.assert_allclose(b.J, a.J, rtol=1e-12)
