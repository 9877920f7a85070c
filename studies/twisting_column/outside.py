"""What a code that shares nothing with this one found, and the twist of a sequence against it.

Errors of a lattice change sign on the way to the limit, so a lattice alone can be right by chance.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sphsolid.errors import InputError
from studies.measures.folding import sound
from studies.measures.order import LEVELS, Limit, extrapolate, sign_changes
from studies.measures.tables import select
from studies.twisting_column.runs import INSTANTS, lattice

Array = NDArray[np.float64]
#: Provenance in its first lines, figures below.
TABLE = Path(__file__).with_name("outside_reference.csv")
NAME = "CalculiX C3D20R"


@dataclass(frozen=True)
class Known:
    """``value`` on the finest mesh, ``elements``; ``within``: what a coarser mesh changed."""

    value: float
    within: float
    elements: str


@cache
def figures() -> pd.DataFrame:
    """Columns ``quantity, time_ms, elements, step_ms, value``; rows from coarse to fine."""
    return pd.read_csv(TABLE, comment="#")


@cache
def twist(ms: int = 100) -> Known:
    """The twist [rad] at an instant of :data:`INSTANTS`.

    ``within`` is the distance from the next coarser mesh, or what half the step changed where
    that was tried, whichever is more.
    """
    runs = select(figures(), quantity="twist")
    same = runs.groupby(["time_ms", "elements"])["value"]
    of_the_step = float((same.max() - same.min())[same.size() > 1].max())
    at_step = select(runs, step_ms=runs["step_ms"].max(), time_ms=ms)
    coarse, fine = at_step.iloc[-2:].itertuples()
    return Known(fine.value, max(abs(fine.value - coarse.value), of_the_step), fine.elements)


@cache
def corners() -> float:
    """Mean height [m] of the corners of the top face at 0.1 s."""
    return float(select(figures(), quantity="corners")["value"].iloc[-1])


@dataclass(frozen=True)
class TwistSequence:
    """``cells (n,)`` per metre, ascending, ``twist (n,)`` [rad] at ``ms`` and their ``limit``."""

    cells: list[int]
    twist: Array
    limit: Limit
    ms: int

    @property
    def known(self) -> Known:
        """The outside reference at that instant."""
        return twist(self.ms)

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


def twist_sequence(runs: pd.DataFrame, method: str, ms: int = 100) -> TwistSequence:
    """The lattices of a method whose runs lasted and did not fold; ``runs`` at the usual step.

    Raises ``InputError`` where these are fewer than a limit needs: see :func:`has_limit`.
    """
    own = select(runs, method=method).sort_values("cells")
    own = own[sound(own)]
    if len(own) < LEVELS:
        raise InputError(f"{method}: {len(own)} lattices have no limit; {LEVELS} or more have")
    values = own[f"twist_{ms}"].to_numpy(dtype=float)
    limit = extrapolate(1.0 / own["cells"], values)
    return TwistSequence(own["cells"].astype(int).tolist(), values, limit, ms)


def has_limit(runs: pd.DataFrame, method: str) -> bool:
    """Whether a method has enough lattices."""
    own = select(runs, method=method)
    return int(sound(own).sum()) >= LEVELS


def twist_error(run: pd.Series) -> float:
    """Largest error of the twist at 20, 40, .. 100 ms relative to the outside reference."""
    return max(abs(float(run[f"twist_{ms}"]) / twist(ms).value - 1.0) for ms in INSTANTS)


def sequence_frame(runs: pd.DataFrame, methods: list[str], ms: int = 100) -> pd.DataFrame:
    """A row a method: error [%] of each lattice, limit and its uncertainty [rad], its error [%]."""
    rows, seen = [], set[int]()
    for method in methods:
        if has_limit(runs, method):
            found = twist_sequence(runs, method, ms)
            seen |= set(found.cells)
            errors = {
                lattice(n): 100.0 * error
                for n, error in zip(found.cells, found.errors, strict=True)
            }
            rows.append({"method": method} | errors | {
                "limit": found.limit.value, "±": found.limit.within,
                "limit, %": 100.0 * found.limit_error, "±, %": 100.0 * found.limit_within,
            })  # fmt: skip
    last = ["limit", "±", "limit, %", "±, %"]
    return pd.DataFrame(rows, columns=["method", *map(lattice, sorted(seen)), *last])
