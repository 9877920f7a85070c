"""The picture of README, from the command line, on a column of two cells across."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from studies import picture
from studies.pictures.shots import ShotFolder


def test_the_picture_is_drawn_and_drawn_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["--cells", "2", "--shots", str(tmp_path / "shots"), "--out", str(tmp_path / "a.png")]
    assert picture.main(given) == 0
    first = (tmp_path / "a.png").read_bytes()
    assert picture.main([*given, "--redraw"]) == 0
    assert (tmp_path / "a.png").read_bytes() == first

    folder = ShotFolder(tmp_path / "shots")
    shots = [folder.load(picture.PARTICLES, time) for time in picture.TIMES]
    assert [shot.time for shot in shots] == list(picture.TIMES)
    assert len(shots[0].x) == 3 * 3 * 13
    assert len(shots[0].quads) == 4 * 2 * 12 + 2 * 4
    np.testing.assert_array_equal(shots[0].values["J"], 1.0)
    corner = shots[-1].x - shots[0].x
    assert np.abs(corner[:, 1]).max() < 0.5
    assert np.linalg.norm(corner, axis=1).max() > 0.5, "the top has turned"
    with Image.open(tmp_path / "a.png") as image:
        red, _, blue = np.asarray(image.convert("RGB")).astype(int).transpose(2, 0, 1)
        assert image.width > image.height
    assert (red - blue > 100).mean() > 0.001, "tension along the edges"

    assert picture.main(["--redraw", "--shots", str(tmp_path / "none")]) == 2
    assert "run its case again" in capsys.readouterr().err
