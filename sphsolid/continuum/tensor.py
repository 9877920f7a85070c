"""3x3 algebra on nine numbers, written once for every use.

A second-order tensor is a tuple of nine entries in row order, ``A = (A11, A12, A13, A21, ...)``.
The functions use nothing but + - * /, so the entries may be of several kinds.  Floats serve inside
a compiled kernel, where no memory is touched.  Complex numbers serve complex-step derivatives.
Numpy arrays of equal shape serve all particles at once.

The tensor cross product and its algebra are those of [Bonet2016]:
``(A x B)_iI = eps_ijk eps_IJK A_jJ B_kK``, ``cof F = (F x F) / 2``, ``det F = cof F : F / 3``.
"""

from __future__ import annotations

from typing import Any

from sphsolid.compiled import inlined

#: Nine entries in row order; see the module text for what an entry may be.
Tensor = tuple[Any, Any, Any, Any, Any, Any, Any, Any, Any]
#: Three entries.
Vector = tuple[Any, Any, Any]

IDENTITY: Tensor = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@inlined
def load(field: Any, a: int) -> Tensor:
    """Tensor of particle ``a`` from ``field (N, 3, 3)``."""
    return (
        field[a, 0, 0], field[a, 0, 1], field[a, 0, 2],
        field[a, 1, 0], field[a, 1, 1], field[a, 1, 2],
        field[a, 2, 0], field[a, 2, 1], field[a, 2, 2],
    )  # fmt: skip


@inlined
def store(A: Tensor, field: Any, a: int) -> None:
    """Write ``A`` into row ``a`` of ``field (N, 3, 3)``."""
    field[a, 0, 0] = A[0]
    field[a, 0, 1] = A[1]
    field[a, 0, 2] = A[2]
    field[a, 1, 0] = A[3]
    field[a, 1, 1] = A[4]
    field[a, 1, 2] = A[5]
    field[a, 2, 0] = A[6]
    field[a, 2, 1] = A[7]
    field[a, 2, 2] = A[8]


@inlined
def add(A: Tensor, B: Tensor) -> Tensor:
    """``A + B``."""
    return (
        A[0] + B[0], A[1] + B[1], A[2] + B[2],
        A[3] + B[3], A[4] + B[4], A[5] + B[5],
        A[6] + B[6], A[7] + B[7], A[8] + B[8],
    )  # fmt: skip


@inlined
def scale(s: Any, A: Tensor) -> Tensor:
    """``s A``."""
    return (
        s * A[0], s * A[1], s * A[2],
        s * A[3], s * A[4], s * A[5],
        s * A[6], s * A[7], s * A[8],
    )  # fmt: skip


@inlined
def axpy(s: Any, A: Tensor, B: Tensor) -> Tensor:
    """``s A + B``."""
    return (
        s * A[0] + B[0], s * A[1] + B[1], s * A[2] + B[2],
        s * A[3] + B[3], s * A[4] + B[4], s * A[5] + B[5],
        s * A[6] + B[6], s * A[7] + B[7], s * A[8] + B[8],
    )  # fmt: skip


@inlined
def contract(A: Tensor, B: Tensor) -> Any:
    """``A : B = A_iI B_iI``."""
    return (
        A[0] * B[0] + A[1] * B[1] + A[2] * B[2]
        + A[3] * B[3] + A[4] * B[4] + A[5] * B[5]
        + A[6] * B[6] + A[7] * B[7] + A[8] * B[8]
    )  # fmt: skip


@inlined
def cross(A: Tensor, B: Tensor) -> Tensor:
    """Tensor cross product ``(A x B)_iI = eps_ijk eps_IJK A_jJ B_kK`` ([Bonet2016] eq. (7))."""
    return (
        A[4] * B[8] - A[5] * B[7] + A[8] * B[4] - A[7] * B[5],
        A[5] * B[6] - A[3] * B[8] + A[6] * B[5] - A[8] * B[3],
        A[3] * B[7] - A[4] * B[6] + A[7] * B[3] - A[6] * B[4],
        A[2] * B[7] - A[1] * B[8] + A[7] * B[2] - A[8] * B[1],
        A[0] * B[8] - A[2] * B[6] + A[8] * B[0] - A[6] * B[2],
        A[1] * B[6] - A[0] * B[7] + A[6] * B[1] - A[7] * B[0],
        A[1] * B[5] - A[2] * B[4] + A[5] * B[1] - A[4] * B[2],
        A[2] * B[3] - A[0] * B[5] + A[3] * B[2] - A[5] * B[0],
        A[0] * B[4] - A[1] * B[3] + A[4] * B[0] - A[3] * B[1],
    )


