"""The patch test: an affine motion is an exact solution, so nothing may accelerate.

With ``Consistent`` a uniform stress makes no force inside and exactly ``A_a P N_a / V_a`` at the
boundary, on lattices and on disordered particles.  With ``Literal`` it makes ``O(P / dx)``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.geometry.integrals import layers_from_boundary
from tests.oracles.blocks import AFFINE, FORMULATIONS, MOONEY, RUBBER, stress_of, stretched_block
from tests.oracles.checkers import accelerations, patch_imbalance

#: The divergence theorem is solved to 1e-13 of the largest area; a corner has 1/8 of a volume.
ROUND_OFF = 1e-11
CONSISTENT = [sph.Consistent(), sph.Consistent(use="force")]
SUPG = sph.SUPG(tau_F=1.0, xi_F=0.2, secondary=sph.H6())


@pytest.mark.parametrize("jitter", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("operator", CONSISTENT, ids=lambda o: o.name)
@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_an_affine_stretch_with_its_tractions_does_not_accelerate(
    formulation: Any, operator: Any, jitter: float
) -> None:
    assert patch_imbalance(jitter=jitter, formulation=formulation, operator=operator) < ROUND_OFF


@pytest.mark.parametrize("material", [MOONEY, RUBBER])
def test_nor_with_stabilisation(material: Any) -> None:
    """The residuals of an affine state vanish at the secondary particles too."""
    imbalance = patch_imbalance(jitter=0.2, material=material, stabilisation=SUPG)
    assert imbalance < ROUND_OFF


def test_any_affine_stretch_will_do() -> None:
    random = np.random.default_rng(23)
    found = 0
    while found < 5:
        F = np.eye(3) + 0.6 * random.uniform(-1.0, 1.0, (3, 3))
        if np.linalg.det(F) < 0.2:
            continue
        found += 1
        sim, rate = accelerations(stretched_block(F, jitter=0.2))
        size = np.max(np.abs(stress_of(MOONEY, F))) / sim.cloud.spacing
        assert np.max(np.abs(rate)) < ROUND_OFF * size


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_a_free_stretched_body_feels_exactly_its_boundary(jitter: float) -> None:
    """``dp/dt = -P N_a A_a / V_a``: zero inside, nothing but the missing traction outside."""
    sim, rate = accelerations(stretched_block(jitter=jitter, loaded=False))
    P = stress_of(MOONEY, AFFINE)
    size = np.max(np.abs(P)) / sim.cloud.spacing
    expected = -sim.cloud.areas @ P.T / sim.cloud.V[:, None]
    np.testing.assert_allclose(rate, expected, atol=ROUND_OFF * size)
    inside = layers_from_boundary(sim.cloud.mesh) > 0
    assert np.count_nonzero(inside) > 30
    assert np.max(np.abs(rate[inside])) < ROUND_OFF * size
    assert np.min(np.max(np.abs(rate[~inside]), axis=1)) > 0.1 * size


def test_it_stays_at_rest_over_many_steps() -> None:
    scene = stretched_block(jitter=0.2)
    sim = sph.Simulation(scene, spacing=0.2, formulation=sph.PFHJ(), stabilisation=SUPG)
    start = sim.state.x.copy()
    for _ in range(50):
        sim.advance(sim.stable_time_step())
    s = sim.snapshot()
    P = stress_of(MOONEY, AFFINE)
    np.testing.assert_allclose(s.P, np.broadcast_to(P, s.P.shape), atol=1e-9 * np.abs(P).max())
    assert np.max(np.abs(s.x - start)) < 1e-11


@pytest.mark.parametrize("spacing", [0.2, 0.1])
@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_the_paper_read_literally_fails_however_fine_the_cloud(
    jitter: float, spacing: float
) -> None:
    """``O(P / dx)``: the imbalance in units of ``P / dx`` does not fall with the spacing."""
    assert patch_imbalance(jitter=jitter, operator=sph.Literal(), spacing=spacing) > 0.3


def test_literal_inner_forces_of_a_lattice_vanish_only_away_from_the_boundary() -> None:
    sim, rate = accelerations(
        stretched_block(), operator=sph.Literal(), spacing=0.1, h_over_dx=0.75
    )
    size = np.max(np.abs(stress_of(MOONEY, AFFINE))) / sim.cloud.spacing
    worst = [
        np.max(np.abs(rate[layers_from_boundary(sim.cloud.mesh) == k])) / size for k in range(4)
    ]
    assert min(worst[:2]) > 0.03
    assert worst[3] < 1e-12


def test_literal_inner_forces_of_a_disordered_cloud_vanish_nowhere() -> None:
    sim, rate = accelerations(stretched_block(jitter=0.2), operator=sph.Literal(), spacing=0.1)
    size = np.max(np.abs(stress_of(MOONEY, AFFINE))) / sim.cloud.spacing
    deep = layers_from_boundary(sim.cloud.mesh) >= 3
    assert np.median(np.max(np.abs(rate[deep]), axis=1)) > 1e-2 * size
