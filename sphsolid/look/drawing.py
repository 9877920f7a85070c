"""Figures that show themselves in a notebook, without pyplot and without a display."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

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
        """Write it by the suffix of ``path``; returns the path."""
        self.savefig(path, dpi=dpi)
        return Path(path)

    def _repr_png_(self) -> bytes:
        return self.png()
