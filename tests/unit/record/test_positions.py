"""Positions are judged by neighbours and cells: what no gradient sees is found at full size."""

from __future__ import annotations

import copy
import gc
import math
import pickle
import warnings
import weakref

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from fem_reference.mesh import scikit_fem_mesh
from fem_reference.quadratic_mesh import quadratic_mesh
from sphsolid.errors import FoldingWarning
from sphsolid.geometry import Box, PointCloud, Surface, TetBox
from sphsolid.record import (
    Placement,
    Positions,
    RunFolder,
    SecondaryGradient,
    inside_out,
    inside_out_secondary,
    judge_positions,
    restore,
    unseen_motion,
    write_checkpoint,
)
from sphsolid.record.march import march
from sphsolid.record.positions import UNSEEN_LARGEST_LIMIT, UNSEEN_RMS_LIMIT
from sphsolid.record.progress import state
from sphsolid.record.turned_cells import LEAST_SHAPE
from sphsolid.scenes import twisting_column

H = 0.25
ROTATION = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
ROTATION *= np.sign(np.linalg.det(ROTATION))
SIZE = (1.0, 1.5, 0.75)


def lattice(size=SIZE, h=H, jitter=0.0, scale=1.0):
    corner = tuple(scale * length for length in size)
    return Box((0.0, 0.0, 0.0), corner, jitter=jitter).mesh(scale * h)


def points():
    """A disordered cloud on and in a box, without a mesh of its own."""
    mesh = lattice(jitter=0.4)
    inner = np.setdiff1d(np.arange(len(mesh.vertices)), np.unique(mesh.boundary))
    return PointCloud(
        mesh.vertices[inner], Surface.closed(vertices=mesh.vertices, faces=mesh.faces)
    ).mesh(sph.geometry.body.AS_MESHED)


MESHES = {
    "lattice": lattice,
    "disordered hexahedra": lambda: lattice(jitter=0.4),
    "tetrahedra": lambda: TetBox((0.0, 0.0, 0.0), SIZE).mesh(H),
    "points": points,
    "quadratic elements": lambda: quadratic_mesh(lattice(), scikit_fem_mesh(lattice())).parts,
}


@pytest.fixture(scope="module", params=MESHES)
def mesh(request):
    return MESHES[request.param]()


def placed(mesh, x):
    return Placement(0.0, mesh, x)


def number(mesh, axis, h=H):
    return np.rint(mesh.vertices[:, axis] / h).astype(int)


def saw_tooth(mesh, along, moved, size):
    """``size`` [m] up and down along one axis, in the direction ``moved``."""
    x = mesh.vertices.copy()
    x[:, moved] += size * (-1.0) ** number(mesh, along)
    return x


def test_an_affine_map_is_seen_whole(mesh):
    F = ROTATION @ (np.eye(3) + 0.8 * np.random.default_rng(1).random((3, 3)))
    there = placed(mesh, mesh.vertices @ F.T + [30.0, -2.0, 5.0])
    assert unseen_motion(there).largest < 1.0e-12
    found = inside_out(there)
    assert found.share == 0.0
    assert found.smallest == pytest.approx(np.linalg.det(F), rel=1e-9)
    assert not judge_positions(there).folded


def test_units_and_rotations_change_nothing(mesh):
    random = np.random.default_rng(5).standard_normal(mesh.vertices.shape)
    x = mesh.vertices + 0.1 * H * random
    here = judge_positions(placed(mesh, x))
    large = type(mesh)(**vars(mesh) | {"vertices": 1000.0 * mesh.vertices})
    assert here.unseen.rms > 0.05
    for there in (placed(mesh, x @ ROTATION.T), placed(large, 1000.0 * x)):
        found = judge_positions(there)
        assert found.unseen.rms == pytest.approx(here.unseen.rms, rel=1e-9)
        assert found.unseen.largest == pytest.approx(here.unseen.largest, rel=1e-9)
        assert found.cells.share == here.cells.share
        assert found.cells.smallest == pytest.approx(here.cells.smallest, rel=1e-9)


@pytest.mark.parametrize("along", [0, 1, 2])
@pytest.mark.parametrize("moved", [0, 1, 2])
def test_a_saw_tooth_counts_with_its_full_size(along, moved):
    size = 0.2 * H
    mesh = lattice()
    found = unseen_motion(placed(mesh, saw_tooth(mesh, along, moved, size)))
    # Neighbours inside differ by 2 size; one-sided gradients at the two ends see half of it.
    assert found.largest == pytest.approx(2.0 * size / H)
    cells = round(SIZE[along] / H)
    square = (2.0 * size / H) ** 2 * ((cells - 2) + 2.0 * 0.25) / cells
    assert found.rms == pytest.approx(math.sqrt(square / 3.0))


