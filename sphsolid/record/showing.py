"""How a history or a snapshot shows itself: by whatever room draws, which this one does not know.

``sphsolid.look`` takes the place when the package is imported.  Until it draws something, nothing
of matplotlib is loaded.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from sphsolid.errors import require


class Look(Protocol):
    """What draws."""

    def plot(self, history: Any, columns: Sequence[str], against: str) -> Any:
        """Columns of a history."""
        ...

    def picture(self, snapshot: Any, field: str, options: dict[str, Any]) -> Any:
        """A deformed body."""
        ...

    @property
    def can_draw(self) -> bool:
        """Whether what it draws with is installed."""
        ...


_drawn_by: list[Look] = []


def drawn_by(look: Look) -> None:
    """``look`` draws from now on."""
    _drawn_by[:] = [look]


def look() -> Look:
    """What draws; raises ``InputError`` where nothing does."""
    require(len(_drawn_by) > 0, "nothing draws here: import sphsolid first")
    return _drawn_by[0]
