"""Panels: one scale, equal axes, headings where they belong, and nothing on top of anything."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.look.colours import limits
from sphsolid.look.headings import headings, time_stamp
from sphsolid.look.panels import SIDE, Layout, Sheet, panel_figure
from sphsolid.look.surface import Surface
from sphsolid.look.view import Around, flat_view
from studies.engine.plotting import save_figure
from studies.pictures.shots import Absent, HasDiverged
from tests.oracles.frames import box_shot, twisted

COARSE = Surface(detail=1)
METHODS = ["SUPG-SPH {p,F,J} H1 with a long name", "B-bar FEM"]


def column(label, time):
    return box_shot(
        (-0.5, 0, -0.5), (0.5, 6, 0.5), spacing=0.5, move=twisted(10 * time), label=label, time=time
    )


def plate(label, time):
    return box_shot((0, 0, 0), (1, 0.1, 0.5), spacing=0.1, label=label, time=time)


def grid_of(make, labels=METHODS, times=(0.0, 0.03, 0.1)):
    return [[make(label, time) for time in times] for label in labels]


GRIDS = {
    "methods over times": grid_of(column),
    "times over methods": [list(each) for each in zip(*grid_of(column), strict=True)],
    "one row": grid_of(column, METHODS[:1]),
    "one column": grid_of(plate, times=(0.1,)),
    "one panel": grid_of(plate, METHODS[:1], (0.1,)),
    "flat": grid_of(plate),
    "irregular": [[column(METHODS[0], 0.0), column(METHODS[0], 0.1), column(METHODS[1], 0.1)]],
    "with gaps": [
        [plate("a", 0.0), HasDiverged("a", 0.1, diverged_at=0.0123)],
        [Absent("b", 0.0), plate("b", 0.1)],
    ],
}


def drawn(grid, **options):
    figure = panel_figure(grid, colours=limits(grid), **({"drawing": COARSE} | options))
    figure.draw_without_rendering()
    return figure


def panels_of(figure, grid):
    return figure.axes[1 : 1 + len(grid) * len(grid[0])]


@pytest.mark.parametrize("name", GRIDS)
def test_nothing_overlaps_and_nothing_is_cut_off(name):
    grid = GRIDS[name]
    figure = drawn(grid, layout=Layout(dpi=100))
    page = figure.axes[0]
    texts = [text for text in page.texts if text.get_text()]
    parts = [(text.get_text(), text.get_window_extent()) for text in texts]
    bar, length = figure.axes[-1], page.lines[0]
    parts += [("bar", bar.get_tightbbox()), ("length", length.get_window_extent())]
    parts += [
        (f"panel {k}", axes.get_window_extent())
        for k, axes in enumerate(panels_of(figure, grid))
    ]
    for (a, first), (b, second) in itertools.combinations(parts, 2):
        assert not first.overlaps(second), (a, b)
    width, height = figure.get_size_inches() * 100
    for what, box in parts:
        assert box.x0 >= 0.0, what
        assert box.y0 >= 0.0, what
        assert box.x1 <= width, what
        assert box.y1 <= height, what


def test_a_panel_says_that_its_positions_are_folded():
    sound, folded = column("a", 0.0), replace(column("a", 0.1), folded=True)
    figure = drawn([[sound, folded]])
    said = [[text.get_text() for text in axes.texts] for axes in figure.axes[1:3]]
    assert said == [[], ["folded"]]
    # And no longer, when the next frame of an animation is sound.
    both = Layout(dpi=60)
    sheet = Sheet([[folded]], colours=limits([folded]), view=SIDE, layout=both, drawing=COARSE,
                  window=Around().of([folded.x], SIDE))  # fmt: skip
    for frame, words in ((folded, ["folded"]), (sound, [])):
        sheet.show([[frame]])
        assert [text.get_text() for text in sheet.figure.axes[1].texts] == words


@pytest.mark.parametrize("name", GRIDS)
def test_all_panels_have_equal_axes_and_one_scale(name):
    grid = GRIDS[name]
    figure = drawn(grid, layout=Layout(dpi=100), window=Around(follow=name == "flat"))
    scales = []
    for axes in panels_of(figure, grid):
        origin, a, b = axes.transData.transform([(0, 0), (1, 0), (0, 1)])
        across, upward = a - origin, b - origin
        scales += [across[0], upward[1]]
        assert abs(across[1]) + abs(upward[0]) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(scales, scales[0], rtol=1e-9)
    # The bar of length is as long as it says.
    page = figure.axes[0]
    text = next(t.get_text() for t in page.texts if t.get_text().endswith(" m"))
    metres = float(text.removesuffix(" m"))
    width = np.ptp(page.transData.transform(page.lines[0].get_xydata())[:, 0])
    assert width == pytest.approx(metres * scales[0], rel=1e-6)


def test_the_body_fits_its_panel():
    grid = GRIDS["methods over times"]
    figure = drawn(grid)
    for axes in panels_of(figure, grid):
        points = np.concatenate([p.vertices for p in axes.collections[0].get_paths()])
        for values, limit in zip(points.T, (axes.get_xlim(), axes.get_ylim()), strict=True):
            assert limit[0] < values.min()
            assert values.max() < limit[1]


def test_headings_are_said_once():
    found = headings(GRIDS["methods over times"])
    assert found.rows == METHODS
    assert found.columns == ["t = 0 ms", "t = 30 ms", "t = 100 ms"]
    assert not any(found.panels)
    found = headings(GRIDS["times over methods"])
    assert found.rows == ["t = 0 ms", "t = 30 ms", "t = 100 ms"]
    assert found.columns == METHODS
    found = headings(GRIDS["irregular"])
    assert found.rows == found.columns == []
    assert found.panels[1] == f"{METHODS[0]}\nt = 100 ms"
    assert headings(GRIDS["one panel"]).panels == [f"{METHODS[0]}\nt = 100 ms"]


def test_time_stamps_keep_their_unit():
    assert time_stamp(0.0, 20.0) == "t = 0 s"
    assert time_stamp(0.015, 0.015) == "t = 15 ms"
    assert time_stamp(2e-5, 1e-4) == "t = 20 µs"


def test_panels_without_a_frame_say_why():
    grid = GRIDS["with gaps"]
    texts = [[t.get_text() for t in axes.texts] for axes in panels_of(drawn(grid), grid)]
    assert texts == [[], ["diverged\nat 12.3 ms"], ["not run"], []]


def test_bodies_that_travel_can_be_followed():
    here = plate("a", 0.0)
    there = box_shot((9, 0, 0), (10, 0.1, 0.5), spacing=0.1, label="a", time=1.0)
    grid = [[here, there]]
    figure = drawn(grid, view=flat_view(), window=Around(follow=True))
    first, second = (axes.get_xlim() for axes in panels_of(figure, grid))
    assert np.subtract(second, first) == pytest.approx([9.0, 9.0], abs=1e-5)
    assert np.diff(first) < 1.2


def test_the_largest_figure_keeps_to_its_paper():
    grid = grid_of(plate, [f"method {k}" for k in range(4)], [0.01 * k for k in range(4)])
    width, height = drawn(grid, layout=Layout(width=6.0, height=4.0)).get_size_inches()
    assert width <= 6.0 + 1e-9
    assert height <= 4.0 + 1e-9


def test_what_is_no_grid_is_refused():
    one = plate("a", 0.0)
    colours = limits([one])
    for grid in ([], [[]], [[one, one], [one]], [[Absent("a", 0.0)]]):
        with pytest.raises(InputError):
            panel_figure(grid, colours=colours)
    with pytest.raises(InputError, match="do not fit"):
        panel_figure([[one] * 20], colours=colours, layout=Layout(width=2.0))


@pytest.mark.parametrize("suffix", ["png", "pdf"])
def test_files_repeat(tmp_path, suffix):
    a, b = (
        save_figure(drawn(GRIDS["one panel"]), tmp_path / f"{name}.{suffix}").read_bytes()
        for name in "ab"
    )
    assert a == b