def test_a_saw_tooth_of_two_cells_across_is_seen():
    mesh = lattice(size=(2 * H, 2.0, 2 * H))
    found = judge_positions(placed(mesh, saw_tooth(mesh, 0, 1, 0.8 * H)))
    assert found.unseen.largest == pytest.approx(0.8)
    assert found.cells.smallest == pytest.approx(1.0)
    assert found.folded


def test_a_fold_that_turns_no_cell_is_found():
    """The fold of the column at nu = 0.3: moved across, no volume changes."""
    mesh = lattice()
    found = judge_positions(placed(mesh, saw_tooth(mesh, 1, 0, 0.4 * H)))
    assert found.cells.share == 0.0
    assert found.cells.smallest == pytest.approx(1.0)
    assert found.folded
    assert str(found).startswith("folded: unseen motion")


def test_a_fold_of_a_small_part_is_found():
    mesh = lattice(size=(2.0, 4.0, 2.0))
    x = saw_tooth(mesh, 1, 0, 2.0 * H)
    there = mesh.vertices[:, 1] > 0.5
    x[there] = mesh.vertices[there]
    found = judge_positions(placed(mesh, x))
    assert found.unseen.largest > UNSEEN_LARGEST_LIMIT
    assert found.folded


@pytest.mark.parametrize("kind", ["tetrahedra", "points", "quadratic elements"])
def test_random_motion_of_neighbours_is_seen_on_every_mesh(kind):
    mesh = MESHES[kind]()
    edge = mesh.spacing
    random = np.random.default_rng(5).standard_normal(mesh.vertices.shape)
    small = judge_positions(placed(mesh, mesh.vertices + 0.02 * edge * random))
    large = judge_positions(placed(mesh, mesh.vertices + 0.4 * edge * random))
    assert not small.folded
    assert large.unseen.rms > UNSEEN_RMS_LIMIT
    assert large.folded


def test_smooth_motion_is_left_out_with_second_order():
    rms = []
    for h in (0.25, 0.125):
        mesh = lattice(h=h)
        X = mesh.vertices
        x = X + 0.1 * np.stack([np.sin(2 * X[:, 1]), np.cos(2 * X[:, 2]), X[:, 0] ** 3], axis=1)
        # Inside; at the faces, where gradients are one-sided, with first order.
        rms.append(unseen_motion(placed(mesh, x)).rms)
    assert rms[0] < 0.02
    assert rms[0] / rms[1] > 2.2


def test_a_column_of_two_cells_bent_round_a_quarter_turn_is_sound():
    mesh = lattice(size=(1.0, 6.0, 1.0), h=0.5)
    X = mesh.vertices
    radius, angle = 12.0 / np.pi, X[:, 1] * np.pi / 12.0
    arm = radius - X[:, 0]
    x = np.stack([radius - arm * np.cos(angle), arm * np.sin(angle), X[:, 2]], axis=1)
    found = judge_positions(placed(mesh, x))
    assert not found.folded
    assert found.unseen.rms < 0.1


def test_one_turned_hexahedron_of_all_is_counted():
    mesh = lattice()
    cell = mesh.cells[7]
    x = mesh.vertices.copy()
    # A corner of the body that belongs to this cell alone is pushed through it.
    alone = [c for c in cell if np.sum(mesh.cells == c) == 1]
    if not alone:
        alone = [int(np.argmin(np.sum(mesh.vertices, axis=1)))]
    corner = alone[0]
    [owner] = np.flatnonzero((mesh.cells == corner).any(axis=1))
    centre = mesh.vertices[mesh.cells[owner]].mean(axis=0)
    x[corner] += 2.6 * (centre - x[corner])
    found = inside_out(placed(mesh, x))
    assert found.share == pytest.approx(1.0 / len(mesh.cells))
    assert found.smallest < 0.0
    # All of its own Gauss points but the nearest few are right: the centre alone would not tell.
    assert judge_positions(placed(mesh, x)).folded


def test_a_mirrored_body_is_inside_out_everywhere(mesh):
    there = placed(mesh, mesh.vertices * [1.0, 1.0, -1.0])
    assert inside_out(there).share == 1.0
    assert inside_out(there).smallest == pytest.approx(-1.0)
    assert unseen_motion(there).largest < 1.0e-12


def test_determinants_are_those_of_the_trilinear_map():
    mesh = lattice(jitter=0.3)
    X = mesh.vertices
    x = X + 0.2 * np.sin(3.0 * X[:, [1, 2, 0]])
    smallest = np.inf
    for point in mesh.shape.cell_rule:
        now, before = (
            np.linalg.det(np.einsum("ecd,ck->edk", y[mesh.cells], point.slopes)) for y in (x, X)
        )
        smallest = min(smallest, float(np.min(now / before)))
    assert inside_out(placed(mesh, x)).smallest == pytest.approx(smallest, rel=1e-12)


