"""Which conservation laws are solved, [Lee2017] section 7: {p,F,H,J} and its reductions.

A field that is not evolved is taken from those that are: ``H = cof F``, ``J = det F``, and
``F = F_x = sum_b x_b (x) G_b`` where the fibre map is not evolved either.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sphsolid.scheme.state import Field


@dataclass(frozen=True)
class Formulation:
    """Evolved strain measures.  Use one of the subclasses."""

    name: ClassVar[str]
    evolves_F: ClassVar[bool]
    evolves_H: ClassVar[bool]
    evolves_J: ClassVar[bool]

    @property
    def fields(self) -> tuple[Field, ...]:
        """What a state has of it: ``p``, ``x``, ``F``, and ``H`` and ``J`` where they evolve."""
        strains: tuple[Field, ...] = (Field("F", "tensor", evolved=self.evolves_F),)
        if self.evolves_H:
            strains += (Field("H", "tensor"),)
        if self.evolves_J:
            strains += (Field("J"),)
        return (Field("p", "vector"), Field("x", "vector", evolved=False), *strains)


@dataclass(frozen=True)
class PF(Formulation):
    """{p, F}: momentum and fibre map."""

    name = "{p,F}"
    evolves_F = True
    evolves_H = False
    evolves_J = False


@dataclass(frozen=True)
class PFJ(Formulation):
    """{p, F, J}: with the volume map, whose law can be stabilised near incompressibility."""

    name = "{p,F,J}"
    evolves_F = True
    evolves_H = False
    evolves_J = True


@dataclass(frozen=True)
class PFHJ(Formulation):
    """{p, F, H, J}: with the area map too, for energies that depend on the cofactor."""

    name = "{p,F,H,J}"
    evolves_F = True
    evolves_H = True
    evolves_J = True


@dataclass(frozen=True)
class PJ(Formulation):
    """{p, J}: the fibre map from the geometry, only the volume map evolved."""

    name = "{p,J}"
    evolves_F = False
    evolves_H = False
    evolves_J = True


@dataclass(frozen=True)
class Displacement(Formulation):
    """Displacement-based total-Lagrangian SPH: every strain from the geometry (the baseline)."""

    name = "displacement"
    evolves_F = False
    evolves_H = False
    evolves_J = False
