"""When a run that lasted is of no use: the criteria, stated once and applied to the table."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd

from sphsolid.record.positions import INSIDE_OUT_LIMIT, UNSEEN_LARGEST_LIMIT, UNSEEN_RMS_LIMIT

SOUND, USELESS, LOST, ABSENT = "sound", "useless", "lost", "not applicable"
VERDICTS = (SOUND, USELESS, LOST, ABSENT)

#: Energy made, at any record, over the energy put in so far.
MOST_GAIN = 0.10
#: The same where the whole energy is a seed: at large ``w dt`` the discrete energy of central
#: differences sways by half about what it keeps, so only more than a doubling is growth.
MOST_GAIN_OF_SEED = 1.0
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
    f"made more than {MOST_GAIN:.0%} of the energy put in (seeded cases: more than doubled it)",
    f"kept less than {LEAST_KEPT:.0%} of it (not asked of seeds, which should go)",
    f"the positions folded at some record: unseen motion of neighbours above {UNSEEN_RMS_LIMIT:g} "
    f"rms or {UNSEEN_LARGEST_LIMIT:g} at the largest, or a cell inside out",
    f"J left [{J_RANGE[0]:g}, {J_RANGE[1]:g}] at some record",
    f"the answer is more than {MOST_DEVIATION:.0%} from that of B-bar elements (of half the "
    "spacing, except at 200 and 300 rad/s)",
    "a seed is larger at the end than at the start",
    f"noise in tension grew more than {MOST_GROWTH:g}-fold, or changed a cell edge by more than "
    f"{MOST_CLUMPING:.0%}",
)


def judged(
    table: pd.DataFrame, references: dict[str, str], reference: str, coarse: str
) -> pd.DataFrame:
    """The table with ``reference``, ``deviation``, ``verdict`` and ``why``.

    ``references`` names, for every case, the one whose run by the method ``reference`` is its
    reference, or the run by ``coarse`` if it was not put to it; where none is named the answer is
    not judged.
    """
    lasted = table[table["survived"] == True]  # noqa: E712
    known: dict[str, float] = {}
    for name in (coarse, reference):
        runs = lasted[lasted["method"] == name]
        known |= dict(zip(runs["case"], runs["answer"], strict=True))
    rows = []
    for _, row in table.iterrows():
        right = known.get(references.get(row["case"], ""), math.nan)
        verdict, why = judge(row.to_dict(), right)
        rows.append((right, row["answer"] / right - 1.0 if right else math.nan, verdict, why))
    frame = pd.DataFrame(
        rows, columns=["reference", "deviation", "verdict", "why"], index=table.index
    )
    return pd.concat([table, frame], axis=1)


def judge(row: dict[str, Any], reference: float = math.nan) -> tuple[str, str]:
    """Verdict and reason of one row; ``reference`` is what the answer should be, if known."""
    if row.get("applicable") in (False, 0.0, "False"):
        return ABSENT, str(row["reason"])
    if not row["survived"]:
        return LOST, f"{row['reason']} at {row['lost_time']:.3g} s"
    seeded = row["answer_is"] == "seed left [-]"
    tension = row["answer_is"] == "noise growth [-]"
    gain, kept, answer = row["energy_gain"], row["energy_kept"], row["answer"]
    found = []
    if not gain <= (MOST_GAIN_OF_SEED if seeded else MOST_GAIN):
        found.append(f"made {gain:.2g} of the energy")
    if not seeded and not kept >= LEAST_KEPT:
        found.append(f"kept {kept:.0%} of the energy")
    if is_folded(row):
        found.append(
            f"folded (unseen motion {row['unseen_rms']:.2g}, {row['inside_out']:.1%} inside out)"
        )
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


def is_folded(row: dict[str, Any]) -> bool:
    """True when an indicator of the positions crossed its limit at some record."""
    return bool(
        row["unseen_rms"] > UNSEEN_RMS_LIMIT
        or row["unseen_max"] > UNSEEN_LARGEST_LIMIT
        or row["inside_out"] > INSIDE_OUT_LIMIT
    )


def cell_text(row: dict[str, Any]) -> str:
    """What a heat map says of a run in a few characters: its telling number, or when it ended.

    Of a seed the amplitude that is left, in the energy of the whole body and not only in the mode
    that was seeded.
    """
    if row["verdict"] == ABSENT:
        return "–"
    if row["verdict"] == LOST:
        return f"lost {100.0 * row['lost_time'] / row['end_time']:.0f} %"
    if row["answer_is"] == "seed left [-]":
        return f"x {_short(math.sqrt(abs(row['energy_kept'])))}"
    if row["answer_is"] == "noise growth [-]":
        return f"x {_short(row['answer'])}"
    kept = f"{100.0 * row['energy_kept']:.0f} %"
    return f"{kept} fold {row['unseen_rms']:.2g}" if is_folded(row) else kept


def _short(value: float) -> str:
    if 0.01 <= value < 1000.0:
        return f"{value:.2g}" if value < 10.0 else f"{value:.0f}"
    digits, power = f"{value:.0e}".split("e")
    return f"{digits}e{int(power)}"