def test_slivers_do_not_decide():
    """The height of a sliver is a small part of its edges: small motion turns it."""
    X = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.33, 0.33, -0.05]], float)
    cells = np.array([[0, 1, 2, 3], [0, 2, 1, 4]])
    mesh = sph.geometry.TetMesh(X, cells, {}, 1.0, False)
    x = X.copy()
    x[4, 2] = 0.05
    assert LEAST_SHAPE == 0.5
    assert inside_out(placed(mesh, x)).share == 0.0
    x[3, 2] = -1.0
    assert inside_out(placed(mesh, x)).share == 1.0


def layers(height: float = 0.3):
    """A body of flat tetrahedra, six of each 1 x 1 x ``height`` of a cell."""
    mesh = lattice(size=(6.0, 2.0, 2.0), h=1.0)
    paths = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
    cells = np.concatenate([mesh.cells[:, path] for path in paths])
    X = mesh.vertices * [1.0, 1.0, height]
    return sph.geometry.TetMesh(X, cells, {}, 1.0, False)


@pytest.mark.parametrize("height", [0.3, 0.1])
def test_a_mesh_that_is_flat_everywhere_is_judged(height):
    mesh = layers(height)
    X = mesh.vertices
    assert inside_out(placed(mesh, X)).share == 0.0
    for turned in ([-1.0, 1.0, 1.0], [1.0, 1.0, -1.0]):
        assert judge_positions(placed(mesh, X * turned)).folded
    assert inside_out(placed(mesh, X * [1.0, 1.0, 0.0])).share == 1.0
    x = X.copy()
    # The last plane of points goes through the one before it.
    x[X[:, 0] == 6.0, 0] -= 1.3
    assert judge_positions(placed(mesh, x)).folded


def test_points_that_are_no_particles_are_judged_too():
    mesh = lattice()
    F = np.stack([np.eye(3), np.diag([1.0, 1.0, -0.5]), np.eye(3), np.eye(3)])
    there = Placement(0.0, mesh, mesh.vertices, SecondaryGradient(np.zeros((4, 3)), F))
    assert inside_out_secondary(there).share == 0.25
    assert inside_out_secondary(there).smallest == -0.5
    assert "25 % of the secondary particles" in str(judge_positions(there))
    assert inside_out_secondary(placed(mesh, mesh.vertices)).share == 0.0


def test_what_is_known_of_a_mesh_does_not_keep_it_alive():
    mesh = lattice()
    judge_positions(placed(mesh, mesh.vertices))
    gone = weakref.ref(mesh)
    del mesh
    gc.collect()
    assert gone() is None


# In a run.


def folding(fake_solver, *, at=0.2, until=1.0):
    """A solver whose only cell is inside out between two times."""

    class Folding(fake_solver):
        def placement(self):
            there = super().placement()
            turned = at <= self.time < until
            return Placement(self.time, there.mesh, there.x * [1, 1, -1 if turned else 1])

    return Folding(dt=lambda t: 0.01)


def warned(run):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run()
    return [str(each.message) for each in caught if each.category is FoldingWarning]


def test_a_run_warns_once_and_goes_on(fake_solver):
    solver = folding(fake_solver)
    [said] = warned(lambda: march(solver, until=0.5))
    assert solver.time == 0.5
    assert "found at t = 0.2 s" in said
    assert solver.positions.folded_since == pytest.approx(0.2)
    # It goes on, and says it once more.
    assert len(warned(lambda: march(solver, until=0.6))) == 1
    assert solver.positions.folded_since == pytest.approx(0.2)


def test_it_is_the_line_that_called_run_which_is_warned_of(fake_solver):
    solver = folding(fake_solver)
    with pytest.warns(FoldingWarning) as caught:
        march(solver, until=0.5)
    assert caught[0].filename == __file__


def test_a_sound_run_says_nothing(fake_solver):
    assert warned(lambda: march(fake_solver(), until=0.5)) == []


def test_a_fold_that_comes_undone_is_remembered(fake_solver):
    solver = folding(fake_solver, until=0.4)
    assert len(warned(lambda: march(solver, until=0.5))) == 1
    assert "were folded at t = 0.2 s, are not now" in solver.positions.line(solver.placement())


def test_a_solver_that_was_put_back_forgets(fake_solver):
    solver = folding(fake_solver)
    warned(lambda: march(solver, until=0.5))
    solver.time = 0.1
    assert "positions: sound" in solver.positions.line(solver.placement())


