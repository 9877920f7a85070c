"""The step of a body whose volume grew: waves are faster there than the smallest stretch says."""

from __future__ import annotations

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.continuum.wave_speed import GROWN, reference_p_wave_speed, wave_speeds
from sphsolid.scenes import Box, Constraint, Scene

LAWS = {
    law.__name__: law.from_young(young_modulus=1.0e7, poisson_ratio=0.3, density=1000.0)
    for law in (sph.NeoHookean, sph.SaintVenantKirchhoff)
}
STRETCHES = ((1.5, 1.5, 1.5), (2.0, 1.0, 1.0), (1.3, 1.3, 1.0))
#: Waves of Saint Venant-Kirchhoff along a stretch grow as ``(3 stretch^2 - 1) / 2`` in their
#: square, without end: at 2 they are beyond what any rule of ``J`` knows.
PAIRS = [
    (law, stretch) for law in LAWS for stretch in STRETCHES
    if law != "SaintVenantKirchhoff" or stretch != (2.0, 1.0, 1.0)
]  # fmt: skip


def stretched(law: str, stretch: tuple[float, float, float]) -> Scene:
    """A cube held on all sides at a homogeneous stretch, with noise in the velocity."""
    rng = np.random.default_rng(0)
    return Scene(
        "stretched", Box(), LAWS[law], 1.0,
        initial_displacement=lambda X: (np.array(stretch) - 1.0) * X,
        initial_velocity=lambda X: 1.0e-6 * rng.standard_normal(X.shape),
        constraints=tuple(Constraint(f"{axis}{end}", "all") for axis in "XYZ" for end in "-+"),
    )  # fmt: skip


@pytest.mark.parametrize(("law", "stretch"), PAIRS)
def test_noise_in_a_grown_body_does_not_grow(law: str, stretch: tuple[float, float, float]) -> None:
    sim = sph.Simulation(stretched(law, stretch), spacing=0.25)
    sizes = []
    for _ in range(120):
        sim.advance(sim.stable_time_step())
        sizes.append(float(np.abs(sim.snapshot().velocity).max()))
    assert max(sizes[-20:]) < max(sizes[:20])


@pytest.mark.parametrize(("law", "stretch"), PAIRS)
def test_the_step_is_below_that_of_the_fastest_wave(
    law: str, stretch: tuple[float, float, float]
) -> None:
    """``dt c / h`` stays below one, the limit of the undeformed body, at the default CFL number."""
    sim = sph.Simulation(stretched(law, stretch), spacing=0.25)
    there = sim.stable_time_step()
    rest = sph.Simulation(stretched(law, (1.0, 1.0, 1.0)), spacing=0.25).stable_time_step()
    F, normals = np.diag(stretch), np.vstack([np.eye(3), np.ones((1, 3)) / np.sqrt(3.0)])
    fastest = max(float(wave_speeds(LAWS[law], F, N)[-1]) for N in normals)
    assert there / rest * fastest / reference_p_wave_speed(LAWS[law]) * 0.7 < 0.9


def test_a_volume_that_grows_little_has_the_step_that_the_paper_gives_it() -> None:
    a = (0.99 * GROWN) ** (1.0 / 3.0)
    scenes = [stretched("NeoHookean", stretch) for stretch in ((1.0, 1.0, 1.0), (a, a, a))]
    rest, grown = (sph.Simulation(scene, spacing=0.25).stable_time_step() for scene in scenes)
    assert grown == pytest.approx(a * rest, rel=1e-9)
