"""Frames come back bit by bit, never mix with old ones, and say so when they are missing."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest

from sphsolid.errors import Diverged, InputError
from sphsolid.record import Snapshot
from sphsolid.scenes import Box, twisting_column
from studies.pictures import shots
from studies.pictures.shots import CELL, KEPT, Lost, SaveShots, ShotFolder, load_shot, save_shot
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


def lost_at(time):
    return Diverged("J <= 0", time, 7, 3, (0.0, 0.0, 0.0), "a smaller step")


def test_a_frame_comes_back_bit_by_bit(tmp_path):
    shot = box_shot(label="SUPG-SPH {p,F}, ν = 0.495", time=0.1 + 0.2, **NOISY)
    back = load_shot(save_shot(tmp_path / "a.npz", shot))
    assert (back.label, back.time, back.spacing) == (shot.label, shot.time, shot.spacing)
    assert set(back.values) == set(KEPT)
    pairs = [(shot.x, back.x), (shot.quads, back.quads)]
    for old, new in pairs + [(shot.values[name], back.values[name]) for name in KEPT]:
        assert old.dtype == new.dtype
        assert old.tobytes() == new.tobytes()
    assert back.x.dtype == np.float32
    assert back.folded is False
    assert load_shot(save_shot(tmp_path / "b.npz", replace(shot, folded=True))).folded is True
    assert back.quads.dtype == np.int32


def test_the_same_frame_is_the_same_file(tmp_path):
    a, b = (save_shot(tmp_path / name, box_shot(**NOISY)).read_bytes() for name in ("a", "b"))
    assert a == b


def test_a_killed_writer_leaves_the_old_frame_whole(tmp_path, monkeypatch):
    path = save_shot(tmp_path / "a.npz", box_shot(label="old"))

    def killed(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", killed)
    with pytest.raises(KeyboardInterrupt):
        save_shot(path, box_shot(label="new"))
    monkeypatch.undo()
    assert load_shot(path).label == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.npz"]


def test_missing_and_broken_frames_are_named(tmp_path):
    with pytest.raises(InputError, match=r"no frame .*/a\.npz: run its case again"):
        load_shot(tmp_path / "a.npz")
    (tmp_path / "b.npz").write_bytes(save_shot(tmp_path / "c.npz", box_shot()).read_bytes()[:500])
    with pytest.raises(InputError, match=r"b\.npz cannot be read"):
        load_shot(tmp_path / "b.npz")
    folder = ShotFolder(tmp_path / "shots")
    with pytest.raises(InputError, match="no frames of 'x'"):
        folder.load_all("x")
    folder.save("x", one_cell(0.25), "x")
    with pytest.raises(InputError, match=r"no frame of 'x' at 0\.5 s in shots/ \(kept: 0\.25\)"):
        folder.load("x", 0.5)


def test_frames_of_another_format_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(shots, "_FORMAT", 99)
    save_shot(tmp_path / "a.npz", box_shot())
    monkeypatch.undo()
    with pytest.raises(InputError, match="format 99"):
        load_shot(tmp_path / "a.npz")


def test_cases_do_not_mix(tmp_path):
    folder = ShotFolder(tmp_path)
    keys = ["a", "a b", "[a]{p,F}", "a@2"]
    for number, key in enumerate(keys):
        for time in (0.5, 0.0, 0.125 * number + 1.0):
            folder.save(key, one_cell(time), key)
    for number, key in enumerate(keys):
        assert [shot.time for shot in folder.load_all(key)] == [0.0, 0.5, 0.125 * number + 1.0]
        assert {shot.label for shot in folder.load_all(key)} == {key}
    folder.clear("a")
    with pytest.raises(InputError):
        folder.load_all("a")
    assert len(folder.load_all("a b")) == 3


def test_keys_that_differ_only_in_signs_do_not_mix(tmp_path):
    folder = ShotFolder(tmp_path)
    folder.save("p_F", one_cell(0.0), "one")
    folder.save("{p,F}", one_cell(0.0), "two")
    assert folder.load("p_F", 0.0).label == "one"
    assert folder.load("{p,F}", 0.0).label == "two"


def test_times_are_found_through_round_off(tmp_path):
    folder = ShotFolder(tmp_path)
    folder.save("a", one_cell(0.1 + 0.2), "a")
    assert folder.load("a", 0.3).time == 0.1 + 0.2


def test_a_lost_run_says_so_from_then_on(tmp_path):
    folder = ShotFolder(tmp_path)
    folder.save("a", one_cell(0.1), "the method")
    folder.save_lost("a", "the method", lost_at(0.15))
    assert folder.load("a", 0.1).label == "the method"
    assert folder.load("a", 0.2) == Lost("the method", 0.2, lost_at=0.15)
    with pytest.raises(InputError):
        folder.load("a", 0.12)
    assert len(folder.load_all("a")) == 1
    folder.clear("a")
    with pytest.raises(InputError):
        folder.load("a", 0.2)


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
    assert shot.V.tolist() == [0.125] * 8
    assert shot.quads.shape == (6, 4)
