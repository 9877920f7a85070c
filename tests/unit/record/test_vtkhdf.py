"""One VTKHDF file a run, read back by VTK: names, components, units, times and values."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.record import Every, Never, RunFolder, march
from sphsolid.record.vtkhdf import AT_POINTS, OF_LAW, VtkHdfFile, expected_records, steps_of
from tests.oracles.blocks import loaded_block

FIELDS = {each.name: each for each in (*AT_POINTS, *OF_LAW)}


class Snapshots:
    """A recorder that keeps what it is shown."""

    def __init__(self) -> None:
        self.seen: list[Any] = []

    def record(self, snapshot, scene):
        self.seen.append(snapshot)
        return {}


def read_by_vtk(path: Path, step: int) -> tuple[Any, int, list[float]]:
    """The grid of a record, how many there are, and their times."""
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    reader.SetStep(step)
    reader.Update()
    key = reader.GetExecutive().TIME_STEPS()
    times = list(reader.GetOutputInformation(0).Get(key) or [])
    return reader.GetOutputDataObject(0), reader.GetNumberOfSteps(), times


def arrays(data: Any) -> dict[str, Any]:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return {
        data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)).copy()
        for k in range(data.GetNumberOfArrays())
    }


def simulations() -> dict[str, Any]:
    scene = loaded_block()
    return {
        "sph": lambda: sph.Simulation(scene, spacing=0.5),
        "fem": lambda: fem.Simulation(scene, spacing=0.5),
    }


@pytest.mark.parametrize("method", ["sph", "fem"])
def test_vtk_reads_what_was_recorded(method, tmp_path):
    simulation, recorder = simulations()[method](), Snapshots()
    step = simulation.stable_time_step()
    simulation.run(until=4 * step, every=step, record=[recorder], output=RunFolder(tmp_path))
    path = tmp_path / "run.vtkhdf"
    for k, snapshot in enumerate(recorder.seen):
        grid, count, times = read_by_vtk(path, k)
        assert grid.GetClassName() == "vtkUnstructuredGrid"
        assert count == len(recorder.seen) == 5
        assert times == [each.time for each in recorder.seen]
        assert grid.GetNumberOfPoints() == len(snapshot.X)
        assert grid.GetNumberOfCells() == len(snapshot.mesh.cells)
        for c, wanted in enumerate(snapshot.mesh.cells.tolist()):
            # One object for all cells.
            cell = grid.GetCell(c)
            assert cell.GetClassName() == "vtkHexahedron"
            assert [cell.GetPointId(i) for i in range(8)] == wanted
        from vtkmodules.util.numpy_support import vtk_to_numpy

        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), snapshot.x)
        at_points, in_cells = arrays(grid.GetPointData()), arrays(grid.GetCellData())
        np.testing.assert_array_equal(at_points.pop("X"), snapshot.X)
        found = at_points | in_cells
        assert set(found) == set(FIELDS)
        law = {each.name for each in OF_LAW}
        assert set(in_cells) == (law if method == "fem" else set())
        for name, values in found.items():
            each = FIELDS[name]
            wanted = snapshot.field(each.field).values.astype(np.float32)
            np.testing.assert_array_equal(values, wanted.reshape(values.shape), err_msg=name)
            assert values.shape[1:] == (() if each.width == 1 else (each.width,))


def test_the_vtu_files_hold_the_same(tmp_path):
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    simulation = simulations()["sph"]()
    simulation.run(until=3 * simulation.stable_time_step(), output=RunFolder(tmp_path))
    grid = read_by_vtk(tmp_path / "run.vtkhdf", 1)[0]
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "frames" / "frame_000001.vtu"))
    reader.Update()
    frame = arrays(reader.GetOutput().GetPointData())
    for name, values in arrays(grid.GetPointData()).items():
        short = FIELDS[name].field if name in FIELDS else name
        np.testing.assert_array_equal(values, frame[short], err_msg=name)


def run(solver, folder, *, until, **options):
    return march(solver, until=until, every=0.1, output=RunFolder(folder, **options))


def test_units_and_meaning_are_attributes(fake_solver, tmp_path):
    run(fake_solver(), tmp_path, until=0.3)
    with h5py.File(tmp_path / "run.vtkhdf") as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"UnstructuredGrid"
        assert root.attrs["Version"].tolist() == [2, 0]
        for each in (*AT_POINTS, *OF_LAW):
            assert root[f"PointData/{each.name}"].attrs["units"].decode() == each.unit
        assert root["PointData/cauchy_stress"].attrs["units"] == b"Pa"
        assert "pressure_positive_in_tension" in root["PointData"]
        # The mesh once, whatever the number of records.
        assert root["Connectivity"].shape == (8,)
        assert root["PointData/X"].shape == (8, 3)
        assert root["Steps/Values"].attrs["units"] == b"s"


def test_the_file_has_no_room_that_was_not_used(fake_solver, tmp_path):
    run(fake_solver(), tmp_path, until=0.3)
    with h5py.File(tmp_path / "run.vtkhdf") as file:
        assert file["VTKHDF/Points"].shape == (4 * 8, 3)
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 4


def test_frames_of_the_one_file_can_be_fewer_or_none(fake_solver, tmp_path):
    run(fake_solver(), tmp_path / "a", until=0.5, vtkhdf=Every(records=2))
    times = [time for time, _ in steps_of(tmp_path / "a" / "run.vtkhdf")]
    assert times == pytest.approx([0.0, 0.2, 0.4, 0.5])
    run(fake_solver(), tmp_path / "b", until=0.5, vtkhdf=Never())
    assert not (tmp_path / "b" / "run.vtkhdf").exists()


def test_more_records_than_foreseen_find_room(fake_solver, tmp_path):
    solver, path = fake_solver(), tmp_path / "run.vtkhdf"
    file = VtkHdfFile(path, expected=2)
    wanted = []
    for _ in range(21):
        file.append(solver.snapshot())
        wanted.append((solver.time, solver.step))
        assert steps_of(path) == wanted
        solver.advance(0.1)
    file.close()
    assert steps_of(path) == wanted
    assert read_by_vtk(path, 20)[1] == 21


def test_records_after_the_one_to_go_on_from_are_dropped(fake_solver, tmp_path):
    run(fake_solver(), tmp_path, until=0.5)
    path = tmp_path / "run.vtkhdf"
    solver = fake_solver()
    solver.advance(0.25)
    file = VtkHdfFile(path, expected=9, until_kept=0.2000001)
    file.append(solver.snapshot())
    file.close()
    assert [t for t, _ in steps_of(path)] == pytest.approx([0.0, 0.1, 0.2, 0.25])


@pytest.mark.parametrize("stop", ["write", "count", "copy"])
def test_a_kill_within_a_record_leaves_the_records_before_it(
    stop, fake_solver, tmp_path, monkeypatch
):
    """Wherever a record is cut off, VTK reads those that were complete."""
    from sphsolid.record import vtkhdf

    class Killed(BaseException):
        pass

    solver, path = fake_solver(), tmp_path / "run.vtkhdf"
    file = VtkHdfFile(path, expected=8)
    for _ in range(8):
        file.append(solver.snapshot())
        solver.advance(0.1)
    kept = steps_of(path)

    def put(array, values, record):
        # Half of a field, then nothing more.
        original(array, values, record)
        if array.name.endswith("momentum"):
            raise Killed

    original = vtkhdf._put

    def killed(*_, **__):
        raise Killed

    if stop == "write":
        monkeypatch.setattr(vtkhdf, "_put", put)
    elif stop == "count":
        monkeypatch.setattr(vtkhdf, "_say_count", killed)
    else:
        monkeypatch.setattr(vtkhdf, "_copy", killed)
    with pytest.raises(Killed):
        file.append(solver.snapshot())
    assert steps_of(path) == kept
    assert read_by_vtk(path, 7)[1] == 8


def test_a_reader_that_holds_the_file_open_stops_nothing(fake_solver, tmp_path):
    solver, path = fake_solver(), tmp_path / "run.vtkhdf"
    file = VtkHdfFile(path, expected=8)
    file.append(solver.snapshot())
    # In a process of its own, as ParaView is, with HDF5's locks as they are by default.
    reading = (
        "import h5py, sys; file = h5py.File(sys.argv[1], 'r'); print('open', flush=True); "
        "sys.stdin.read()"
    )
    reader = subprocess.Popen(
        [sys.executable, "-c", reading, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert reader.stdout is not None
    assert reader.stdout.readline().strip() == b"open"
    solver.advance(0.1)
    file.append(solver.snapshot())
    reader.communicate()
    assert len(steps_of(path)) == 2


def test_records_that_are_foreseen():
    assert expected_records(0.0, 1.0, None, already=0) == 2
    assert expected_records(0.0, 1.0, 0.1, already=0) >= 11
    assert expected_records(0.5, 1.0, 0.1, already=6) >= 11


KILLED = """
import sys
from pathlib import Path
from sphsolid.record.vtkhdf import VtkHdfFile
sys.path.insert(0, sys.argv[2])
from tests.unit.record.conftest import FakeSolver
solver = FakeSolver()
file = VtkHdfFile(Path(sys.argv[1]), expected=8)
print("begun", flush=True)
while True:
    file.append(solver.snapshot())
    solver.advance(0.1)
"""


def test_killed_processes_leave_files_that_can_be_read(tmp_path):
    """At moments that nobody chose; each record's fields are of its time."""
    root = Path(__file__).resolve().parents[3]
    random = np.random.default_rng(0)
    for k in range(3):
        path = tmp_path / f"{k}.vtkhdf"
        process = subprocess.Popen(
            [sys.executable, "-c", KILLED, str(path), str(root)], stdout=subprocess.PIPE
        )
        assert process.stdout is not None
        process.stdout.readline()
        while not path.exists():
            time.sleep(1e-3)
        time.sleep(random.uniform(0.0, 0.5))
        process.kill()
        process.communicate()
        found = steps_of(path)
        assert [step for _, step in found] == list(range(len(found)))
        grid, count, _ = read_by_vtk(path, len(found) - 1)
        assert count - len(found) in (0, 1)
        speed = arrays(grid.GetPointData())["velocity"]
        np.testing.assert_array_equal(speed, np.float32(found[-1][0]))
