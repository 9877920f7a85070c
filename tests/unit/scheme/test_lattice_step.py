"""A drift and a kick in one launch: the bits of both, one after the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud.lattice.box import box_of
from sphsolid.cloud.lattice.lines import grid_of
from sphsolid.compiled import serial_kernel
from sphsolid.scenes import Box, Constraint, Scene, Traction
from sphsolid.scheme.lattice_arguments import packed, unpacked
from sphsolid.scheme.lattice_form import LatticeRightHandSide
from sphsolid.scheme.lattice_operator import LatticeSums

SOLID = sph.NeoHookean.from_young(young_modulus=1.7e7, poisson_ratio=0.45, density=1100.0)


def scene(**more):
    return Scene(
        "shaken", Box(upper=(1.0, 1.3, 0.8)), SOLID, 0.004,
        initial_velocity=lambda X: np.random.default_rng(1).normal(size=X.shape), **more,
    )  # fmt: skip


SCENES = {
    "free": scene(),
    "loaded": scene(
        tractions=(Traction("Y+", lambda X, N, t: np.tile([1e5, 2e5, t], (len(X), 1))),),
        body_force=lambda X, t: np.stack([X[:, 1], t + 0.0 * X[:, 0], X[:, 0]], axis=1) * 1e4,
    ),
    "held": scene(constraints=(Constraint("Y-", "all"), Constraint("X-", "normal"))),
    "driven": scene(
        constraints=(
            Constraint("Y-", "all", velocity=lambda X, t: np.tile([0.3, t, 0.0], (len(X), 1))),
            Constraint("X+", "normal"),
        )
    ),
}  # fmt: skip


@pytest.mark.parametrize("integrator", [sph.PositionVerlet(), sph.SymplecticRKN4()])
@pytest.mark.parametrize("case", SCENES.values(), ids=SCENES)
def test_the_bits_are_those_of_a_drift_and_a_kick(case, integrator, monkeypatch):
    one = sph.Simulation(case, spacing=0.2, integrator=integrator)
    one.run(until=0.002)
    monkeypatch.setattr(LatticeRightHandSide, "drift_and_kick", lambda *_: False)
    other = sph.Simulation(case, spacing=0.2, integrator=integrator)
    other.run(until=0.002)
    assert one.step == other.step >= 3
    for name in ("x", "p"):
        np.testing.assert_array_equal(one.state[name], other.state[name])


@serial_kernel
def _numbers(lines, out):
    marker, whole, real, of_x, of_y, of_z = lines
    x, y, z = (
        unpacked(marker, whole, real, of_x, 0), unpacked(marker, whole, real, of_y, 1),
        unpacked(marker, whole, real, of_z, 2),
    )  # fmt: skip
    out[0], out[1], out[2] = x.column + x.begin + x.end, y.n + y.reach, z.edge + z.far
    out[3] = y.row[0, 0] + y.one + y.two + y.three
    out[4] = z.dx + z.near + z.middle + z.smooth[0, 3]


@pytest.mark.parametrize("order", [2, 4, 6])
def test_lines_are_unpacked_as_they_were(order):
    grid = grid_of(order, box_of(Box(upper=(1.3, 0.4, 1.0)).mesh(0.1)), smoothing=2)
    lines = packed(grid)
    for axis, line in enumerate(grid):
        again = unpacked(*lines[:3], lines[3 + axis], axis)
        assert type(again) is type(line)
        for name, value in line._asdict().items():
            np.testing.assert_array_equal(getattr(again, name), value, err_msg=name)
    x, y, z = grid
    out = np.zeros(5)
    _numbers(lines, out)
    expected = [
        x.column + x.begin + x.end, y.n + y.reach, z.edge + z.far,
        y.row[0, 0] + y.one + y.two + y.three, z.dx + z.near + z.middle + z.smooth[0, 3],
    ]  # fmt: skip
    np.testing.assert_array_equal(out, np.array(expected, dtype=float))


@dataclass(frozen=True)
class Own(sph.LatticeDifference):
    """May have coefficients of its own."""

    def build(self, cloud):
        return super().build(cloud)


def test_a_difference_of_ones_own_is_not_summed_along_its_parents_lines():
    usual = sph.Simulation(scene(), spacing=0.2)
    own = sph.Simulation(scene(), spacing=0.2, operator=Own(4))
    assert isinstance(usual._rhs, LatticeRightHandSide)
    assert not isinstance(own._rhs, LatticeRightHandSide)
    assert not isinstance(own._set_up.operator, LatticeSums)
