"""When a run that lasted is of no use: the criteria, stated once, and the map of all runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from sphsolid.errors import InputError
from sphsolid.record.positions import UNSEEN_LARGEST_LIMIT, UNSEEN_RMS_LIMIT
from studies.engine.plotting import panels
from studies.methods import B_BAR
from studies.stability.hard_cases import REFERENCE
from studies.stability.hard_problems import NOISE_GROWTH, SEED_LEFT

SOUND, USELESS, DIVERGED, ABSENT = "sound", "useless", "diverged", "not applicable"
COLOURS = {SOUND: "#9fd8c0", USELESS: "#f6cf7a", DIVERGED: "#d9765c", ABSENT: "#ececec"}
#: Energy made, at any record, over the energy put in so far.  Where the whole energy is a seed: at
#: large ``w dt`` the discrete energy of central differences sways by half about what it keeps, so
#: only more than a doubling is growth.
MOST_GAIN, MOST_GAIN_OF_SEED = 0.10, 1.0
#: Energy left of what was put in.
LEAST_KEPT = 0.5
#: Range of ``J``; no solid here is compressed or stretched by more than a tenth or two.
J_RANGE = (0.5, 1.5)
#: Distance of the answer from the reference's, relative.
MOST_DEVIATION = 0.15
#: Share of a seed that is left.
MOST_LEFT = 1.0
#: Growth of the noise of the pulled block, and the change of a cell edge by it.
MOST_GROWTH, MOST_CLUMPING = 10.0, 0.1

CRITERIA = (
    f"It made more than {MOST_GAIN:.0%} of the energy put in (seeded cases: more than doubled it).",
    f"It kept less than {LEAST_KEPT:.0%} of it (not asked of seeds, which should go).",
    f"The positions folded: unseen motion of neighbours above {UNSEEN_RMS_LIMIT:g} rms or "
    f"{UNSEEN_LARGEST_LIMIT:g} at the largest, or a cell inside out.",
    f"J left [{J_RANGE[0]:g}, {J_RANGE[1]:g}] at some record.",
    f"The answer is more than {MOST_DEVIATION:.0%} from that of B-bar elements (of half the "
    "spacing where those were run).",
    "A seed is larger at the end than at the start.",
    f"Noise in tension grew more than {MOST_GROWTH:g}-fold, or changed a cell edge by more than "
    f"{MOST_CLUMPING:.0%}.",
)


def judged(table: pd.DataFrame, references: Mapping[str, str]) -> pd.DataFrame:
    """The table with ``reference``, ``deviation``, ``verdict`` and, in ``why``, its reason.

    ``references`` names, for every case, the one whose run with elements of half the spacing is its
    reference, or with elements of the same where there is none; where no case is named the answer
    is not judged.
    """
    lasted = table[table["survived"] == True]  # noqa: E712
    known: dict[str, float] = {}
    for method in (B_BAR, REFERENCE):
        runs = lasted[lasted["method"] == method.name]
        known |= dict(zip(runs["case"], runs["answer"], strict=True))
    right = [known.get(references.get(case, ""), math.nan) for case in table["case"]]
    found = [judge(*each) for each in zip(table.to_dict("records"), right, strict=True)]
    columns = {"verdict": [verdict for verdict, _ in found], "why": [why for _, why in found]}
    deviation = table["answer"].astype(float) / right - 1.0
    return table.assign(reference=right, deviation=deviation, **columns)


def judge(row: Mapping[str, Any], reference: float = math.nan) -> tuple[str, str]:
    """Verdict and reason of one row; ``reference`` is what the answer should be, if known."""
    if not row["applicable"]:
        return ABSENT, row["why"]
    if not row["survived"]:
        return DIVERGED, f"{row['why']} at {row['diverged_at']:.3g} s"
    seeded, tension = row["answer_is"] == SEED_LEFT, row["answer_is"] == NOISE_GROWTH
    gain, kept, answer = row["energy_gain"], row["energy_kept"], row["answer"]
    found = []
    if not gain <= (MOST_GAIN_OF_SEED if seeded else MOST_GAIN):
        found.append(f"made {gain:.2g} of the energy")
    if not seeded and not kept >= LEAST_KEPT:
        found.append(f"kept {kept:.0%} of the energy")
    if row["folded"]:
        unseen = f"unseen motion {row['unseen_rms']:.2g}, {row['inside_out']:.1%} inside out"
        found.append(f"folded ({unseen})")
    if not (row["J_min"] >= J_RANGE[0] and row["J_max"] <= J_RANGE[1]):
        found.append(f"J {row['J_min']:.2f} to {row['J_max']:.2f}")
    if not (seeded or tension or math.isnan(reference)):
        deviation = answer / reference - 1.0
        if not abs(deviation) <= MOST_DEVIATION:
            found.append(f"answer off by {deviation:+.0%}")
    if seeded and not answer <= MOST_LEFT:
        found.append(f"seed grew {answer:.2g}-fold")
    if tension and not (answer <= MOST_GROWTH and row["clumping"] <= MOST_CLUMPING):
        found.append(f"noise grew {answer:.2g}-fold, edges by {row['clumping']:.0%}")
    return (USELESS, "; ".join(found)) if found else (SOUND, "")


def cell_text(row: Mapping[str, Any]) -> str:
    """What the map says of a run in a few characters: its telling number, or when it ended.

    Of a seed the amplitude that is left, in the energy of the whole body and not only in the mode
    that was seeded.
    """
    if row["verdict"] == ABSENT:
        return "–"
    if row["verdict"] == DIVERGED:
        return f"div. {100.0 * row['diverged_at'] / row['end_time']:.0f} %"
    if row["answer_is"] == SEED_LEFT:
        return f"x {_short(math.sqrt(abs(row['energy_kept'])))}"
    if row["answer_is"] == NOISE_GROWTH:
        return f"x {_short(row['answer'])}"
    kept = f"{100.0 * row['energy_kept']:.0f} %"
    return f"{kept} fold {row['unseen_rms']:.2g}" if row["folded"] else kept


def _short(value: float) -> str:
    if 0.01 <= value < 1000.0:
        return f"{value:.2g}" if value < 10.0 else f"{value:.0f}"
    digits, power = f"{value:.0e}".split("e")
    return f"{digits}e{int(power)}"


def overview(table: pd.DataFrame, labels: Mapping[str, str]) -> Figure:
    """Cases against the methods in ``labels`` (name: what stands above the column)."""
    shown = [name for name in labels if name in set(table["method"])]
    part = table[table["method"].isin(shown)]
    if not len(part):
        raise InputError(f"no run of {', '.join(labels)}: run studies.stability without --part")
    cases = list(dict.fromkeys(part["case"]))
    code = np.zeros((len(cases), len(shown)))
    figure, axes = panels(1, 1, width=7.4, height=1.6 + 0.21 * len(cases))
    ax = axes[0, 0]
    for row in part.to_dict("records"):
        i, j = cases.index(row["case"]), shown.index(row["method"])
        code[i, j] = 1 + list(COLOURS).index(row["verdict"])
        ax.text(j, i, cell_text(row), ha="center", va="center", size=6.2)
    colours = ListedColormap(["#ffffff", *COLOURS.values()])
    norm = BoundaryNorm(np.arange(-0.5, colours.N), colours.N)
    ax.imshow(code, cmap=colours, norm=norm, aspect="auto")
    _frame(ax, cases, [labels[name] for name in shown])
    patches = [Patch(facecolor=colour, label=name) for name, colour in COLOURS.items()]
    figure.legend(handles=patches, loc="outside lower center", ncols=4)
    return figure


def _frame(ax: Any, rows: Sequence[str], columns: Sequence[str]) -> None:
    """Names at the left and above; white lines between the cells."""
    ax.set_yticks(range(len(rows)), rows)
    ax.set_xticks(range(len(columns)), columns, rotation=40, ha="left", rotation_mode="anchor")
    ax.xaxis.tick_top()
    ax.set_xticks(np.arange(0.5, len(columns) - 1), minor=True)
    ax.set_yticks(np.arange(0.5, len(rows) - 1), minor=True)
    ax.grid(visible=False, which="major")
    ax.grid(which="minor", color="white", linewidth=1.0)
    ax.tick_params(which="both", length=0, labelsize=6.9)
    for side in ax.spines.values():
        side.set_visible(False)
