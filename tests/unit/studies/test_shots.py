"""Frames come back bit by bit, never mix with old ones, and say so when they are missing."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest

from sphsolid.errors import Diverged, InputError
from sphsolid.look.view import flat_view
from sphsolid.record import Snapshot
from sphsolid.scenes import Box, twisting_column
from studies.engine.results import Results
from studies.pictures import frame_file
from studies.pictures.frame_file import KeptFrames, read_frames, write_frames
from studies.pictures.picture import FRAMES, Panel, Percentile, Picture, keeping
from studies.pictures.shots import CELL, KEPT, Absent, HasDiverged, SaveShots, ShotFolder
from tests.oracles.frames import box_shot, twisted

MATERIAL = twisting_column().material
NOISY = {"move": twisted(0.3), "field": lambda x: np.random.default_rng(3).normal(size=len(x))}


def one_cell(time):
    """A body of one cell that moves along, its first vertex under tension."""
    mesh = Box((0, 0, 0), (1, 1, 1)).mesh(1.0)
    eye = np.broadcast_to(np.eye(3), (8, 3, 3))
    X, V = mesh.vertices, np.full(8, 0.125)
    return Snapshot(
        time=time, step=0, material=MATERIAL, mesh=mesh, X=X, V=V, x=X + time,
        velocity=np.zeros((8, 3)), stress_X=X, stress_V=V, F=eye, P=0.0 * eye,
        J=np.where(np.arange(8) == 0, 1.25, 1.0), strain_energy=0.0,
    )  # fmt: skip


def diverged(time):
    return Diverged("J <= 0", time, 7, 3, (0.0, 0.0, 0.0), "a smaller step")


def same(a, b):
    assert (a.label, a.time, a.folded) == (b.label, b.time, b.folded)
    assert list(a.values) == list(b.values)
    pairs = [(a.x, b.x), (a.quads, b.quads), (a.V, b.V)]
    for old, new in pairs + [(a.values[name], b.values[name]) for name in a.values]:
        assert old.dtype == new.dtype
        assert old.tobytes() == new.tobytes()


def test_frames_come_back_bit_by_bit(tmp_path):
    one = box_shot(label="SUPG-SPH {p,F}, ν = 0.495", time=0.1 + 0.2, **NOISY)
    two, gone = replace(one, time=1.0, folded=True), HasDiverged("m", 2.0, 1.5)
    back = read_frames(write_frames(tmp_path / "a.npz", [("k", one), ("k", two), ("l", gone)]))
    assert [key for key, _ in back] == ["k", "k", "l"]
    same(back[0][1], one)
    same(back[1][1], two)
    assert back[2][1] == gone
    assert back[0][1].x.dtype == np.float32
    assert back[0][1].quads.dtype == np.int32


def test_equal_arrays_are_kept_once_and_equal_frames_are_equal_files(tmp_path):
    one = box_shot(**NOISY)
    single, many = (
        write_frames(tmp_path / f"{n}.npz", [("k", replace(one, time=float(k))) for k in range(n)])
        for n in (1, 20)
    )
    assert many.stat().st_size < 1.5 * single.stat().st_size
    again = write_frames(tmp_path / "again.npz", [("k", replace(box_shot(**NOISY), time=0.0))])
    assert again.read_bytes() == single.read_bytes()


def test_a_killed_writer_leaves_the_old_frames_whole(tmp_path, monkeypatch):
    path = write_frames(tmp_path / "a.npz", [("k", box_shot(label="old"))])

    def killed(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", killed)
    with pytest.raises(KeyboardInterrupt):
        write_frames(path, [("k", box_shot(label="new"))])
    monkeypatch.undo()
    assert read_frames(path)[0][1].label == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.npz"]


def test_missing_broken_and_old_frames_are_named(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"no frames .*/a\.npz: run what makes it again"):
        read_frames(tmp_path / "a.npz")
    whole = write_frames(tmp_path / "c.npz", [("k", box_shot())])
    (tmp_path / "b.npz").write_bytes(whole.read_bytes()[:500])
    with pytest.raises(InputError, match=r"b\.npz cannot be read"):
        read_frames(tmp_path / "b.npz")
    monkeypatch.setattr(frame_file, "_FORMAT", 99)
    with pytest.raises(InputError, match="format 3, and this version reads 99: run what makes"):
        read_frames(whole)
    with pytest.raises(InputError, match="no frames of 'x'"):
        ShotFolder(tmp_path / "shots").load_all("x")


def test_frames_are_found_by_key_and_time_through_round_off(tmp_path):
    folder = ShotFolder(tmp_path)
    folder.save("p_F", one_cell(0.1 + 0.2), "one")
    # Keys that differ only in signs do not mix.
    folder.save("{p,F}", one_cell(0.3), "two")
    assert folder.load("p_F", 0.3).label == "one"
    assert folder.load("{p,F}", 0.3).label == "two"
    with pytest.raises(InputError, match=r"'p_F' at 0.2 s in .*kept: 0\.3"):
        folder.load("p_F", 0.2)


def test_a_run_that_diverged_says_so_from_then_on(tmp_path):
    folder = ShotFolder(tmp_path)
    folder.save("a", one_cell(0.1), "the method")
    folder.save_diverged("a", "the method", diverged(0.15))
    assert folder.load("a", 0.1).label == "the method"
    assert folder.load("a", 0.2) == HasDiverged("the method", 0.2, diverged_at=0.15)
    with pytest.raises(InputError):
        folder.load("a", 0.12)
    assert len(folder.load_all("a")) == 1
    folder.clear("a")
    assert not list(tmp_path.iterdir())


def test_the_recorder_keeps_the_times_asked_for(tmp_path):
    folder = ShotFolder(tmp_path)
    some = SaveShots(folder, "some", "m", times=(0.1, 0.3))
    every = SaveShots(folder, "every", "m")
    for k in range(5):
        for recorder in (some, every):
            assert recorder.record(one_cell(0.1 * k), scene=None) == {}
    assert [s.time for s in folder.load_all("some")] == pytest.approx([0.1, 0.3])
    assert len(folder.load_all("every")) == 5
    shot = folder.load("some", 0.1)
    kappa = MATERIAL.kappa
    own = {"pressure": 0.25 * kappa, "von_mises": 0.0, "J": 1.25}
    over_the_cell = {"pressure": kappa / 32.0, "von_mises": 0.0, "J": 1.0 + 1.0 / 32.0}
    for name in own:
        assert shot.values[name][0] == pytest.approx(own[name])
        assert shot.values[CELL + name] == pytest.approx([over_the_cell[name]] * 8)
    assert set(shot.values) == set(KEPT)
    assert shot.V.tolist() == [0.125] * 8
    assert shot.quads.shape == (6, 4)


def results(out):
    """Two runs, one of which diverged, and a picture of both at two times."""
    folder = ShotFolder(out / "shots")
    for time in (0.0, 0.1):
        shot = box_shot(spacing=0.1, time=time, field=lambda x: 1.0 + x[:, 0])
        folder.save_frame("one", shot)
    folder.save_frame("two", box_shot(spacing=0.1, field=lambda x: 50.0 + x[:, 0]))
    folder.save_diverged("two", "as it was run", diverged(0.05))
    plan = [[Panel(key, key, time, key == "one") for time in (0.0, 0.1)] for key in ("one", "two")]
    picture = Picture(lambda tables: plan, "pressure", Percentile(100.0), flat_view())
    keeping([picture])(out, {})
    return picture, Results(out, {}, None, {})


def test_pictures_are_drawn_from_the_kept_frames_alone(tmp_path):
    picture, found = results(tmp_path)
    (tmp_path / "shots").rename(tmp_path / "gone")
    figure = picture.draw(found)
    texts = [[t.get_text() for t in axes.texts] for axes in figure.axes[1:5]]
    assert texts == [[], [], [], ["diverged\nat 50 ms"]]
    # Colours come from the run that sets them, and beyond means beyond what is shown of it.
    assert figure.axes[5].get_ylim() == (-2.0, 2.0)
    kept = KeptFrames(tmp_path / FRAMES).load("one", 0.1)
    assert list(kept.values) == ["pressure"]
    assert len(kept.quads) == 100, "of six faces one is seen"
    assert len(kept.x) == 11 * 11


def test_pictures_without_frames_are_refused_and_old_frames_do_not_stay(tmp_path):
    picture, found = results(tmp_path)
    ShotFolder(tmp_path / "shots").clear("one")
    with pytest.raises(InputError, match="no frame of 'one'"):
        keeping([picture])(tmp_path, {})
    with pytest.raises(InputError, match=r"no frames .*frames\.npz"):
        picture.draw(found)


def test_a_picture_with_few_panels_is_not_worth_drawing():
    there, not_there = Panel("a", "a", 0.0), Absent("a", 0.0)
    for row, worth in (([there, there, not_there], True), ([there, not_there], False), ([], False)):
        assert Picture(lambda tables, row=row: [row]).is_worth_drawing({}) is worth
