"""Everything that a simulation offers, with quadratic elements."""

from pathlib import Path

import meshio
import numba
import numpy as np
import pytest

import fem_reference as fem
from fem_reference.loads import loads_of, nodal_force
from fem_reference.mesh import scikit_fem_mesh
from sphsolid.compiled import set_threads, threads
from sphsolid.continuum import NeoHookean
from sphsolid.errors import Diverged, InputError
from sphsolid.record import EnergyBudget, MomentumDrift, Probe, RunFolder, Snapshot
from sphsolid.scenes import Box, Constraint, Scene, Traction, swinging_cube
from tests.oracles.blocks import (
    FACES,
    held_in_loaded_block,
    loaded_block,
    velocity_in_loaded_block,
)

MATERIAL = NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.3, density=1000.0)


def loaded() -> fem.Simulation:
    return fem.Simulation(loaded_block(), spacing=0.125, element=fem.TaylorHoodHex())


def test_spacing_is_the_distance_of_nodes() -> None:
    quadratic = fem.Simulation(swinging_cube(), spacing=0.125, element=fem.TaylorHoodHex())
    linear = fem.Simulation(swinging_cube(), spacing=0.125)
    one, other = quadratic.snapshot(), linear.snapshot()
    assert len(one.X) == len(other.X) == 9**3
    assert one.mesh.spacing == other.mesh.spacing
    assert len(one.mesh.cells) == len(other.mesh.cells) == linear.elements == 8**3
    assert quadratic.elements == 4**3
    assert quadratic.name == "swinging_cube_fem_taylor_hood_hex"
    plan = quadratic.plan()
    for words in ("64 Q2-Q1 (Taylor-Hood) equal bricks", "two spacings wide", "729, lumped mass"):
        assert words in plan
    quadratic.advance(1e-6)
    assert "64 elements, 729 nodes" in quadratic.summary()
    with pytest.raises(InputError, match=r"TaylorHoodHex\(\)"):
        fem.Simulation(swinging_cube(), spacing=0.5, element="quadratic")  # type: ignore[arg-type]


@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_loads_on_27_nodes_have_exact_resultants_and_moments(jitter: float) -> None:
    def weight(X, t):
        return np.stack([3.0 * t + 0.0 * X[:, 0], X[:, 1], X[:, 0] * X[:, 2]], axis=1)

    body = Box(upper=(1.0, 2.0, 0.5), jitter=jitter, seed=2)
    pull = Traction("Z+", lambda X, N, t: np.outer(t * X[:, 0] ** 2, [0.0, 0.0, 1.0]))
    scene = Scene("pulled", body, MATERIAL, 1.0, tractions=(pull,), body_force=weight)
    mesh = body.mesh(0.5)
    sk = scikit_fem_mesh(mesh)
    elements = fem.TaylorHoodHex().discretise(mesh=mesh, sk=sk, material=MATERIAL)
    X = elements.mesh.vertices
    volume, face = (
        nodal_force((load,), 2.0, len(X)) for load in loads_of(scene, sk, elements.load_shapes)
    )
    # 3x3x3 points integrate degree 5 per direction: quartics on bricks; cubic with the volume
    # element of a trilinear map.  The shapes reproduce X everywhere.
    quartic = 1e-12 if jitter == 0.0 else 1e-4
    np.testing.assert_allclose(volume.sum(axis=0), [6.0, 1.0, 0.125], rtol=1e-12)
    np.testing.assert_allclose(X[:, 1] @ volume[:, 1], 0.5 * 8.0 / 3.0, rtol=1e-12)
    np.testing.assert_allclose(face.sum(axis=0), [0.0, 0.0, 4.0 / 3.0], rtol=quartic)
    np.testing.assert_allclose(X[:, 0] @ face[:, 2], 2.0 * 2.0 / 4.0, rtol=quartic)
    top = elements.mesh.face_particles("Z+")
    assert np.abs(np.delete(face, top, axis=0)).max() == 0.0
    if jitter == 0.0:
        # Quadratic moments of a uniform pull: Simpson's rule on every face.
        uniform = Traction("Z+", lambda X, N, t: N)
        scene = Scene("even", body, MATERIAL, 1.0, tractions=(uniform,))
        even = nodal_force(loads_of(scene, sk, elements.load_shapes), 0.0, len(X))
        assert sorted(set(np.round(even[top, 2] / (0.25 / 36.0)).astype(int))) == [
            1, 2, 4, 8, 16,
        ]  # fmt: skip


def test_constraints_hold_exactly() -> None:
    sim = loaded()
    for _ in range(20):
        sim.advance(sim.stable_time_step())
    end = sim.snapshot()
    held = held_in_loaded_block(end.X)
    assert held.sum() > 100
    expected = velocity_in_loaded_block(end.X, sim.time)
    np.testing.assert_allclose(end.velocity[held], expected[held], rtol=1e-13, atol=1e-13)


