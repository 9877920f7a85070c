"""Animations: every frame is there, in order, once, and the file repeats."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from PIL import Image

from sphsolid.errors import InputError
from sphsolid.look.colours import limits
from sphsolid.look.panels import Layout
from sphsolid.look.surface import Surface
from studies.animation import main, write_gif
from studies.pictures.shots import HasDiverged, ShotFolder
from tests.oracles.frames import box_shot, twisted

LOOK = {"layout": Layout(width=2.5, height=2.5, dpi=60), "drawing": Surface(detail=1)}


def column(k, label="a method"):
    return box_shot(
        (-0.5, 0, -0.5), (0.5, 3, 0.5), spacing=0.5, move=twisted(0.15 * k), label=label,
        time=0.01 * k, field=lambda x: x[:, 0],
    )  # fmt: skip


@pytest.fixture
def frames():
    return [column(k) for k in range(7)]


def test_every_frame_is_there(tmp_path, frames):
    path = write_gif(frames, tmp_path / "a.gif", colours=limits(frames), **LOOK)
    with Image.open(path) as gif:
        assert gif.n_frames == 7
        assert gif.info["loop"] == 0
        pictures, durations = [], []
        for k in range(7):
            gif.seek(k)
            durations.append(gif.info["duration"])
            pictures.append(np.asarray(gif.convert("RGB")).astype(int))
    assert durations == [100] * 6 + [1100]
    for first, second in itertools.pairwise(pictures):
        assert np.abs(first - second).max() > 50
    assert path.stat().st_size < 200_000


def test_the_file_repeats(tmp_path, frames):
    a, b = (
        write_gif(frames[:3], tmp_path / name, colours=limits(frames), **LOOK).read_bytes()
        for name in ("a.gif", "b.gif")
    )
    assert a == b


def test_methods_run_beside_each_other_and_one_may_diverge(tmp_path, frames):
    rows = [[shot, column(k, "another")] for k, shot in enumerate(frames)]
    rows[-1][1] = HasDiverged("another", frames[-1].time, diverged_at=0.055)
    path = write_gif(rows, tmp_path / "a.gif", colours=limits(rows), **LOOK)
    with Image.open(path) as gif:
        assert gif.n_frames == 7
        both = gif.size
    path = write_gif(frames, tmp_path / "b.gif", colours=limits(rows), **LOOK)
    with Image.open(path) as gif:
        assert both[0] > 1.3 * gif.size[0]


def test_stored_frames_from_the_command_line(tmp_path, frames, capsys):
    folder = ShotFolder(tmp_path / "shots")
    for key in ("one", "two"):
        for shot in frames[: 4 if key == "one" else 3]:
            folder.save_frame(key, shot)
    given = ["--shots", str(folder.path), "--gif", str(tmp_path / "a.gif")]
    assert main([*given, "--key", "one"]) == 0
    assert capsys.readouterr().out.startswith("wrote a.gif: 4 pictures")
    with Image.open(tmp_path / "a.gif") as gif:
        assert gif.n_frames == 4
    for wrong in ([], ["--key", "three"], ["--key", "one", "--key", "two"]):
        assert main([*given, *wrong]) == 2
        assert capsys.readouterr().err.startswith("error: ")
    assert main(["--scene", "no_such_scene"]) == 2
    assert "no_such_scene" in capsys.readouterr().err


def test_nothing_to_show_is_refused(tmp_path, frames):
    for given in ([], [[]], [[HasDiverged("a", 0.0, 0.0)]]):
        with pytest.raises(InputError):
            write_gif(given, tmp_path / "a.gif", colours=limits(frames))
    with pytest.raises(InputError, match="per_second"):
        write_gif(frames, tmp_path / "a.gif", colours=limits(frames), per_second=0.0)
    assert not list(tmp_path.iterdir())
