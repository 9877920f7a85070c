"""One table of units for every file, and the question about a body that is too large."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile, PointCloud, Surface, check_mesh
from sphsolid.geometry.__main__ import main
from sphsolid.geometry.units import UNITS, metres, unit_question
from tests.oracles.gmsh_text import write_mesh

MESH = Box(upper=(40.0, 20.0, 20.0)).mesh(10.0)
METRES = {
    "m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9,
    "in": 0.0254, "ft": 0.3048, 1e-3: 1e-3, 2: 2.0, np.float64(0.5): 0.5,
}  # fmt: skip


def files(tmp_path: Path) -> tuple[Path, Path]:
    """A mesh of 40 x 20 x 20 units, which is a surface too, and three points inside it."""
    points = tmp_path / "points.csv"
    points.write_text("10,10,10\n20,10,10\n30,10,10\n")
    return write_mesh(tmp_path / "body.msh", MESH), points


@pytest.mark.parametrize("unit", METRES)
def test_every_reader_takes_every_unit(tmp_path, unit):
    mesh, points = files(tmp_path)
    scale = METRES[unit]
    assert MeshFile(mesh, unit).volume == pytest.approx(16000.0 * scale**3, rel=1e-12)
    assert Surface.read(mesh, unit=unit).volume == pytest.approx(16000.0 * scale**3, rel=1e-12)
    cloud = PointCloud(points, mesh, unit)
    assert cloud.volume == pytest.approx(16000.0 * scale**3, rel=1e-12)


def test_a_cloud_puts_its_points_where_its_surface_is(tmp_path):
    mesh, points = files(tmp_path)
    X = PointCloud(points, mesh, "mm")._mesh.vertices
    assert np.isclose(X, [0.02, 0.01, 0.01], atol=1e-12).all(axis=1).any()


@pytest.mark.parametrize("unit", ["", "km", "MM", "metre", "feet", 0, -1.0, np.nan, np.inf, True,
                                  None, [1.0], 1j])  # fmt: skip
def test_every_reader_refuses_what_is_no_unit(tmp_path, unit):
    mesh, points = files(tmp_path)
    for make in (
        lambda: MeshFile(mesh, unit),
        lambda: Surface.read(mesh, unit=unit),
        lambda: PointCloud(points, mesh, unit).volume,
        lambda: PointCloud.fill(surface=mesh, spacing=10.0, unit=unit),
    ):
        with pytest.raises(InputError, match=r"^unit = .* allowed are m, .* number of metres$"):
            make()


def test_units_are_exact():
    assert (UNITS["in"], UNITS["ft"]) == (0.0254, 0.3048)
    assert all(metres(unit, "") == METRES[unit] for unit in METRES)


def test_a_body_of_forty_metres_is_asked_about(tmp_path, capsys):
    mesh, _ = files(tmp_path)
    asked = "the body is 40 x 20 x 20 m; if the file is in millimetres say unit='mm' (--unit mm)"
    assert unit_question((40.0, 20.0, 20.0)) == asked
    assert main([str(mesh)]) == 0
    out = capsys.readouterr().out
    assert asked in out
    assert "extent       40 x 20 x 20 m" in out
    for unit in ("mm", "m", "40"):
        assert main([str(mesh), "--unit", unit]) == 0
        assert "millimetres" not in capsys.readouterr().out
    found = MeshFile(mesh).read().mesh
    assert check_mesh(found).question == asked
    assert check_mesh(found, unit_given=True).question == ""
    assert check_mesh(MESH).question == ""  # made here, in metres
    small = MeshFile(mesh, "mm").read().mesh
    assert check_mesh(small).question == ""
    assert check_mesh(small).extent == pytest.approx((0.04, 0.02, 0.02), rel=1e-14)


@pytest.mark.parametrize(("largest", "asks"), [(0.04, False), (4.9, False), (5.1, True)])
def test_it_is_asked_above_five_metres(largest, asks):
    assert bool(unit_question((largest, 0.01, 0.02))) == asks