def test_the_account_closes_with_second_order() -> None:
    left = []
    for steps in (120, 240):
        sim = loaded()
        sim.track_budget()
        for _ in range(steps):
            sim.advance(6e-4 / steps)
        end = sim.snapshot()
        row = EnergyBudget().record(end, sim.scene)
        left.append(abs(row["energy_rest [J]"]))
        drift = MomentumDrift().record(end, sim.scene)
        assert drift["linear_drift [kg m/s]"] < 1e-12 * drift["linear_scale [kg m/s]"]
        assert drift["angular_drift [kg m^2/s]"] < 1e-12 * drift["angular_scale [kg m^2/s]"]
    assert left[1] < 1e-3 * sum(abs(work) for work in end.budget.works.values())
    assert np.log2(left[0] / left[1]) > 1.8


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_a_resumed_run_has_the_bits_of_a_whole_one(jitter: float, tmp_path: Path) -> None:
    def make() -> fem.Simulation:
        scene = loaded_block(jitter=jitter)
        return fem.Simulation(scene, spacing=0.2, element=fem.TaylorHoodHex())

    whole, first, second = make(), make(), make()
    gap = 3.3 * whole.stable_time_step()
    record = [EnergyBudget(), MomentumDrift()]

    def run(sim: fem.Simulation, records: int, folder: Path, **options: bool) -> None:
        output = RunFolder(folder, **options)
        sim.run(until=records * gap, every=gap, record=record, output=output)

    run(whole, 4, tmp_path / "whole")
    run(first, 2, tmp_path / "parts")
    run(second, 4, tmp_path / "parts", resume=True)
    for name, array in whole.state_arrays().items():
        assert array.tobytes() == second.state_arrays()[name].tobytes(), name
    assert whole.snapshot().P.tobytes() == second.snapshot().P.tobytes()
    other = fem.Simulation(
        loaded_block(jitter=jitter), spacing=0.2, element=fem.TaylorHoodHex(fem.LumpedMass())
    )
    with pytest.raises(InputError, match="element"):
        other.run(until=5 * gap, every=gap, output=RunFolder(tmp_path / "parts", resume=True))


def test_a_file_holds_all_nodes_and_stresses_of_the_eighths(tmp_path: Path) -> None:
    scene = swinging_cube(amplitude=0.02)
    sim = fem.Simulation(scene, spacing=0.25, element=fem.TaylorHoodHex())
    history = sim.run(until=1e-3, every=5e-4, record=[Probe("corner")])
    assert len(history.table) == 3
    now = sim.snapshot()
    assert now.V.sum() == pytest.approx(1.0, rel=1e-14)
    assert now.stress_V.sum() == pytest.approx(1.0, rel=1e-14)
    sim.save(tmp_path / "cube.vtu")
    read = meshio.read(tmp_path / "cube.vtu")
    assert len(read.points) == 5**3
    assert len(read.cells_dict["hexahedron"]) == 4**3
    np.testing.assert_allclose(read.points, now.x, atol=1e-6)
    np.testing.assert_allclose(read.point_data["v"], now.velocity, rtol=1e-6)
    np.testing.assert_allclose(read.cell_data["J"][0], now.J, rtol=1e-6)
    centres = now.mesh.vertices[now.mesh.cells].mean(axis=1)
    np.testing.assert_allclose(now.stress_X, centres)


def test_divergence_names_the_element() -> None:
    scene = swinging_cube(amplitude=1e-2)
    sim = fem.Simulation(scene, spacing=0.25, element=fem.TaylorHoodHex())
    dt = 10.0 * sim.stable_time_step()

    def explode() -> None:
        for _ in range(100):
            sim.advance(dt)

    with pytest.raises(Diverged, match="inside out") as caught:
        explode()
    assert caught.value.step == sim.step > 0
    assert 0 <= caught.value.particle < 8
    # The centre of one of the eight elements.
    assert set(np.abs(np.array(caught.value.position) - 0.5)) == {0.25}
    folded = Scene("folded", Box(), MATERIAL, 1.0, initial_displacement=lambda X: -2.0 * X)
    with pytest.raises(InputError, match="inside out"):
        fem.Simulation(folded, spacing=0.25, element=fem.TaylorHoodHex())


def test_prescribed_motion_is_followed_exactly() -> None:
    drive = Constraint("X+", "all", lambda X, t: np.tile([4.0 * t, 0.0, 0.0], (len(X), 1)))
    scene = Scene("pulled", Box(), MATERIAL, 1e-2, constraints=(Constraint("X-", "all"), drive))
    sim = fem.Simulation(scene, spacing=0.125, element=fem.TaylorHoodHex())
    sim.run()
    end = sim.snapshot()
    right, left = end.X[:, 0] == 1.0, end.X[:, 0] == 0.0
    assert right.sum() == left.sum() == 81
    np.testing.assert_allclose(end.displacement[right, 0], 2.0 * 1e-4, rtol=1e-11)
    assert np.all(end.displacement[right, 1:] == 0.0)
    assert np.all(end.displacement[left] == 0.0)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one thread only")
@pytest.mark.parametrize(
    ("jitter", "element"),
    [(0.0, fem.TaylorHoodHex()), (0.3, fem.TaylorHoodHex()),
     (0.3, fem.TaylorHoodHex(fem.LumpedMass()))],
)  # fmt: skip
def test_bits_do_not_depend_on_the_number_of_threads(
    jitter: float, element: fem.TaylorHoodHex
) -> None:
    def run() -> Snapshot:
        scene = swinging_cube(amplitude=0.02, manufactured=True, jitter=jitter)
        sim = fem.Simulation(scene, spacing=1.0 / 12.0, element=element)
        for _ in range(10):
            sim.advance(sim.stable_time_step())
        return sim.snapshot()

    before = threads()
    try:
        set_threads(1)
        one = run()
        set_threads(2)
        two = run()
    finally:
        set_threads(before)
    for name in ("x", "velocity", "F", "J", "P"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert one.strain_energy == two.strain_energy
    assert one.time == two.time


def test_every_face_of_the_body_is_found() -> None:
    sim = loaded()
    mesh = sim.snapshot().mesh
    assert set(FACES) <= set(mesh.faces)
