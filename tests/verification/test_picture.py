"""The picture of README, from the command line, on a column of two cells across."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from studies import picture
from studies.methods import PACKAGE
from studies.pictures.frame_file import KeptFrames


def test_the_picture_is_drawn_and_drawn_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.png"
    shots = tmp_path / "shots"
    assert picture.main(["--cells", "2", "--shots", str(shots), "--out", str(out)]) == 0
    first = out.read_bytes()
    shots.rename(tmp_path / "gone")
    assert picture.main(["--redraw", "--out", str(out)]) == 0
    assert out.read_bytes() == first

    frames = KeptFrames(tmp_path / "a.npz")
    kept = [frames.load(PACKAGE.name, time) for time in picture.TIMES]
    assert [shot.time for shot in kept] == list(picture.TIMES)
    # Two of the four sides of 2 x 12 faces are seen, and the top of 2 x 2.
    assert len(kept[0].quads) == 2 * 2 * 12 + 2 * 2
    assert kept[0].x[:, 1].max() == 6.0
    assert len(kept[-1].quads) > len(kept[0].quads), "the top has turned"
    with Image.open(out) as image:
        red, _, blue = np.asarray(image.convert("RGB")).astype(int).transpose(2, 0, 1)
        assert image.width > image.height
    assert (red - blue > 100).mean() > 0.001, "tension along the edges"

    assert picture.main(["--redraw", "--out", str(tmp_path / "none.png")]) == 2
    assert "run what makes it again" in capsys.readouterr().err
