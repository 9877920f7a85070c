"""Cases of a study that costs nothing; workers import this module by its name."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

from sphsolid.errors import Diverged


def power_law(
    *, h: float, order: float, factor: float = 1.0, log: str = ""
) -> list[dict[str, Any]]:
    """Errors that follow ``factor h^order``; ``log`` counts how often this really ran."""
    if log:
        with Path(log).open("a") as file:
            file.write(f"{h}\n")
    method, error = f"order {order:g}", factor * h**order
    return [
        {"method": method, "component": "p_x", "h": h, "error": error},
        {"method": method, "component": "P_xx", "h": h, "error": 3.0 * error},
    ]


def diverges(*, h: float) -> list[dict[str, Any]]:
    """A solution that is lost."""
    raise Diverged("J = -0.1", 0.25, 12, 3, (0.0, h, 1.0), "a smaller CFL")


def breaks() -> list[dict[str, Any]]:
    """A mistake in the study itself."""
    return [{"error": 1.0 / 0.0}]


def dies() -> list[dict[str, Any]]:
    """A process killed from outside."""
    os._exit(9)


def sleeps(*, seconds: float) -> list[dict[str, Any]]:
    """A case that takes its time."""
    time.sleep(seconds)
    return [{"h": seconds, "error": seconds, "threads": os.environ["NUMBA_NUM_THREADS"]}]
