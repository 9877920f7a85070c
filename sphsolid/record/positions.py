"""Are the positions those of a body still?  Judged by what no method computes with.

A run can go on to its end with every Jacobian of the method near one while its particles have
folded into a saw tooth: see ``unseen_pairs`` and ``turned_cells``, which say how it is found.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sphsolid.record.placement import NoSecondaryGradient, Placed
from sphsolid.record.snapshot import Snapshot
from sphsolid.record.turned_cells import InsideOut, inside_out, inside_out_secondary
from sphsolid.record.unseen_pairs import UnseenMotion, unseen_motion
from sphsolid.scenes.scene import Scene

#: Root mean square unseen motion above which positions are folded.  Finite elements on the
#: hardest and coarsest bodies here reach 0.26 (held punch of ten cells, pressed to a fifth of its
#: height) and 0.22 (column of three cells at 300 rad/s), sound columns 0.03 to 0.1; columns of
#: particles that fold go from 0.1 to 0.8 within 40 ms and on to 1.5.
UNSEEN_RMS_LIMIT = 0.3
#: The same for the largest: 2.0 at the edge of a held punch of finite elements, 3.3 and more where
#: a part of a body has folded.
UNSEEN_LARGEST_LIMIT = 3.0
#: Share of cells inside out from which positions are folded: a body's cells are never.
INSIDE_OUT_LIMIT = 0.0


@dataclass(frozen=True)
class PositionVerdict:
    """The indicators of an instant: unseen motion, cells and secondary particles inside out."""

    unseen: UnseenMotion
    cells: InsideOut
    secondary: InsideOut

    @property
    def reasons(self) -> tuple[str, ...]:
        """What crossed its limit."""
        found = []
        if self.unseen.rms > UNSEEN_RMS_LIMIT:
            found.append(
                f"unseen motion {self.unseen.rms:.2g} rms is above {UNSEEN_RMS_LIMIT:g}"
            )
        if self.unseen.largest > UNSEEN_LARGEST_LIMIT:
            found.append(
                f"the largest unseen motion {self.unseen.largest:.2g} is above "
                f"{UNSEEN_LARGEST_LIMIT:g}"
            )
        for part, what in ((self.cells, "cells"), (self.secondary, "secondary particles")):
            if part.share > INSIDE_OUT_LIMIT:
                found.append(
                    f"{_percent(part.share)} of the {what} are inside out (smallest det "
                    f"{part.smallest:.2g})"
                )
        return tuple(found)

    @property
    def folded(self) -> bool:
        """True when any indicator crossed its limit."""
        return bool(self.reasons)

    @property
    def indicators(self) -> str:
        """The numbers, in a few words."""
        return (
            f"unseen motion {self.unseen.rms:.2g} rms, {self.unseen.largest:.2g} largest; "
            f"{_percent(self.cells.share)} of the cells inside out, smallest det "
            f"{self.cells.smallest:.2g}"
        )

    def __str__(self) -> str:
        return f"folded: {'; '.join(self.reasons)}" if self.folded else f"sound: {self.indicators}"


def judge_positions(snapshot: Placed) -> PositionVerdict:
    """All indicators of an instant; positions that are not finite have none and are not folded."""
    return PositionVerdict(
        unseen_motion(snapshot), inside_out(snapshot), inside_out_secondary(snapshot)
    )


@dataclass(frozen=True)
class Positions:
    """Unseen motion, and cells inside out: see :func:`judge_positions`."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Four columns; two more where there are secondary particles."""
        verdict = judge_positions(snapshot)
        row = {
            "unseen_rms [-]": verdict.unseen.rms,
            "unseen_max [-]": verdict.unseen.largest,
            "inside_out_share [-]": verdict.cells.share,
            "smallest_det [-]": verdict.cells.smallest,
        }
        if not isinstance(snapshot.secondary, NoSecondaryGradient):
            row["secondary_inside_out_share [-]"] = verdict.secondary.share
            row["secondary_smallest_det [-]"] = verdict.secondary.smallest
        return row


class PositionWatch:
    """What a solver remembers of its positions: the latest verdict, and when they first folded.

    A run looks at them ``every`` so many steps, besides records: a look should cost little beside
    the steps between two.
    """

    def __init__(self, *, every: int) -> None:
        self.every = every
        #: Time [s] of the first look that found them folded, nan while none did.
        self.folded_since = math.nan
        self._latest: tuple[float, PositionVerdict] | None = None

    def look(self, placed: Placed) -> PositionVerdict:
        """Judge and remember."""
        verdict = judge_positions(placed)
        # A solver that was put back has that time before it again.
        if placed.time < self.folded_since:
            self.folded_since = math.nan
        if verdict.folded and math.isnan(self.folded_since):
            self.folded_since = placed.time
        self._latest = placed.time, verdict
        return verdict

    def line(self, placed: Placed) -> str:
        """The verdict now in one line, for a summary."""
        verdict = self.look(placed)
        if verdict.folded:
            return f"positions: folded since t = {self.folded_since:.4g} s; {verdict.indicators}"
        if math.isnan(self.folded_since):
            return f"positions: sound; {verdict.indicators}"
        return (
            f"positions: were folded at t = {self.folded_since:.4g} s, are not now; "
            f"{verdict.indicators}"
        )

    def report(self) -> dict[str, object]:
        """What a file about the run says."""
        if self._latest is None:
            return {"verdict": "not judged"}
        time, verdict = self._latest
        since = None if math.isnan(self.folded_since) else self.folded_since
        return {"verdict": str(verdict), "judged_at_s": time, "folded_since_s": since}


def _percent(share: float) -> str:
    return f"{float(f'{100.0 * share:.2g}'):g} %"
