"""The plate with a hole: load, tags, known concentrations, and files that are read back."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

import fem_reference as fem
from sphsolid.errors import InputError
from sphsolid.geometry import AsMeshed, MeshFile
from sphsolid.scenes import SlowPull, gross_concentration, plate_with_hole
from studies.meshes import MESHES

HEX = MeshFile(MESHES / "plate_with_hole_hex.msh")
TET = MeshFile(MESHES / "plate_with_hole_tet.msh")


def test_known_concentrations():
    assert gross_concentration(radius=1e-9, half_width=1.0) == pytest.approx(3.0)
    assert gross_concentration(radius=0.1, half_width=0.5) == pytest.approx(3.14)


def test_the_load_rises_smoothly_and_holds():
    pull = SlowPull(stress=2.0, rise=3.0)
    assert [pull.share(t) for t in (-1.0, 0.0, 1.5, 3.0, 9.0)] == pytest.approx([0, 0, 0.5, 1, 1])
    X = np.zeros((2, 3))
    np.testing.assert_allclose(pull(X, X, 3.0), [[0.0, 2.0, 0.0]] * 2)


@pytest.mark.parametrize("body", [HEX, TET])
def test_every_tag_of_the_scene_is_in_the_files(body):
    scene = plate_with_hole(body=body)
    tags = set(body.mesh(AsMeshed()).faces)
    assert {c.face for c in scene.constraints} | {t.face for t in scene.tractions} <= tags


def test_vtu_of_the_plate_opens(tmp_path):
    sim = fem.Simulation(plate_with_hole(body=HEX))
    sim.run(until=20 * sim.stable_time_step())
    sim.save(tmp_path / "plate.vtu")
    read = meshio.read(tmp_path / "plate.vtu")
    mesh = HEX.mesh(AsMeshed())
    assert [block.type for block in read.cells] == ["hexahedron"]
    np.testing.assert_array_equal(read.cells[0].data, mesh.cells)
    np.testing.assert_allclose(read.points, mesh.vertices, atol=1e-6)
    fields = [*read.point_data.values(), *(v[0] for v in read.cell_data.values())]
    assert all(np.isfinite(values).all() for values in fields)
    assert np.any(read.cell_data["P"][0] != 0.0)


@pytest.mark.parametrize(
    ("given", "named"),
    [({"thickness": "thin"}, "thickness"), ({"stress": 0.0}, "stress"), ({"rise": -1.0}, "rise"),
     ({"hold": np.nan}, "hold"), ({"radius": 0.6}, "radius")],
)  # fmt: skip
def test_bad_input_is_refused(given, named):
    with pytest.raises(InputError, match=named):
        plate_with_hole(body=HEX, **given)
