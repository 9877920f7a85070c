"""VTU files read back by meshio: every field of both solvers, cells the right way round."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.geometry.mesh import HexMesh
from sphsolid.record import write_vtu
from sphsolid.record.vtu import write_pvd
from tests.oracles.blocks import loaded_block

FIELDS = ("u", "v", "p", "F", "J", "P", "cauchy", "pressure", "von_mises")
#: The eight corners of a VTK hexahedron in its own coordinates: the bottom quadrilateral, then the
#: top one above it, both counter-clockwise seen from above.
VTK = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)


def volumes(points: Any, cells: Any) -> Any:
    """``int det dx/dr`` of trilinear hexahedra by 2x2x2 Gauss points, in VTK's numbering."""
    total = np.zeros(len(cells))
    for r in np.stack(np.meshgrid(*[[0.5 - 0.75**0.5 / 3, 0.5 + 0.75**0.5 / 3]] * 3), -1).reshape(
        -1, 3
    ):
        factor = np.where(VTK == 1, r, 1.0 - r)
        slope = np.where(VTK == 1, 1.0, -1.0)
        gradient = np.stack(
            [slope[:, i] * factor[:, (i + 1) % 3] * factor[:, (i + 2) % 3] for i in range(3)], 1
        )
        total += np.linalg.det(np.einsum("cai,aj->cij", points[cells], gradient)) / 8.0
    return total


@pytest.fixture(scope="module", params=["sph", "fem"])
def moved(request):
    """A disordered block after some steps under every kind of load."""
    scene = loaded_block()
    sim: Any = (
        sph.Simulation(scene, spacing=0.25, formulation=sph.PFHJ())
        if request.param == "sph"
        else fem.Simulation(scene, spacing=0.25)
    )
    sim.run(until=1.0e-3)
    return sim


@pytest.fixture
def read(moved, tmp_path):
    moved.save(tmp_path / "body.vtu")
    return meshio.read(tmp_path / "body.vtu")


def test_every_field_comes_back_and_all_but_positions_in_single_precision(moved, read):
    snapshot = moved.snapshot()
    at_points = len(snapshot.J) == len(snapshot.X)
    for name in FIELDS:
        values = snapshot.field(name).values
        in_cells = name in FIELDS[3:] and not at_points
        found = read.cell_data[name][0] if in_cells else read.point_data[name]
        # Positions would fall together far from the origin.
        kind = np.float64 if name == "X" else np.float32
        assert found.dtype == kind
        expected = values.astype(kind).reshape(found.shape)
        np.testing.assert_array_equal(found, expected, err_msg=name)
        assert np.any(found != found[0]), f"{name} is the same everywhere: the test sees nothing"
    components = {name: read.point_data[name].shape[1:] for name in ("X", "u", "v", "p")}
    assert set(components.values()) == {(3,)}
    law = {name: read.cell_data[name][0] for name in read.cell_data} or read.point_data
    assert (law["F"].shape[1:], law["P"].shape[1:], law["J"].shape[1:]) == ((9,), (9,), ())


def test_the_law_stands_where_the_method_evaluates_it(moved, read):
    names = {"X", "u", "v", "p"}
    law = {"F", "J", "P", "cauchy", "pressure", "von_mises"}
    if isinstance(moved, sph.Simulation):
        assert (set(read.point_data), set(read.cell_data)) == (names | law, set())
    else:
        assert (set(read.point_data), set(read.cell_data)) == (names, law)


def test_points_are_where_the_body_is_now(moved, read):
    snapshot = moved.snapshot()
    np.testing.assert_array_equal(read.points, snapshot.x)
    X, u = read.point_data["X"], read.point_data["u"]
    np.testing.assert_allclose(read.points - u, X, atol=3e-7)
    assert np.max(np.abs(u)) > 0.05


def test_time_and_step(moved, read):
    assert read.field_data["TimeValue"].tolist() == [1.0e-3]
    assert read.field_data["step"].tolist() == [moved.step]


def test_the_file_says_the_sign_of_its_pressure(moved, read):
    """Positive in tension: a third of the trace of the Cauchy stress in the same file."""
    assert read.field_data["pressure_is_positive_in_tension"].tolist() == [1]
    law = {name: read.cell_data[name][0] for name in read.cell_data} or read.point_data
    mean = law["cauchy"][:, [0, 4, 8]].sum(axis=1) / 3.0
    # Of {p,F,H,J} the two differ by what J and det F, H and cof F do.
    size = np.abs(law["pressure"]).max()
    np.testing.assert_allclose(law["pressure"], mean, atol=0.05 * size)


def test_cells_are_the_right_way_round(moved, read):
    [block] = read.cells
    assert block.type == "hexahedron"
    undeformed = volumes(read.point_data["X"].astype(float), block.data)
    assert undeformed.sum() == pytest.approx(1.0 * 0.8 * 1.2, rel=1e-6)
    assert undeformed.min() > 0.0
    assert volumes(read.points.astype(float), block.data).min() > 0.0
    # The judge of the line above: two swapped corners, or top and bottom, are seen.
    for order in ([1, 0, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 0, 1, 2, 3], [0, 2, 1, 3, 4, 6, 5, 7]):
        wrong = volumes(read.point_data["X"].astype(float), block.data[:, order])
        assert wrong.sum() < 0.9 * undeformed.sum()


def test_an_older_file_is_replaced_and_nothing_else_is_left(moved, tmp_path):
    path = tmp_path / "body.vtu"
    path.write_text("something else")
    moved.save(path)
    assert len(meshio.read(path).points) == len(moved.snapshot().X)
    assert [file.name for file in tmp_path.iterdir()] == ["body.vtu"]


def test_a_write_that_fails_leaves_the_older_file(moved, tmp_path, monkeypatch):
    path = tmp_path / "body.vtu"
    moved.save(path)
    before = path.read_bytes()

    def full(part: Any, *_: Any, **__: Any) -> None:
        part.write_text("half a")
        raise OSError("disk full")

    monkeypatch.setattr(meshio, "write", full)
    with pytest.raises(OSError, match="disk full"):
        moved.save(path)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["body.vtu"]


def test_other_suffixes_and_missing_folders_are_refused(moved, tmp_path):
    with pytest.raises(InputError, match=r"'body.vtk' does not end in \.vtu"):
        moved.save(tmp_path / "body.vtk")
    with pytest.raises(InputError, match="does not exist"):
        moved.save(tmp_path / "nowhere" / "body.vtu")


def test_a_field_beyond_single_precision_is_infinite_there(make_snapshot, tmp_path):
    vertices = VTK.astype(float)
    velocity = np.zeros((8, 3))
    velocity[3, 1] = 1e200
    cells = HexMesh(vertices, np.arange(8)[None, :], {}, 1.0, True)
    body = make_snapshot(vertices, np.ones(8), velocity, mesh=cells)
    write_vtu(body, tmp_path / "body.vtu")
    found = meshio.read(tmp_path / "body.vtu").point_data["v"]
    assert found[3, 1] == np.inf
    assert np.isfinite(np.delete(found, 10)).all()


def test_a_collection_names_its_files_and_times(tmp_path):
    frames = [(0.0, "frames/a.vtu"), (0.1 + 0.2, 'frames/"b" & c.vtu')]
    write_pvd(frames, tmp_path / "all.pvd")
    root = ElementTree.parse(tmp_path / "all.pvd").getroot()
    assert root.attrib["type"] == "Collection"
    sets = [(float(d.attrib["timestep"]), d.attrib["file"]) for d in root.iter("DataSet")]
    assert sets == frames
