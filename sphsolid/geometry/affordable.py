"""How many cells a spacing would make, asked before they are made."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sphsolid.errors import require

#: More cells than a workstation holds: a particle takes about a kilobyte in a run.
MOST_CELLS = 1.0e8


def check_affordable(sides: Sequence[float], edges: Sequence[float]) -> None:
    """Refuse a grid of ``sides`` [m] with cells of ``edges`` [m] that no memory would hold.

    Raises ``InputError`` for more than :data:`MOST_CELLS` cells, before anything is allocated.
    """
    counts = [max(1.0, side / edge) for side, edge in zip(sides, edges, strict=True)]
    cells = math.prod(counts)
    require(
        cells <= MOST_CELLS,
        f"spacing = {min(edges):g} m makes about {cells:.2g} cells of a body of "
        f"{' x '.join(f'{side:.3g}' for side in sides)} m; at most {MOST_CELLS:.0e} are made here. "
        "Use a larger spacing, and check that it is in metres",
    )
