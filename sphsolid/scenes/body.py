"""Bodies: the region a scene is about, able to mesh itself at any spacing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from sphsolid.scenes.hex_mesh import HexMesh, box_mesh


class Body(Protocol):
    """Anything that can be filled with hexahedra."""

    def mesh(self, spacing: float) -> HexMesh:
        """Hexahedra of about ``spacing`` [m] with tagged boundary faces."""
        ...

    @property
    def volume(self) -> float:
        """Exact volume [m^3]."""
        ...


@dataclass(frozen=True)
class Box:
    """Axis-aligned box with faces ``X- X+ Y- Y+ Z- Z+``; ``jitter`` disorders its particles."""

    lower: tuple[float, float, float] = (0.0, 0.0, 0.0)
    upper: tuple[float, float, float] = (1.0, 1.0, 1.0)
    jitter: float = 0.0
    seed: int = 0

    def mesh(self, spacing: float) -> HexMesh:
        """See :func:`sphsolid.scenes.hex_mesh.box_mesh`."""
        return box_mesh(self.lower, self.upper, spacing, self.jitter, self.seed)

    @property
    def volume(self) -> float:
        """Product of the edge lengths [m^3]."""
        volume = 1.0
        for low, high in zip(self.lower, self.upper, strict=True):
            volume *= high - low
        return volume
