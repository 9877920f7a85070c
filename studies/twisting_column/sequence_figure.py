"""The twist over the spacing, lattice by lattice, with its limit and the outside reference."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.ticker import FixedLocator

from studies.report.plotting import outside_legend, panels, save_figure
from studies.twisting_column import outside
from studies.twisting_column.figures import LOOKS
from studies.twisting_column.methods import FEM, H1, H6, LITERAL, TOOLKIT, usual
from studies.twisting_column.sequence import TooFew, twist_sequence

SHOWN = (H1, H6, TOOLKIT, LITERAL, FEM)
_TIMES = (60, 100)
#: Where on the axis of ``h^2`` [m^2] the limits are, side by side about it.
_LIMITS = -0.012


def twist_by_lattice_figure(table: pd.DataFrame, stem: Path) -> Path:
    """Signed error of the twist over ``h^2``; at the left edge the limit and how well it is known.

    Nothing is hidden by a logarithm: where a line crosses zero a lattice is right by chance.
    """
    figure, axes = panels(1, 2, width=4.2, height=3.1)
    for ax, ms in zip(axes.flat, _TIMES, strict=True):
        known = outside.twist(ms)
        share = 100.0 * known.within / known.value
        ax.axhspan(-share, share, color="0.85", label=outside.NAME, zorder=0)
        ax.axhline(0.0, color="0.5", linewidth=0.7)
        cells: set[int] = set()
        for number, label in enumerate(SHOWN):
            found = twist_sequence(usual(table), label, ms)
            if isinstance(found, TooFew):
                continue
            cells |= set(found.cells)
            h2 = 1.0 / np.array(found.cells) ** 2
            ax.plot(h2, 100.0 * found.errors, label=label, **LOOKS[label])
            # Side by side, left of no spacing: limits of several methods are near each other.
            ax.errorbar(
                2.0 * _LIMITS * (1 + number) / (1 + len(SHOWN)), 100.0 * found.limit_error,
                100.0 * found.limit.within / known.value, capsize=2.0,
                **{name: LOOKS[label][name] for name in ("color", "marker")},
            )  # fmt: skip
        marks = sorted(cells & {3, 4, 5, 6, 10})
        ax.xaxis.set_major_locator(FixedLocator([_LIMITS, *(1.0 / n**2 for n in marks)]))
        ax.set_xticklabels(["limit", *(f"1/{n}" for n in marks)])
        ax.axvline(0.0, color="0.5", linewidth=0.7)
        ax.set(title=f"{ms} ms", xlabel="spacing [m], to scale in its square",
               ylabel="error of the twist [%]")  # fmt: skip
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)