def test_progress_and_run_json_say_it(fake_solver, tmp_path):
    solver = folding(fake_solver)
    told = []
    warned(
        lambda: march(
            solver, until=0.5, every=0.1, progress=told.append, output=RunFolder(tmp_path / "run")
        )
    )
    assert math.isnan(told[0].folded_since)
    assert told[-1].folded_since == pytest.approx(0.2)
    text = (tmp_path / "run" / "run.json").read_text()
    assert '"verdict": "folded: 100 % of the cells are inside out' in text
    assert '"folded_since_s": 0.2' in text
    assert "positions folded since t = 0.2 s" in state(told[-1])
    assert "folded" not in state(told[0])


def test_a_resumed_run_says_it_again_and_only_once(fake_solver, tmp_path):
    folder = tmp_path / "run"
    first = folding(fake_solver)
    warned(lambda: march(first, until=0.3, every=0.1, output=RunFolder(folder)))
    again = folding(fake_solver)
    said = warned(
        lambda: march(again, until=0.5, every=0.1, output=RunFolder(folder, resume=True))
    )
    assert len(said) == 1
    assert "found at t = 0.3 s" in said[0]


def column(solver=sph, spacing=1 / 2, **scene):
    supg = {} if solver is fem else {"formulation": sph.PF()}
    return solver.Simulation(twisting_column(**scene), spacing=spacing, **supg)


@pytest.mark.parametrize("solver", [sph, fem])
def test_looking_changes_no_bit(solver):
    ends = []
    for every in (1, 10**9):
        sim = column(solver, end_time=0.01)
        sim.positions.every = every
        sim.run()
        ends.append({name: array.copy() for name, array in sim.state_arrays().items()})
    for name, array in ends[0].items():
        assert np.array_equal(array, ends[1][name]), name


@pytest.mark.parametrize("solver", [sph, fem])
def test_a_sound_run_says_so_in_its_summary_and_columns(solver):
    sim = column(solver, end_time=0.01)
    history = sim.run(record=[Positions()])
    assert "positions: sound; unseen motion 0.0" in sim.summary()
    assert history["inside_out_share [-]"][-1] == 0.0
    assert 0.8 < history["smallest_det [-]"][-1] < 1.2
    assert 0.0 < history["unseen_rms [-]"][-1] < history["unseen_max [-]"][-1] < 0.1
    has_secondary = "secondary_smallest_det [-]" in history.table
    assert has_secondary == (solver is sph)


def test_the_secondary_gradient_is_that_of_the_sampling():
    sim = column(end_time=0.01)
    sim.run()
    shot, (pairs, sample) = sim.snapshot(), (sim.secondary.pairs, sim.secondary.sample)
    F = np.zeros((len(sim.secondary.X), 3, 3))
    np.add.at(F, pairs.row_of_pair, shot.x[pairs.indices][:, :, None] * sample[:, None, :3])
    assert np.allclose(shot.secondary.F, F, rtol=0.0, atol=1e-12)


def test_the_column_at_nu_03_folds_and_says_so_unwatched():
    """nu 0.35 on 1/4, a kin of the known ones: SUPG folds it, B-bar and our default do not."""
    sim = column(spacing=1 / 4, poisson_ratio=0.35, end_time=0.14)
    [said] = warned(sim.run)
    assert "the positions have folded" in said
    assert "positions: folded since t = " in sim.summary()
    scene = twisting_column(poisson_ratio=0.35, end_time=0.14)
    for solver in (fem, sph):
        fine = solver.Simulation(scene, spacing=1 / 4)
        assert warned(fine.run) == []
        assert "positions: sound" in fine.summary()


def test_since_when_they_are_folded_goes_on_from_a_checkpoint(fake_solver, tmp_path):
    first = folding(fake_solver)
    warned(lambda: march(first, until=0.5, every=0.1, output=RunFolder(tmp_path / "run")))
    other = folding(fake_solver)
    goes_on = RunFolder(tmp_path / "run", resume=True)
    warned(lambda: march(other, until=0.6, every=0.1, output=goes_on))
    assert other.positions.folded_since == first.positions.folded_since == pytest.approx(0.2)


def test_a_checkpoint_of_sound_positions_forgets_a_fold(fake_solver, tmp_path):
    sound, other = fake_solver(), fake_solver()
    write_checkpoint(sound, tmp_path / "c.npz")
    other.positions.folded_since = 0.7
    restore(other, tmp_path / "c.npz")
    assert math.isnan(other.positions.folded_since)


def test_a_copy_of_finite_elements_remembers_it_too():
    sim = fem.Simulation(twisting_column(), spacing=0.5)
    sim.positions.folded_since = 0.25
    assert copy.deepcopy(sim).positions.folded_since == 0.25
    assert pickle.loads(pickle.dumps(sim)).positions.folded_since == 0.25
