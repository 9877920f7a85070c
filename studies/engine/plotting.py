"""One look for all figures: style, palette, convergence panels, files.

Figures are made without pyplot, so nothing needs a display and nothing is shared between them.
The palette is that of Okabe and Ito, which colour-blind readers can tell apart; markers and line
styles say the same again.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator
from numpy.typing import NDArray
from PIL import Image

from sphsolid.look.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PALETTE,
    PURPLE,
    SKY,
    VERMILION,
    YELLOW,
    style,
)  # fmt: skip

__all__ = [
    "BLACK", "BLUE", "GREEN", "ORANGE", "PALETTE", "PURPLE", "SKY", "VERMILION", "YELLOW", "Curve",
    "convergence_panel", "outside_legend", "panels", "save_figure", "style",
]  # fmt: skip

def panels(
    rows: int, columns: int, *, width: float = 3.0, height: float = 2.9
) -> tuple[Figure, NDArray[Any]]:
    """A figure and its ``(rows, columns)`` axes, each about ``width x height`` [inch]."""
    with style():
        figure = Figure(figsize=(width * columns, height * rows + 0.5), layout="constrained")
        FigureCanvasAgg(figure)
        return figure, figure.subplots(rows, columns, squeeze=False)


@dataclass(frozen=True)
class Curve:
    """One family of refinements: spacings ``h`` [m] and errors, with a label and line keywords."""

    label: str
    h: Sequence[float]
    error: Sequence[float]
    look: dict[str, Any] = field(default_factory=dict)


def convergence_panel(
    axes: Axes,
    curves: Iterable[Curve],
    *,
    title: str = "",
    x_label: str = "particle spacing h [m]",
    y_label: str = "relative L2 error [-]",
    slopes: Sequence[int] = (1, 2),
) -> None:
    """Error over spacing on log axes, with a reference line for each of ``slopes``.

    The shallowest reference line stays above all points and every other below, so neither lines
    nor their labels cover data.  Points that are not positive and finite are left out.
    """
    drawn = []
    for curve in curves:
        h, error = np.asarray(curve.h, dtype=float), np.asarray(curve.error, dtype=float)
        good = np.isfinite(error) & (error > 0.0)
        order = np.argsort(h[good])
        h, error = h[good][order], error[good][order]
        if len(h):
            axes.plot(h, error, label=curve.label, **({"marker": "o"} | curve.look))
            drawn.append((h, error))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set(title=title, xlabel=x_label, ylabel=y_label)
    if not drawn:
        axes.text(0.5, 0.5, "no data", transform=axes.transAxes, ha="center", va="center")
        return
    h = np.unique(np.concatenate([pair[0] for pair in drawn]))
    _spacing_ticks(axes, h)
    if len(h) > 1:
        _reference_lines(axes, drawn, h, sorted(slopes))


def _reference_lines(
    axes: Axes,
    drawn: list[tuple[NDArray[np.float64], NDArray[np.float64]]],
    h: NDArray[np.float64],
    slopes: list[int],
) -> None:
    ends = h[[0, -1]]
    for number, slope in enumerate(slopes):
        ratio = np.concatenate([error / spacing**slope for spacing, error in drawn])
        above = number == 0 and len(slopes) > 1
        level = 1.8 * ratio.max() if above else ratio.min() / 1.8 ** max(1, number)
        axes.plot(ends, level * ends**slope, color="0.55", linewidth=0.8, linestyle=":", zorder=1)
        # The line rises to the right: above its right end and below its left end nothing is hit.
        at = ends[-1] if above else ends[0]
        axes.annotate(
            f"slope {slope}",
            (at, level * at**slope),
            xytext=(0, 3) if above else (0, -3),
            textcoords="offset points",
            ha="right" if above else "left",
            va="bottom" if above else "top",
            color="0.4",
            size=7.5,
        )
    low, high = axes.get_ylim()
    axes.set_ylim(low / 1.8, high * 1.8)


def _spacing_ticks(axes: Axes, h: NDArray[np.float64]) -> None:
    inverse = np.rint(1.0 / h)
    whole = np.allclose(h * inverse, 1.0, rtol=1e-6)
    texts = [
        f"1/{int(n)}" if whole and n > 1 else f"{value:.3g}"
        for n, value in zip(inverse, h, strict=True)
    ]
    axes.xaxis.set_major_locator(FixedLocator(h.tolist()))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xticklabels(texts)


def outside_legend(figure: Figure, axes: Iterable[Axes], *, columns: int = 3) -> None:
    """One legend under all panels, each label once: it can cover nothing."""
    found: dict[str, Any] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    if found:
        figure.legend(
            list(found.values()), list(found), loc="outside lower center", ncols=columns
        )


def for_a_report(figure: Figure, path: Path) -> Path:
    """Write ``path`` with the suffix that suits: lines as a PDF, coloured bodies as a JPEG.

    A PDF keeps pixels without loss, ten times as large, and reports are kept in the repository.
    """
    if not figure.findobj(lambda artist: bool(artist.get_rasterized())):
        return save_figure(figure, path.with_suffix(".pdf"))
    path = path.with_suffix(".jpg")
    path.parent.mkdir(parents=True, exist_ok=True)
    with style():
        small = {"quality": 70, "optimize": True, "progressive": True}
        figure.savefig(path, dpi=150, pil_kwargs=small)
    return path


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a PDF, or a PNG with 170 dpi, by the suffix of ``path``; no date or version in it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    nothing: dict[str, Any] = {"CreationDate": None, "Creator": None, "Producer": None}
    with style():
        if path.suffix == ".png":
            drawn = io.BytesIO()
            figure.savefig(drawn, dpi=170, metadata={"Software": None})
            # 256 colours of its own: a third of the size, and nobody sees a difference.
            with Image.open(drawn) as image:
                # Rare colours too, such as the ends of a colour bar.
                few = image.convert("RGB").quantize(
                    256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
                )
            few.save(path, optimize=True)
        else:
            figure.savefig(path, metadata=nothing)
    return path
