"""One VTKHDF file a run: a temporal unstructured grid that ParaView 5.12 and later opens.

The mesh stands in the file once.  Positions and fields of all records follow each other in arrays
with one part a record, and ``Steps`` says where each record begins.

A kill at any moment leaves it readable.  The arrays have room for records that are still to come,
so a record moves nothing in the file: its values are written into their places first, then the
number of records, then the length of the list of times, each by one write of a few bytes.  The
list comes last because VTK reads all of it into room for so many records; a kill between the two
leaves the last record there with a time of zero.  When the room is full the file is copied to one
with twice the room, which takes its place when it is complete; at the end of a run what was not
used is cut off.  Room that is not used takes no space on a disk that knows sparse files.

HDF5 is used through h5py, without its locks: a reader never stops the run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import HEXAHEDRON
from sphsolid.record.atomic import atomic
from sphsolid.record.snapshot import Snapshot

#: Name of the group and of the format.
GROUP = "VTKHDF"
_VERSION = (2, 0)
_VTK_HEXAHEDRON, _VTK_TETRA = 12, 10
#: Room for so many records at first, at least, and at most so many bytes of it.
_LEAST, _MOST = 8, 2**30


@dataclass(frozen=True)
class Stored:
    """A field of the file: its name there, what it is of a snapshot, components and unit."""

    name: str
    field: str
    width: int
    unit: str
    says: str


#: At the points of the mesh.
AT_POINTS = (
    Stored("displacement", "u", 3, "m", "x - X"),
    Stored("velocity", "v", 3, "m/s", "dx/dt"),
    Stored("momentum", "p", 3, "kg/(m^2 s)", "rho0 v, of a volume of the undeformed body"),
)
#: Where the method evaluates the law: at the points for particles, in the cells for elements.
OF_LAW = (
    Stored("deformation_gradient", "F", 9, "1", "F, row by row"),
    Stored("J", "J", 1, "1", "volume over that of the undeformed body"),
    Stored("cauchy_stress", "cauchy", 9, "Pa", "row by row, positive in tension"),
    Stored("pressure_positive_in_tension", "pressure", 1, "Pa", "the pressure that acts"),
    Stored("von_mises_stress", "von_mises", 1, "Pa", "sqrt(3/2 s:s)"),
)


def stored_of(snapshot: Snapshot) -> tuple[Stored, ...]:
    """The fields of a file: those of every run, and those of a user's own terms."""
    own = (_of_term(name, values.shape[1:]) for name, values in snapshot.further.items())
    return (*AT_POINTS, *OF_LAW, *own)


def _of_term(name: str, shape: tuple[int, ...]) -> Stored:
    return Stored(name, name, math.prod(shape), "", "a field of a term")


