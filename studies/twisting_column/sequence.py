"""The twist on a sequence of lattices, its limit, and both against the outside reference.

Errors of a lattice change sign on the way to the limit, so a lattice alone can be right by chance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from studies.convergence.figures import select
from studies.report.extrapolate import LEVELS, Limit, extrapolate, sign_changes
from studies.report.folding import sound
from studies.twisting_column import outside
from studies.twisting_column.methods import lattice

Array = NDArray[np.float64]
#: How near to the outside one, and how well known, the limit of a sequence must be.
SAME_LIMIT = 0.005


@dataclass(frozen=True)
class TwistSequence:
    """``cells (n,)`` per metre, ascending, ``twist (n,)`` [rad] at ``ms`` and their ``limit``."""

    cells: list[int]
    twist: Array
    limit: Limit
    ms: int

    @property
    def known(self) -> outside.Known:
        """The outside reference at that instant."""
        return outside.twist(self.ms)

    @property
    def errors(self) -> Array:
        """Of each lattice, relative to the outside reference ``(n,)``."""
        return self.twist / self.known.value - 1.0

    @property
    def limit_error(self) -> float:
        """The same of the limit."""
        return self.limit.value / self.known.value - 1.0

    @property
    def limit_within(self) -> float:
        """What both limits may be off, as a share of the outside one."""
        return (self.limit.within + self.known.within) / self.known.value

    def text(self) -> str:
        """Errors in order of lattices, the limit, and where the sign changes."""
        listed = ", ".join(
            f"{lattice(n)} {100 * error:+.1f}"
            for n, error in zip(self.cells, self.errors, strict=True)
        )
        words = (
            f"{listed} %, limit {self.limit.value:.3f} ± {self.limit.within:.3f} rad "
            f"({100 * self.limit_error:+.2f} %)"
        )
        for k in sign_changes(self.errors):
            words += (
                f", sign changes between {lattice(self.cells[k])} and "
                f"{lattice(self.cells[k + 1])}: no lattice alone decides"
            )
        return words


@dataclass(frozen=True)
class TooFew:
    """In the place of a sequence of fewer lattices than a limit needs."""


def twist_sequence(runs: pd.DataFrame, label: str, ms: int = 100) -> TwistSequence | TooFew:
    """The lattices of a method whose runs lasted and did not fold; ``runs`` at the usual step."""
    own = select(runs, label=label).sort_values("cells")
    own = own[sound(own)]
    twist = own[f"twist_{ms}"].to_numpy(dtype=float)
    if len(own) < LEVELS:
        return TooFew()
    cells = own["cells"].astype(int).tolist()
    return TwistSequence(cells, twist, extrapolate(1.0 / own["cells"], twist), ms)


def twist_error(run: pd.Series) -> float:
    """Largest error of the twist at 20, 40, .. 100 ms relative to the outside reference."""
    return max(
        abs(float(run[f"twist_{ms}"]) / outside.twist(ms).value - 1.0) for ms in outside.INSTANTS
    )


def sequence_frame(runs: pd.DataFrame, labels: list[str], ms: int = 100) -> pd.DataFrame:
    """A row a method: error [%] of each lattice, limit and its uncertainty [rad], its error [%]."""
    rows = []
    for label in labels:
        found = twist_sequence(runs, label, ms)
        if isinstance(found, TooFew):
            continue
        row: dict[str, object] = {"method": label}
        row |= {
            lattice(n): 100.0 * error for n, error in zip(found.cells, found.errors, strict=True)
        }
        row |= {
            "limit": found.limit.value, "±": found.limit.within,
            "limit, %": 100.0 * found.limit_error, "±, %": 100.0 * found.limit_within,
        }  # fmt: skip
        rows.append(row)
    frame = pd.DataFrame(rows)
    last = ["limit", "±", "limit, %", "±, %"]
    return frame.reindex(columns=["method", *_ordered(frame, last), *last])


def _ordered(frame: pd.DataFrame, last: list[str]) -> list[str]:
    names = [name for name in frame.columns if name not in ("method", *last)]
    return sorted(names, key=lambda name: int(name.split("x")[0]))
