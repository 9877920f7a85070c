"""Stress measures of a snapshot against states whose answer is known by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, join, split
from sphsolid.errors import InputError
from tests.oracles.blocks import MOONEY, loaded_block
from tests.oracles.laws import LAWS

Array = NDArray[np.float64]
#: Volumes 2.4 and 0.5 times the undeformed: what forgets ``1 / det F`` is seen.
F = np.array(
    [[[2.0, 0.5, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 0.8]],
     [[0.5, 0.0, 0.0], [0.2, 1.0, 0.0], [0.0, 0.1, 1.0]]]
)  # fmt: skip
SIGMA = np.array(
    [[[7.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
     [[2.0, 3.0, 0.0], [3.0, 2.0, 4.0], [0.0, 4.0, 2.0]]]
)  # fmt: skip


def stressed(make_snapshot: Any, material: Any = None) -> Any:
    J = np.linalg.det(F)
    P = J[:, None, None] * SIGMA @ np.linalg.inv(F).swapaxes(1, 2)
    shot = make_snapshot(np.zeros((2, 3)), np.ones(2), np.zeros((2, 3)), P=P)
    return replace(shot, F=F, J=J, material=shot.material if material is None else material)


def test_cauchy_and_von_mises_are_forces_on_deformed_areas(make_snapshot: Any) -> None:
    """Uniaxial tension of 6 on a pressure, and shears 3 and 4: ``sqrt(3 (9 + 16))``."""
    shot = stressed(make_snapshot)
    np.testing.assert_allclose(shot.cauchy, SIGMA, atol=1e-14)
    np.testing.assert_allclose(shot.von_mises, [6.0, np.sqrt(75.0)], rtol=1e-13)
    for name in ("cauchy", "von_mises"):
        np.testing.assert_array_equal(shot.field(name).values, getattr(shot, name))
    with pytest.raises(InputError, match="cauchy"):
        shot.field("sigma")


@pytest.mark.parametrize("material", LAWS, ids=lambda m: type(m).__name__)
def test_pressure_and_volumetric_energy_are_those_of_the_law(
    make_snapshot: Any, material: Any
) -> None:
    shot = stressed(make_snapshot, material)
    J, kappa = np.linalg.det(F), material.kappa
    log = type(material).__name__ != "Mixed"
    pressure = kappa * np.log(J) / J if log else 0.5 * kappa * (J - 1.0 / J)
    U = 0.5 * kappa * np.log(J) ** 2 if log else 0.25 * kappa * (J * J - 1.0 - 2.0 * np.log(J))
    np.testing.assert_allclose(shot.pressure, pressure, rtol=1e-9)
    assert shot.volumetric_energy == pytest.approx(np.sum(U), rel=1e-9)
    # Positive in tension, and a third of the trace of the Cauchy stress of a law that splits.
    assert shot.pressure[0] > 0.0 > shot.pressure[1]
    entries = split(F)
    P = join(law.first_piola(material, entries, cofactor(entries), J))
    sigma = replace(shot, P=P).cauchy
    np.testing.assert_allclose(
        shot.pressure, np.trace(sigma, axis1=1, axis2=2) / 3.0, atol=1e-12 * kappa
    )
    np.testing.assert_allclose(
        stressed(make_snapshot).pressure, 2.0 * (J - 1.0), rtol=1e-13
    )


def test_the_stress_of_a_snapshot_is_that_of_the_evolved_cofactor() -> None:
    """{p,F,H,J} evolves ``H`` on its own; with two-stage steps it is not ``cof F``."""
    sim = sph.Simulation(
        loaded_block(MOONEY), spacing=0.25, formulation=sph.PFHJ(), integrator=sph.TVDRK2()
    )
    sim.run(until=2.0e-3)
    shot, state = sim.snapshot(), sim.state
    evolved = split(state.F), split(state.H), state.J
    geometric = split(state.F), cofactor(split(state.F)), state.J
    P, other = (join(law.first_piola(MOONEY, *fields)) for fields in (evolved, geometric))
    np.testing.assert_array_equal(shot.P, P)
    assert np.abs(P - other).max() > 1e-5 * np.abs(P).max()
    W, other_W = (law.stored_energy(MOONEY, *fields) @ shot.V for fields in (evolved, geometric))
    assert shot.strain_energy == pytest.approx(W, rel=1e-13)
    assert abs(W - other_W) > 1e-11 * W