@inlined
def cofactor(F: Tensor) -> Tensor:
    """``cof F = (F x F) / 2``, the area map of ``F``."""
    return (
        F[4] * F[8] - F[5] * F[7],
        F[5] * F[6] - F[3] * F[8],
        F[3] * F[7] - F[4] * F[6],
        F[2] * F[7] - F[1] * F[8],
        F[0] * F[8] - F[2] * F[6],
        F[1] * F[6] - F[0] * F[7],
        F[1] * F[5] - F[2] * F[4],
        F[2] * F[3] - F[0] * F[5],
        F[0] * F[4] - F[1] * F[3],
    )


@inlined
def determinant(F: Tensor) -> Any:
    """``det F``, the volume map of ``F``."""
    return (
        F[0] * (F[4] * F[8] - F[5] * F[7])
        + F[1] * (F[5] * F[6] - F[3] * F[8])
        + F[2] * (F[3] * F[7] - F[4] * F[6])
    )


@inlined
def multiply(A: Tensor, B: Tensor) -> Tensor:
    """``A B``."""
    return (
        A[0] * B[0] + A[1] * B[3] + A[2] * B[6],
        A[0] * B[1] + A[1] * B[4] + A[2] * B[7],
        A[0] * B[2] + A[1] * B[5] + A[2] * B[8],
        A[3] * B[0] + A[4] * B[3] + A[5] * B[6],
        A[3] * B[1] + A[4] * B[4] + A[5] * B[7],
        A[3] * B[2] + A[4] * B[5] + A[5] * B[8],
        A[6] * B[0] + A[7] * B[3] + A[8] * B[6],
        A[6] * B[1] + A[7] * B[4] + A[8] * B[7],
        A[6] * B[2] + A[7] * B[5] + A[8] * B[8],
    )


@inlined
def transpose(A: Tensor) -> Tensor:
    """``A^T``."""
    return (A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8])


@inlined
def right_cauchy_green(F: Tensor) -> tuple[Any, Any, Any, Any, Any, Any]:
    """``C = F^T F``, which is symmetric: ``(C11, C22, C33, C12, C13, C23)``."""
    return (
        F[0] * F[0] + F[3] * F[3] + F[6] * F[6],
        F[1] * F[1] + F[4] * F[4] + F[7] * F[7],
        F[2] * F[2] + F[5] * F[5] + F[8] * F[8],
        F[0] * F[1] + F[3] * F[4] + F[6] * F[7],
        F[0] * F[2] + F[3] * F[5] + F[6] * F[8],
        F[1] * F[2] + F[4] * F[5] + F[7] * F[8],
    )


@inlined
def apply(A: Tensor, n: Vector) -> Vector:
    """``A n``."""
    return (
        A[0] * n[0] + A[1] * n[1] + A[2] * n[2],
        A[3] * n[0] + A[4] * n[1] + A[5] * n[2],
        A[6] * n[0] + A[7] * n[1] + A[8] * n[2],
    )


@inlined
def axial(A: Tensor) -> Vector:
    """Axial vector ``(E : A)_i = eps_ijk A_jk``; zero exactly when ``A`` is symmetric."""
    return (A[5] - A[7], A[6] - A[2], A[1] - A[3])


@inlined
def vector_cross(w: Vector, F: Tensor) -> Tensor:
    """``(w x F)_iI = eps_ijk w_j F_kI``: the columns of ``F`` crossed from the left by ``w``."""
    return (
        w[1] * F[6] - w[2] * F[3],
        w[1] * F[7] - w[2] * F[4],
        w[1] * F[8] - w[2] * F[5],
        w[2] * F[0] - w[0] * F[6],
        w[2] * F[1] - w[0] * F[7],
        w[2] * F[2] - w[0] * F[8],
        w[0] * F[3] - w[1] * F[0],
        w[0] * F[4] - w[1] * F[1],
        w[0] * F[5] - w[1] * F[2],
    )


@inlined
def solve_symmetric(A: Tensor, r: Vector) -> Vector:
    """``A^-1 r`` for symmetric ``A`` by the cofactor (``cof A`` is symmetric too)."""
    C = cofactor(A)
    d = 1.0 / determinant(A)
    return (
        d * (C[0] * r[0] + C[1] * r[1] + C[2] * r[2]),
        d * (C[3] * r[0] + C[4] * r[1] + C[5] * r[2]),
        d * (C[6] * r[0] + C[7] * r[1] + C[8] * r[2]),
    )


def split(field: Any) -> Tensor:
    """Array ``(..., 3, 3)`` to nine arrays, for the all-particles-at-once use."""
    return tuple(field[..., i, j] for i in range(3) for j in range(3))


def join(A: Tensor) -> Any:
    """Nine arrays (or numbers) to an array ``(..., 3, 3)``."""
    import numpy as np

    entries = np.broadcast_arrays(*[np.asarray(entry) for entry in A])
    return np.stack(entries, axis=-1).reshape(*entries[0].shape, 3, 3)
