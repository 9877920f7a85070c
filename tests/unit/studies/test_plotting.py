"""Figures: looks that tell methods apart, guides that are where they say, bytes that repeat."""

from __future__ import annotations

import numpy as np
import pytest

from studies.report.plotting import (
    Curve,
    convergence_panel,
    method_look,
    outside_legend,
    panels,
    save_figure,
    style,
)

FORMULATIONS = ["{p,F}", "{p,F,J}", "{p,F,H,J}", "{p,J}", "displacement SPH", "B-bar FEM"]


def test_methods_can_be_told_apart_and_keep_their_look():
    looks = [method_look(name) for name in FORMULATIONS]
    assert len({(look["color"], look["marker"]) for look in looks}) == len(FORMULATIONS)
    assert method_look("{p, F} SUPG-SPH") == method_look("{p,F}")
    assert method_look("a new one") == method_look("a new one")
    h6 = method_look("{p,F}", secondary="H6", operator="Literal")
    assert h6["linestyle"] == "--"
    assert h6["markerfacecolor"] == "white"
    assert h6["color"] == looks[0]["color"]


def drawn():
    h = np.array([1 / 4, 1 / 8, 1 / 16])
    figure, axes = panels(1, 2)
    good = Curve("two", h, 0.3 * h**2, method_look("{p,F}"))
    flat = Curve("flat", h, [0.2, 0.19, float("nan")], method_look("{p,F,J}"))
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


def test_files_repeat(tmp_path):
    for name in ("a", "b"):
        with style():
            figure, _ = drawn()
            assert save_figure(figure, tmp_path / "new" / name) == tmp_path / "new" / name
    for suffix in ("png", "pdf"):
        a, b = ((tmp_path / "new" / f"{name}.{suffix}").read_bytes() for name in "ab")
        assert a == b
        assert len(a) > 1000


def test_legend_is_outside_the_panels():
    figure, axes = drawn()
    figure.draw_without_rendering()
    legend = figure.legends[0].get_window_extent()
    for ax in axes.flat:
        assert not legend.overlaps(ax.get_window_extent())
