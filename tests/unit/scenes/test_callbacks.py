"""The door through which a scene's functions are asked."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import Diverged, InputError
from sphsolid.geometry import Box
from sphsolid.record.norms import instant_errors
from sphsolid.scenes import cable
from sphsolid.scenes.callbacks import asked
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene, Traction
from tests.unit.record.conftest import snapshot_of

RUBBER = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)
X = np.arange(12.0).reshape(4, 3)
N = np.ones((4, 3))


def scene(**parts):
    given = {"constraints": (Constraint("Z-", "all"),), **parts}
    return Scene(name="s", body=Box(), material=RUBBER, end_time=0.01, **given)


def shifts(X, *others):
    X -= [0.5, 0.5, 0.0]
    return 0.0 * X


def scales(X, *others):
    np.multiply(X, 2.0, out=X)
    return X


def zeroes(X, *others):
    X[:, 0] = 0.0
    return X


@pytest.mark.parametrize("change", [shifts, scales, zeroes])
def test_positions_cannot_be_changed(change):
    given = X.copy()
    with pytest.raises(InputError, match=r"^it must not change X in place.*X = X - c"):
        asked(change, given, what="it")
    np.testing.assert_array_equal(given, X)


def test_normals_cannot_be_changed():
    def turned(X, N, t):
        N *= -1.0
        return N

    with pytest.raises(InputError, match=r"traction on Z\+ must not change"):
        Traction("Z+", turned).at(X, N, 0.0)
    np.testing.assert_array_equal(N, 1.0)


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
@pytest.mark.parametrize(
    ("parts", "named"),
    [
        ({"initial_displacement": scales}, "initial_displacement"),
        ({"initial_velocity": shifts}, "initial_velocity"),
        ({"constraints": (Constraint("Z+", "all", zeroes),)}, r"prescribed velocity on Z\+"),
        ({"tractions": (Traction("X+", shifts),)}, r"traction on X\+"),
        ({"body_force": scales}, "body force"),
    ],
)
def test_both_solvers_use_the_door(solver, parts, named):
    with pytest.raises(InputError, match=f"{named} must not change X"):
        solver(scene(**parts), spacing=0.5)


def test_the_stated_strain_goes_through_it_too():
    with pytest.raises(InputError, match=r"initial_deformation_gradient returned .*\(4, 3, 3\)"):
        scene(initial_deformation_gradient=lambda X: X).stated_deformation(X)
    with pytest.raises(InputError, match="initial_deformation_gradient must not change"):
        scene(initial_deformation_gradient=scales).stated_deformation(X)


BAD = {
    "scalar": -1e4,
    "numpy scalar": np.float64(1.0),
    "one column": np.ones((4, 1)),
    "one number a point": np.ones(4),
    "one vector": np.ones(3),
    "transposed": np.ones((3, 4)),
    "too many points": np.ones((5, 3)),
    "tensors": np.ones((4, 3, 3)),
    "nothing": None,
    "text": "abc",
    "ragged": [[1.0], [1.0, 2.0]],
    "truth": np.ones((4, 3), dtype=bool),
    "complex": np.ones((4, 3), dtype=complex),
    "objects": np.full((4, 3), None),
}


@pytest.mark.parametrize("value", BAD.values(), ids=BAD)
def test_exactly_a_vector_a_point_comes_back(value):
    with pytest.raises(InputError, match=r"traction on Z\+ at t = 0.25 s returned"):
        Traction("Z+", lambda X, N, t: value).at(X, N, 0.25)


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
@pytest.mark.parametrize("value", [-1e4, [1.0, 2.0, 3.0]])
def test_a_bad_load_is_refused_before_the_first_step(solver, value):
    for parts in (
        {"tractions": (Traction("X+", lambda X, N, t: value),)},
        {"body_force": lambda X, t: value},
        {"constraints": (Constraint("Z+", "normal", lambda X, t: value),)},
    ):
        with pytest.raises(InputError, match=r"returned .* of shape .*wanted is an array"):
            solver(scene(**parts), spacing=0.5)


@pytest.mark.parametrize(
    "value", [X.tolist(), X.astype(np.float32), X.astype(int), np.asfortranarray(X)]
)
def test_any_array_of_numbers_of_that_shape_is_taken(value):
    found = asked(lambda X: value, X, what="it")
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, X)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_named_with_its_time_and_place(bad):
    def late(X, N, t):
        return np.where(X > 8.0, bad if t > 0.5 else 0.0, 0.0)

    load = Traction("Z+", late)
    load.at(X, N, 0.5)
    named = r"traction on Z\+ at t = 0.75 s is not finite at 1 of 4 .*X = \[9.0, 10.0, 11.0\]"
    with pytest.raises(InputError, match=named):
        load.at(X, N, 0.75)


def test_masked_values_are_not_finite():
    with pytest.raises(InputError, match="not finite at 2 of 4"):
        asked(lambda X: np.ma.masked_greater(X, 6.0), X, what="it")


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_a_load_that_is_lost_on_the_way_is_named_not_called_diverged(solver):
    def late(X, N, t):
        return np.full_like(X, np.nan if t > 1e-3 else 0.0)

    sim = solver(scene(tractions=(Traction("X+", late),)), spacing=0.5)
    with pytest.raises(InputError, match=r"traction on X\+ at t = .* s is not finite"):
        sim.run()


def test_a_function_may_write_to_its_own_array_later():
    kept = np.zeros((4, 3))

    def same(X, t):
        kept[:] = t
        return kept

    first = asked(same, X, what="it", t=1.0)
    asked(same, X, what="it", t=2.0)
    np.testing.assert_array_equal(first, 1.0)


def test_a_failing_function_is_named_and_its_traceback_kept():
    with pytest.raises(InputError, match=r"it raised ZeroDivisionError at t = 2 s: ") as failure:
        asked(lambda X, t: 1 // 0, X, what="it", t=2.0)
    assert isinstance(failure.value.__cause__, ZeroDivisionError)
    with pytest.raises(InputError, match=r"TypeError.*it is called with \(X, t\)"):
        asked(lambda X: X, X, what="it", t=2.0)


@pytest.mark.parametrize("end", [KeyboardInterrupt(), Diverged("r", 0.0, 0, 0, (0, 0, 0), "a")])
def test_what_is_meant_to_end_a_run_goes_through(end):
    def stop(X):
        raise end

    with pytest.raises(type(end)):
        asked(stop, X, what="it")


def test_exact_solutions_are_asked_through_it():
    class Wrong:
        momentum_scale = stress_scale = 1.0

        def velocity(self, X, t):
            return np.zeros(len(X))

    snapshot = snapshot_of(X, np.ones(4), np.zeros((4, 3)))
    with pytest.raises(InputError, match="velocity of the exact solution at t = 0 s returned"):
        instant_errors(snapshot, Wrong())


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_a_snapshot_hands_out_nothing_that_could_break_the_run(solver):
    sim = solver(cable(), spacing=1.0)
    seen = sim.snapshot()
    assert sim.snapshot().mesh is seen.mesh
    mesh = seen.mesh
    fields = [getattr(seen, each.name) for each in dataclasses.fields(seen)]
    arrays = [field for field in fields if isinstance(field, np.ndarray)]
    assert len(arrays) == 10
    for array in (*arrays, mesh.vertices, mesh.cells, mesh.face("X+")):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