class VtkHdfFile:
    """Appends the records of one run to ``path``.

    Those of a file there are kept up to the time ``until_kept`` [s], none where it is None.
    ``expected`` records are foreseen; more may come.
    """

    def __init__(self, path: Path, *, expected: int, until_kept: float | None = None) -> None:
        self._path, self._expected = path, expected
        self._count = self._room = 0
        try:
            if until_kept is not None and path.is_file():
                self._count = sum(time <= until_kept for time, _ in steps_of(path))
            if self._count:
                self._resize(max(_LEAST, expected, self._count))
        except (OSError, KeyError, ValueError) as damage:
            raise InputError(
                f"{path} is no file of records, or is damaged ({damage}); the run can go on "
                "without it: move it away, or use replace=True"
            ) from damage

    def append(self, snapshot: Snapshot) -> None:
        """Add a record; its number of points and cells is that of the first."""
        if self._count == 0:
            self._room = self._first_room(snapshot)
            with atomic(self._path) as part, _opened(part, "w") as file:
                _create(file, _Body.of(snapshot), self._room)
                _write(file, snapshot, 0)
                _say_count(file, 1)
                _list_time(file, 0, snapshot.time)
        else:
            if self._count == self._room:
                self._resize(2 * self._room)
            with _opened(self._path, "r+") as file:
                _write(file, snapshot, self._count)
                file.flush()
                _say_count(file, self._count + 1)
                file.flush()
                _list_time(file, self._count, snapshot.time)
        self._count += 1

    def close(self) -> None:
        """Cut off what was not used."""
        if 0 < self._count < self._room:
            self._resize(self._count)

    def _first_room(self, snapshot: Snapshot) -> int:
        size = 24 * len(snapshot.X) + 4 * sum(
            each.width * len(snapshot.field(each.field).X) for each in stored_of(snapshot)
        )
        return max(min(self._expected, _MOST // max(1, size)), _LEAST)

    def _resize(self, room: int) -> None:
        with (
            atomic(self._path) as part,
            _opened(self._path, "r") as old,
            _opened(part, "w") as new,
        ):
            _copy(old, new, records=self._count, room=room)
        self._room = room


def steps_of(path: Path) -> list[tuple[float, int]]:
    """Times [s] and steps of the records of a file."""
    with _opened(path, "r") as file:
        steps = file[f"{GROUP}/Steps"]
        count = min(int(steps.attrs["NSteps"]), len(steps["Values"]))
        times, numbers = steps["Values"][:count], file["sphsolid/step"][:count]
    return list(zip(times.tolist(), numbers.tolist(), strict=True))


@contextmanager
def _opened(path: Path, mode: str) -> Iterator[Any]:
    # Who writes no file need not load it.
    import h5py

    with h5py.File(path, mode, libver=("earliest", "v110"), locking=False) as file:
        yield file


@dataclass(frozen=True)
class _Body:
    """What is the same for every record: the mesh, and which fields stand in its cells."""

    X: NDArray[np.float64]
    cells: NDArray[np.int64]
    kind: int
    in_cells: frozenset[str]
    fields: tuple[Stored, ...]

    @classmethod
    def of(cls, snapshot: Snapshot) -> _Body:
        """That of a snapshot."""
        mesh, X = snapshot.mesh, snapshot.X
        kind = _VTK_HEXAHEDRON if mesh.shape is HEXAHEDRON else _VTK_TETRA
        inside = {each.name for each in OF_LAW if not snapshot.field(each.field).is_at(X)}
        return cls(snapshot.X, mesh.cells, kind, frozenset(inside), stored_of(snapshot))

    @classmethod
    def read(cls, file: Any) -> _Body:
        """That of a file."""
        root = file[GROUP]
        kind, count = int(root["Types"][0]), len(root["Types"])
        cells = root["Connectivity"][...].reshape(count, -1)
        X, usual = root["PointData/X"][...], (*AT_POINTS, *OF_LAW)
        names = {"X", *(each.name for each in usual)}
        own = (
            _of_term(name, array.shape[1:])
            for name, array in root["PointData"].items() if name not in names
        )  # fmt: skip
        return cls(X, cells, kind, frozenset(root["CellData"]), (*usual, *own))

    def place(self, name: str) -> tuple[str, int]:
        """The group of a field and its rows a record."""
        if name in self.in_cells:
            return "CellData", len(self.cells)
        return "PointData", len(self.X)


def _create(file: Any, body: _Body, room: int) -> None:
    """The structure of the file with room for ``room`` records."""
    N, (C, corners) = len(body.X), body.cells.shape
    root = file.create_group(GROUP)
    root.attrs["Version"] = np.array(_VERSION, dtype=np.int64)
    # Readers want a string of fixed length, in ASCII.
    root.attrs["Type"] = np.bytes_("UnstructuredGrid")
    for name, count in (
        ("NumberOfPoints", N), ("NumberOfCells", C), ("NumberOfConnectivityIds", corners * C),
    ):  # fmt: skip
        root[name] = np.array([count], dtype=np.int64)
    root["Connectivity"] = body.cells.ravel().astype(np.int64)
    root["Offsets"] = np.arange(C + 1, dtype=np.int64) * corners
    root["Types"] = np.full(C, body.kind, dtype=np.uint8)
    _say(_array(root, "Points", (room * N, 3), np.float64), "m", "x, positions now")
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(0)
    # In one piece of the file, so that a longer list is another number in one place.
    steps.create_dataset("Values", (1,), np.float64, maxshape=(None,), chunks=(room,))
    _say(steps["Values"], "s", "times of the records")
    # The same part of the mesh for every record, other points for each.
    for name, shape in (
        ("PartOffsets", (room,)), ("CellOffsets", (room, 1)), ("ConnectivityIdOffsets", (room, 1)),
    ):  # fmt: skip
        steps[name] = np.zeros(shape, dtype=np.int64)
    steps["NumberOfParts"] = np.ones(room, dtype=np.int64)
    steps["PointOffsets"] = np.arange(room, dtype=np.int64) * N
    for group in ("PointData", "CellData"):
        root.create_group(group)
        steps.create_group(f"{group}Offsets")
    root["PointData/X"] = np.ascontiguousarray(body.X, dtype=np.float64)
    _say(root["PointData/X"], "m", "positions in the undeformed body")
    steps["PointDataOffsets/X"] = np.zeros(room, dtype=np.int64)
    for each in body.fields:
        group, rows = body.place(each.name)
        shape = (room * rows,) if each.width == 1 else (room * rows, each.width)
        _say(_array(root[group], each.name, shape, np.float32), each.unit, each.says)
        steps[f"{group}Offsets/{each.name}"] = np.arange(room, dtype=np.int64) * rows
    # What is no part of VTK's model stands outside its group.
    ours = file.create_group("sphsolid")
    ours.attrs["units"] = np.bytes_("SI; every array has its own as the attribute units")
    _array(ours, "step", (room,), np.int64)


def _array(group: Any, name: str, shape: tuple[int, ...], kind: Any) -> Any:
    """An array with its place in the file from the start, so that writing moves nothing."""
    import h5py

    layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    layout.set_layout(h5py.h5d.CONTIGUOUS)
    layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    layout.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    # The same run gives the same bytes.
    layout.set_obj_track_times(False)
    space = h5py.h5s.create_simple(shape)
    made = h5py.h5d.create(
        group.id, name.encode(), h5py.h5t.py_create(np.dtype(kind)), space, dcpl=layout
    )
    return h5py.Dataset(made)


def _say(array: Any, unit: str, meaning: str) -> None:
    array.attrs["units"] = np.bytes_(unit)
    array.attrs["meaning"] = np.bytes_(meaning)


def _write(file: Any, snapshot: Snapshot, record: int) -> None:
    """The values of a record into their places."""
    root, N = file[GROUP], len(snapshot.X)
    _put(root["Points"], snapshot.x, record)
    for each in stored_of(snapshot):
        values = snapshot.field(each.field).values
        group = "PointData" if len(values) == N else "CellData"
        # A field on its way to divergence may exceed single precision: infinite there, no warning.
        with np.errstate(over="ignore"):
            single = values.astype(np.float32)
        _put(root[f"{group}/{each.name}"], single, record)
    file["sphsolid/step"][record] = snapshot.step


def _say_count(file: Any, records: int) -> None:
    """In the place of the number before: a new attribute would change the structure."""
    file[f"{GROUP}/Steps"].attrs.get_id("NSteps").write(np.array(records, dtype=np.int64))


def _list_time(file: Any, record: int, time: float) -> None:
    """The list of times grows by one."""
    times = file[f"{GROUP}/Steps/Values"]
    if len(times) < record + 1:
        times.resize((record + 1,))
    times[record] = time


def _put(array: Any, values: NDArray[Any], record: int) -> None:
    rows = len(values)
    array[record * rows : (record + 1) * rows] = values.reshape(rows, *array.shape[1:])


def _copy(old: Any, new: Any, *, records: int, room: int) -> None:
    """The first ``records`` of a file into another with ``room`` for more."""
    body = _Body.read(old)
    _create(new, body, room)
    arrays = [(f"{GROUP}/Points", len(body.X))]
    for each in body.fields:
        group, rows = body.place(each.name)
        arrays.append((f"{GROUP}/{group}/{each.name}", rows))
    for name, rows in [*arrays, ("sphsolid/step", 1)]:
        for record in range(records):
            part = slice(record * rows, (record + 1) * rows)
            new[name][part] = old[name][part]
    for record, time in enumerate(old[f"{GROUP}/Steps/Values"][:records].tolist()):
        _list_time(new, record, time)
    _say_count(new, records)


def expected_records(start: float, until: float, every: float | None, *, already: int) -> int:
    """Records of a run from ``start`` to ``until`` [s], with those that there are ``already``."""
    return already + 2 + (0 if every is None else math.ceil((until - start) / every))
