"""``~`` is the home folder, wherever a path is given."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile, PointCloud, Surface
from sphsolid.geometry.body import AS_MESHED
from sphsolid.paths import path_of
from sphsolid.record import Energy, RunFolder, march, read_history, read_run
from sphsolid.record.checkpoint import read_checkpoint
from tests.unit.record.conftest import FakeSolver


@pytest.fixture
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    yield tmp_path / "home"
    assert list((tmp_path / "here").iterdir()) == []


def test_bodies_are_read_from_home(home):
    mesh = Box().mesh(0.5)
    meshio.write(home / "b.vtu", meshio.Mesh(mesh.vertices, [("hexahedron", mesh.cells)]))
    assert np.isclose(MeshFile("~/b.vtu").volume, 1.0)
    facets = [("quad", mesh.boundary)]
    meshio.write(home / "s.vtu", meshio.Mesh(mesh.vertices, facets))
    assert np.isclose(Surface.read("~/s.vtu").volume, 1.0)
    np.save(home / "p.npy", [[0.5, 0.5, 0.5]])
    assert len(PointCloud("~/p.npy", "~/s.vtu").mesh(AS_MESHED).vertices) == 27


def test_there_is_one_home_for_every_file_of_a_run(home, fake_run):
    history = fake_run(RunFolder("~/run"))
    history.to_csv("~/h.csv")
    assert (home / "run" / "run.json").is_file()
    assert read_run("~/run")["status"] == "complete"
    assert read_history("~/h.csv").table.equals(history.table)
    assert read_checkpoint("~/run/checkpoint.npz").time == 0.2


@pytest.fixture
def fake_run():
    return lambda output: march(FakeSolver(), until=0.2, record=[Energy()], output=output)


def test_no_path_and_no_such_home_are_refused():
    with pytest.raises(InputError, match="3 is not a path"):
        RunFolder(3)
    with pytest.raises(InputError, match="no such home"):
        path_of("~nobody-of-this-name/run")
