"""The nearest stress without a moment, [Lee2017] section 6: what both methods project with."""

from __future__ import annotations

from sphsolid.compiled import inlined
from sphsolid.continuum.tensor import (
    Tensor,
    add,
    axial,
    multiply,
    solve_symmetric,
    transpose,
    vector_cross,
)


@inlined
def project(P: Tensor, F_x: Tensor) -> Tensor:
    """``P^C`` of eqs. (40)-(41)."""
    torque = axial(multiply(P, transpose(F_x)))
    b = multiply(F_x, transpose(F_x))
    trace = b[0] + b[4] + b[8]
    L = (
        trace - b[0], -b[1], -b[2],
        -b[3], trace - b[4], -b[5],
        -b[6], -b[7], trace - b[8],
    )  # fmt: skip
    return add(P, vector_cross(solve_symmetric(L, torque), F_x))
