"""Axis-aligned boxes and their union: checked, and with the planes of their sides."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.given import Triple, triple
from sphsolid.geometry.mesh_defects import COINCIDENT

Array = NDArray[np.float64]
#: A box by its lower and upper corner [m].
Block = tuple[Triple, Triple]


def checked_box(lower: object, upper: object) -> Block:
    """The corners [m] of one box, checked; raises ``InputError`` as :func:`checked_blocks`."""
    return checked_blocks(((lower, upper),))[0]


def checked_blocks(blocks: object) -> tuple[Block, ...]:
    """The boxes with numbers as floats, and sides that differ by round-off in one plane.

    ``0.1 + 0.2`` is not ``0.3``: sides that are at most :data:`COINCIDENT` of the diagonal of the
    body apart are meant to be one.  They all take the least of their places.  Raises
    ``InputError`` for what is no box, or a box that is flat by then.
    """
    corners = np.array([_corners(k, each) for k, each in enumerate(_listed(blocks))])
    reach = COINCIDENT * float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))
    for d in range(3):
        places = np.unique(corners[:, :, d])
        fresh = np.diff(places, prepend=-np.inf) > reach
        plane = places[fresh][np.cumsum(fresh) - 1]
        corners[:, :, d] = plane[np.searchsorted(places, corners[:, :, d])]
    found: list[Block] = []
    for (low, high), (lower, upper) in zip(corners.tolist(), _listed(blocks), strict=True):
        require(
            all(b > a for a, b in zip(low, high, strict=True)),
            f"box upper {upper} must exceed lower {lower} in every axis, by more than "
            f"{COINCIDENT:g} of the diagonal of the body",
        )
        found.append((tuple(low), tuple(high)))
    return tuple(found)


def block_breaks(blocks: tuple[Block, ...]) -> list[list[float]]:
    """Ascending coordinates [m] of all sides of checked boxes, by axis."""
    return [sorted({corner[d] for block in blocks for corner in block}) for d in range(3)]


def covered(
    blocks: tuple[Block, ...], planes: tuple[Array, Array, Array]
) -> NDArray[np.bool_]:
    """Which cells ``(nx, ny, nz)`` between the planes have their centre in a checked box."""
    centres = [0.5 * (p[:-1] + p[1:]) for p in planes]
    keep = np.zeros([len(c) for c in centres], dtype=bool)
    for lower, upper in blocks:
        inside = [(lower[d] < c) & (c < upper[d]) for d, c in enumerate(centres)]
        keep |= inside[0][:, None, None] & inside[1][:, None] & inside[2]
    return keep


def _listed(blocks: object) -> list[tuple[object, object]]:
    """Pairs of corners, of which nothing is known yet."""
    wanted = "give boxes ((X, Y, Z), (X, Y, Z)), lower and upper corner in m"
    if not isinstance(blocks, list | tuple | np.ndarray):
        raise InputError(f"blocks = {blocks!r} is not a tuple of boxes; {wanted}")
    require(len(blocks) > 0, f"a body needs at least one block; {wanted}")
    pairs = []
    for k, each in enumerate(blocks):
        if not isinstance(each, list | tuple | np.ndarray) or len(each) != 2:
            raise InputError(
                f"blocks[{k}] = {each!r} is no box; {wanted}, and put a lone one into a tuple: "
                "((lower, upper),)"
            )
        pairs.append((each[0], each[1]))
    return pairs


def _corners(k: int, pair: tuple[object, object]) -> Block:
    of = f"box {k}: " if k else ""
    lower, upper = pair
    return triple(f"{of}lower", lower, "m"), triple(f"{of}upper", upper, "m")
