"""The lattice difference as an operator of a cloud: identities, orders, loads, refusals."""

from __future__ import annotations

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import WendlandC2, build_cloud, consistency_report
from sphsolid.errors import InputError
from sphsolid.scenes import Blocks, Box, Scene, Traction

SOLID = sph.NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.3, density=1000.0)

L_SHAPE = Blocks((((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((1.0, 0.0, 0.0), (2.0, 0.5, 1.0))))


def cloud(order, upper=(1.0, 1.0, 1.0), spacing=0.1):
    return build_cloud(
        Box(upper=upper).mesh(spacing), smoothing=WendlandC2(), h_over_dx=0.77,
        operator=sph.LatticeDifference(order),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("order", "upper"),
    [(2, (1.0, 1.0, 1.0)), (4, (1.0, 2.0, 0.3)), (6, (2.0, 1.0, 1.2)), (4, (1.0, 0.1, 0.2))],
)
def test_it_sums_by_parts_with_its_own_volumes_and_areas(order, upper):
    made = cloud(order, upper)
    report = consistency_report(made, float(np.prod(upper)))
    for residual in (report.C0, report.C1, report.D0, report.SBP, report.volume):
        assert residual < 1e-12
    tags = sum(made.areas_of(name) for name in made.mesh.faces)
    np.testing.assert_allclose(tags, made.areas, atol=1e-15)


@pytest.mark.parametrize(("order", "inside"), [(2, 2), (4, 4), (6, 6)])
def test_polynomials_of_its_order_are_exact_inside(order, inside):
    made = cloud(order, (2.0, 2.0, 2.0))
    x = made.X[:, 1] - 1.0
    f = x**inside
    G = made.gradients.kinematic
    slope = np.zeros(made.size)
    np.add.at(slope, made.pairs.row_of_pair, f[made.pairs.indices.astype(int)] * G[:, 1])
    error = np.abs(slope - inside * x ** (inside - 1))
    middle = np.all(np.abs(made.X - 1.0) < 0.35, axis=1)
    assert error[middle].max() < 1e-11 < error.max()


def test_a_tag_on_a_part_of_a_side_has_its_share_of_the_area():
    whole = cloud(4)
    top = whole.areas_of("Y+")
    assert top[:, 1].sum() == pytest.approx(1.0)
    assert np.all(top[whole.X[:, 1] < 0.95] == 0.0)


def test_short_axes_have_the_order_they_can_and_the_plan_says_so():
    scene = Scene("plate", Box(upper=(1.0, 1.0, 0.2)), SOLID, 0.01)
    sim = sph.Simulation(scene, spacing=0.1, operator=sph.LatticeDifference(4))
    assert "order 4 inside, but 2 along Z (3 particles)" in sim.plan()


def test_a_traction_pulls_with_its_area():
    scene = Scene(
        "pulled", Box(), SOLID, 1e-3,
        tractions=(Traction("X+", lambda X, N, t: np.tile([5.0, 0.0, 0.0], (len(X), 1))),),
    )  # fmt: skip
    sim = sph.Simulation(scene, spacing=0.125, operator=sph.LatticeDifference(4))
    sim.run()
    p = np.sum(sim.cloud.V[:, None] * sim.state.p, axis=0)
    np.testing.assert_allclose(p, [5.0 * sim.time, 0.0, 0.0], atol=1e-12)


def test_bodies_that_are_no_box_and_orders_there_are_not_are_refused():
    with pytest.raises(InputError, match="full box of lattice points"):
        sph.Simulation(
            Scene("L", L_SHAPE, SOLID, 0.01), spacing=0.25, operator=sph.LatticeDifference(4)
        )
    for wrong in (3, 4.0, True, np.True_, np.array([4, 2]), "4", None):
        with pytest.raises(InputError, match="must be 2, 4 or 6"):
            sph.LatticeDifference(wrong)
    assert sph.LatticeDifference(np.int64(4)) == sph.LatticeDifference(4)
    scene = Scene("jitter", Box(jitter=0.3), SOLID, 0.01)
    with pytest.raises(InputError, match="full box of lattice points"):
        sph.Simulation(scene, spacing=0.25, operator=sph.LatticeDifference(4))
