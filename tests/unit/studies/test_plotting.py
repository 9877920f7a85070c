"""Figures: guides that are where they say, bytes that repeat, looks that tell methods apart."""

from __future__ import annotations

import numpy as np
import pytest

from studies.engine.plotting import (
    Curve,
    convergence_panel,
    outside_legend,
    panels,
    save_figure,
    style,
)
from studies.methods import METHODS


def test_methods_can_be_told_apart_and_keep_their_look():
    looks = [method.look for method in METHODS.values()]
    assert len({(look["color"], look["marker"]) for look in looks}) == len(looks)


def drawn():
    h = np.array([1 / 4, 1 / 8, 1 / 16])
    figure, axes = panels(1, 2)
    good = Curve("two", h, 0.3 * h**2, {"marker": "s"})
    flat = Curve("flat", h, [0.2, 0.19, float("nan")])
    convergence_panel(axes[0, 0], [good, flat], title="p_x")
    convergence_panel(axes[0, 1], [Curve("none", h, [np.nan] * 3)])
    outside_legend(figure, axes.flat)
    return figure, axes


def test_reference_lines_have_their_slopes_and_cover_no_data():
    _, axes = drawn()
    ax = axes[0, 0]
    guides = [line for line in ax.lines if line.get_linestyle() == ":"]
    slopes = [np.diff(np.log(g.get_ydata()))[0] / np.diff(np.log(g.get_xdata()))[0] for g in guides]
    assert slopes == pytest.approx([1.0, 2.0])
    for line in ax.lines:
        if line in guides:
            continue
        h, error = line.get_xdata(), line.get_ydata()
        upper, lower = (np.interp(np.log(h), np.log(g.get_xdata()), np.log(g.get_ydata()))
                        for g in guides)  # fmt: skip
        assert np.all(np.log(error) < upper)
        assert np.all(np.log(error) > lower)
    low, high = ax.get_ylim()
    assert low < min(g.get_ydata().min() for g in guides)
    assert high > max(g.get_ydata().max() for g in guides)


def test_labels_ticks_and_legend():
    figure, axes = drawn()
    ax = axes[0, 0]
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["1/16", "1/8", "1/4"]
    assert "[m]" in ax.get_xlabel()
    assert len(ax.lines[1].get_xdata()) == 2, "a missing error is left out"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["two", "flat"]
    assert "no data" in [text.get_text() for text in axes[0, 1].texts]
    figure.draw_without_rendering()
    legend = figure.legends[0].get_window_extent()
    assert not any(legend.overlaps(each.get_window_extent()) for each in axes.flat)


def test_files_repeat(tmp_path):
    for name in ("a.png", "b.png", "a.pdf", "b.pdf"):
        with style():
            path = tmp_path / "new" / name
            assert save_figure(drawn()[0], path) == path
    for suffix in ("png", "pdf"):
        a, b = ((tmp_path / "new" / f"{name}.{suffix}").read_bytes() for name in "ab")
        assert a == b
        assert len(a) > 1000
