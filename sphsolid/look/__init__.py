"""Looks at what was computed: curves, bodies, comparisons, animations.

Nothing here changes a number, and matplotlib is loaded only when something is drawn.
"""

from sphsolid.look.doors import Looking, animate, compare
from sphsolid.record.showing import drawn_by

drawn_by(Looking())

__all__ = ["animate", "compare"]
