"""Checkpoints: bits in, bits out; whatever does not fit is refused and changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.record import march, restore, write_checkpoint
from sphsolid.record.checkpoint import read_checkpoint


@pytest.fixture
def saved(fake_solver, tmp_path):
    solver = fake_solver()
    march(solver, until=1.0 / 3.0)
    solver.x[0] = [np.nextafter(1.0, 2.0), -0.0, 5e-324]
    write_checkpoint(solver, tmp_path / "c.npz", records=7)
    return solver, tmp_path / "c.npz"


def test_the_state_comes_back_bit_for_bit(saved, fake_solver):
    solver, path = saved
    other = fake_solver()
    checkpoint = restore(other, path)
    assert (other.time, other.step) == (1.0 / 3.0, solver.step)
    assert other.x.tobytes() == solver.x.tobytes()
    assert (checkpoint.records, other.changed) == (7, 1)
    assert not list(path.parent.glob("*.part"))


def test_the_arrays_of_the_solver_stay_the_same_objects(saved, fake_solver):
    """An integrator may hold views of them."""
    other = fake_solver()
    view = other.x.reshape(-1)
    restore(other, saved[1])
    assert np.shares_memory(view, other.x)
    assert view[0] == np.nextafter(1.0, 2.0)


def refused(solver, path, match):
    before = (solver.time, solver.step, solver.x.tobytes())
    with pytest.raises(InputError, match=match):
        restore(solver, path)
    assert (solver.time, solver.step, solver.x.tobytes()) == before
    assert solver.changed == 0


def test_another_simulation_is_refused_by_name(saved, fake_solver):
    other = fake_solver()
    other.identity = lambda: {"scene": "punch", "method": "fake", "cfl": "0.3"}
    refused(other, saved[1], "cfl: nothing there, 0.3 here; scene: swinging_cube.* punch here")


@pytest.mark.parametrize(
    "arrays",
    [{"y": np.zeros((8, 3))}, {"x": np.zeros((9, 3))}, {"x": np.zeros((8, 3), dtype=np.float32)}],
)
def test_other_arrays_are_refused(saved, fake_solver, arrays):
    other = fake_solver()
    other.state_arrays = lambda: arrays
    refused(other, saved[1], "holds no array")


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.99])
def test_a_damaged_file_is_refused(saved, fake_solver, share):
    path = saved[1]
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    refused(fake_solver(), path, "not a checkpoint, or is damaged")


def test_a_flipped_bit_is_noticed(saved, fake_solver):
    path = saved[1]
    content = bytearray(path.read_bytes())
    at = bytes(content).index(np.nextafter(1.0, 2.0).tobytes())
    content[at] ^= 1
    path.write_bytes(content)
    refused(fake_solver(), path, "damaged")


def test_other_files_are_refused(saved, fake_solver, tmp_path):
    refused(fake_solver(), tmp_path / "none.npz", "there is no checkpoint")
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    refused(fake_solver(), tmp_path / "other.npz", "not a checkpoint")
    np.savez(tmp_path / "newer.npz", header=np.array('{"format": "sphsolid checkpoint 5"}'))
    refused(fake_solver(), tmp_path / "newer.npz", "format 'sphsolid checkpoint 5'")


def test_a_failed_write_leaves_the_old_file(saved, fake_solver):
    _, path = saved
    before = path.read_bytes()
    broken = fake_solver()
    broken.state_arrays = lambda: {"x": Unwritable()}
    with pytest.raises(RuntimeError, match="disk full"):
        write_checkpoint(broken, path)
    assert path.read_bytes() == before
    assert [file.name for file in path.parent.iterdir()] == ["c.npz"]
    assert read_checkpoint(path).records == 7


class Unwritable:
    """An array that cannot be written out."""

    def __array__(self, dtype=None, copy=None):
        raise RuntimeError("disk full")
