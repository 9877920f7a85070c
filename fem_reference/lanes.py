"""Elements side by side: the layout that lets one instruction work on several of them.

``LANES`` consecutive elements form a block.  A table of a block has the lane as its last and
contiguous index, so the inner loops of the element kernels run over lanes without a branch, which
LLVM turns into vector instructions without changing the order of any sum.  A block that is not
full repeats the last element; nobody reads what it computes there.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import inlined

#: Sixteen doubles are two to four vector registers on today's processors.  With fewer, LLVM
#: unrolls the lane loops before it could vectorise them.
LANES = 16



def blocks(elements: int) -> int:
    """Blocks that hold ``elements``."""
    return -(-elements // LANES)


def side_by_side(table: NDArray[Any]) -> NDArray[Any]:
    """``(E, ...)`` to ``(B, ..., LANES)``; the last element fills the last block."""
    count = blocks(len(table))
    row = np.minimum(np.arange(count * LANES), len(table) - 1)
    lanes = table[row].reshape(count, LANES, *table.shape[1:])
    return np.ascontiguousarray(np.moveaxis(lanes, 1, -1))


def one_by_one(table: NDArray[Any], elements: int) -> NDArray[Any]:
    """``(B, ..., LANES)`` back to ``(E, ...)``."""
    moved = np.moveaxis(table, -1, 1)
    return moved.reshape(-1, *moved.shape[2:])[:elements]


@inlined
def gather_nodes(x, nodes, work):  # type: ignore[no-untyped-def]
    """``x (N, 3)`` at ``nodes (n, LANES)`` to rows ``3 n + i`` of ``work``."""
    for c in range(nodes.shape[0]):
        for lane in range(LANES):
            node = nodes[c, lane]
            work[3 * c, lane] = x[node, 0]
            work[3 * c + 1, lane] = x[node, 1]
            work[3 * c + 2, lane] = x[node, 2]


@inlined
def fill(work, first, rows, value):  # type: ignore[no-untyped-def]
    """Set ``rows`` rows of ``work`` from row ``first`` on."""
    for row in range(first, first + rows):
        for lane in range(LANES):
            work[row, lane] = value


@inlined
def copy_row(work, source, target):  # type: ignore[no-untyped-def]
    """Row ``source`` of ``work`` to row ``target``."""
    for lane in range(LANES):
        work[target, lane] = work[source, lane]


@inlined
def add_row(work, source, target):  # type: ignore[no-untyped-def]
    """Add row ``source`` of ``work`` to row ``target``."""
    for lane in range(LANES):
        work[target, lane] += work[source, lane]


@inlined
def pick(work, first, lane):  # type: ignore[no-untyped-def]
    """The tensor in nine rows of ``work`` from ``first`` on."""
    return (
        work[first, lane], work[first + 1, lane], work[first + 2, lane],
        work[first + 3, lane], work[first + 4, lane], work[first + 5, lane],
        work[first + 6, lane], work[first + 7, lane], work[first + 8, lane],
    )  # fmt: skip


@inlined
def put(A, work, first, lane):  # type: ignore[no-untyped-def]
    """Write the tensor ``A`` into nine rows of ``work`` from ``first`` on."""
    # Written out: a loop over the entries of a tuple would put them into memory.
    work[first, lane] = A[0]
    work[first + 1, lane] = A[1]
    work[first + 2, lane] = A[2]
    work[first + 3, lane] = A[3]
    work[first + 4, lane] = A[4]
    work[first + 5, lane] = A[5]
    work[first + 6, lane] = A[6]
    work[first + 7, lane] = A[7]
    work[first + 8, lane] = A[8]


@inlined
def choose(chosen, A, B):  # type: ignore[no-untyped-def]
    """``A`` where ``chosen``, otherwise ``B``; no branch."""
    return (
        A[0] if chosen else B[0], A[1] if chosen else B[1], A[2] if chosen else B[2],
        A[3] if chosen else B[3], A[4] if chosen else B[4], A[5] if chosen else B[5],
        A[6] if chosen else B[6], A[7] if chosen else B[7], A[8] if chosen else B[8],
    )  # fmt: skip
