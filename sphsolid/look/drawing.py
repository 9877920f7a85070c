"""Figures that show themselves in a notebook, without pyplot and without a display."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sphsolid.errors import require
from sphsolid.paths import path_of

#: Dots per inch on a screen.
_SCREEN = 110


class Drawing(Figure):
    """A figure of matplotlib with a canvas of its own; ``savefig(path)`` writes it."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        FigureCanvasAgg(self)

    def png(self, *, dpi: int = _SCREEN) -> bytes:
        """The picture as the bytes of a PNG file."""
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
        return buffer.getvalue()

    def save(self, path: str | Path, *, dpi: int = 200) -> Path:
        """Write it by the suffix of ``path``; returns the path.

        Raises ``InputError`` for a folder that is not there, and for a suffix of no known kind.
        """
        place = path_of(path)
        require(place.parent.is_dir(), f"there is no folder {place.parent} for {place.name}")
        known = self.canvas.get_supported_filetypes()
        require(
            place.suffix[1:].lower() in known,
            f"{place.name}: a picture's name ends with one of {', '.join(sorted(known))}",
        )
        self.savefig(place, dpi=dpi)
        return place

    def _repr_png_(self) -> bytes:
        return self.png()
