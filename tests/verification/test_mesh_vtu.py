"""A body from a mesh file, run for a few steps, written as VTU and read back."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import sphsolid as sph
from sphsolid.scenes import plate_with_hole

MESHES = Path(__file__).parents[2] / "studies" / "meshes"


@pytest.mark.parametrize("kind", ["tet", "hex"])
def test_a_plate_from_a_gmsh_file_comes_back(tmp_path: Path, kind: str) -> None:
    body = sph.MeshFile(MESHES / f"plate_with_hole_{kind}.msh")
    sim = sph.Simulation(plate_with_hole(body=body), formulation=sph.PF())
    for _ in range(3):
        sim.advance(sim.stable_time_step())
    sim.save(tmp_path / "plate.vtu")
    found = meshio.read(tmp_path / "plate.vtu")
    mesh = sim.cloud.mesh
    assert [block.type for block in found.cells] == [mesh.shape.vtk]
    np.testing.assert_array_equal(found.cells[0].data, mesh.cells)
    np.testing.assert_allclose(found.point_data["X"], mesh.vertices, atol=1e-7)
    for name in ("u", "v", "p", "F", "P", "J", "pressure", "von_mises"):
        assert np.isfinite(found.point_data[name]).all(), name
    assert found.point_data["F"].shape == (sim.cloud.size, 9)
