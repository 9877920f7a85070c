"""The 3x3 algebra against numpy, which knows nothing of it."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.continuum import tensor as t

RNG = np.random.default_rng(3)
A, B, C = RNG.normal(size=(3, 20, 3, 3))
n, w = RNG.normal(size=(2, 20, 3))
EPS = np.zeros((3, 3, 3))
for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    EPS[i, j, k], EPS[i, k, j] = 1.0, -1.0


def close(mine, numpys):
    np.testing.assert_allclose(mine, numpys, rtol=1e-12, atol=1e-13)


def tensors(*fields):
    return [t.split(field) for field in fields]


def vector(field):
    return tuple(field[:, d] for d in range(3))


def test_linear_algebra():
    a, b = tensors(A, B)
    close(t.join(t.add(a, b)), A + B)
    close(t.join(t.scale(2.5, a)), 2.5 * A)
    close(t.join(t.axpy(2.5, a, b)), 2.5 * A + B)
    close(t.contract(a, b), np.sum(A * B, axis=(1, 2)))
    close(t.join(t.multiply(a, b)), A @ B)
    close(t.join(t.transpose(a)), np.swapaxes(A, 1, 2))
    close(np.stack(t.apply(a, vector(n)), axis=1), np.einsum("nij,nj->ni", A, n))
    close(t.join(t.IDENTITY), np.eye(3))


def test_cross_product_is_its_index_formula():
    a, b = tensors(A, B)
    close(t.join(t.cross(a, b)), np.einsum("ijk,IJK,njJ,nkK->niI", EPS, EPS, A, B))


def test_cofactor_and_determinant():
    [a] = tensors(A)
    det = np.linalg.det(A)
    close(t.determinant(a), det)
    close(t.join(t.cofactor(a)), det[:, None, None] * np.swapaxes(np.linalg.inv(A), 1, 2))


def test_algebra_of_the_cross_product():
    """The rules that the paper's derivations lean on ([Bonet2016])."""
    a, b, c = tensors(A, B, C)
    close(t.join(t.cross(a, b)), t.join(t.cross(b, a)))
    close(t.join(t.cross(a, a)), 2.0 * t.join(t.cofactor(a)))
    close(t.contract(t.cofactor(a), a) / 3.0, t.determinant(a))
    # (A x B) : C is the same in any order.
    close(t.contract(t.cross(a, b), c), t.contract(t.cross(b, c), a))
    # A x I = tr(A) I - A^T.
    identity = t.split(np.broadcast_to(np.eye(3), A.shape))
    trace = np.trace(A, axis1=1, axis2=2)[:, None, None]
    close(t.join(t.cross(a, identity)), trace * np.eye(3) - np.swapaxes(A, 1, 2))
    # (C A) x (C B) = cof(C) (A x B).
    left = t.cross(t.multiply(c, a), t.multiply(c, b))
    close(t.join(left), t.join(t.multiply(t.cofactor(c), t.cross(a, b))))


def test_derivatives_of_cofactor_and_determinant():
    """``d cof F = F x dF`` and ``d det F = cof F : dF``, by complex step."""
    step = 1e-30
    moved = t.split(A + 1j * step * B)
    a, b = tensors(A, B)
    close(np.imag(t.join(t.cofactor(moved))) / step, t.join(t.cross(a, b)))
    close(np.imag(t.determinant(moved)) / step, t.contract(t.cofactor(a), b))


def test_axial_vector():
    [a] = tensors(A)
    close(np.stack(t.axial(a), axis=1), np.einsum("ijk,njk->ni", EPS, A))
    symmetric = t.split(A + np.swapaxes(A, 1, 2))
    close(np.stack(t.axial(symmetric), axis=1), 0.0)


def test_vector_cross():
    [a] = tensors(A)
    mine = t.join(t.vector_cross(vector(w), a))
    close(mine, np.einsum("ijk,nj,nkI->niI", EPS, w, A))
    close(mine, np.cross(w[:, :, None], A, axis=1))


def test_solve_symmetric():
    S = A @ np.swapaxes(A, 1, 2) + np.eye(3)
    mine = t.solve_symmetric(t.split(S), vector(n))
    close(np.stack(mine, axis=1), np.linalg.solve(S, n[:, :, None])[:, :, 0])


def test_load_store_split_join():
    field = np.zeros((20, 3, 3))
    for a in range(20):
        t.store(t.load(A, a), field, a)
    np.testing.assert_array_equal(field, A)
    np.testing.assert_array_equal(t.join(t.split(A)), A)
    mixed = t.join((1.0, np.arange(2.0), 0, 0, 1, 0, 0, 0, 1))
    assert mixed.shape == (2, 3, 3)
    np.testing.assert_array_equal(mixed[:, 0, 1], [0.0, 1.0])


@pytest.mark.parametrize("function", [t.cofactor, t.transpose, t.axial])
def test_entries_may_be_plain_numbers(function):
    mine = function(t.load(A, 0))
    whole = function(t.split(A))
    np.testing.assert_allclose(mine, [entry[0] for entry in whole], rtol=1e-15)
