"""Frames made by hand: bodies whose picture is known."""

from __future__ import annotations

import numpy as np

from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.look.frame import KEPT, Shot
from sphsolid.scenes import Box


def box_shot(
    lower=(0.0, 0.0, 0.0), upper=(1.0, 1.0, 1.0), *, spacing=0.25, move=lambda X: X,
    field=lambda x: x[:, 0], label="a method", time=0.0,
    folded=False,
):  # fmt: skip
    """A moved box; every kept field is ``field`` of the present positions."""
    mesh = Box(lower, upper).mesh(spacing)
    x = move(mesh.vertices)
    values = np.asarray(field(x)).astype(np.float32)
    whole = Shot(
        label=label,
        time=time,
        quads=mesh.boundary.astype(np.int32),
        x=x.astype(np.float32),
        values={name: values.copy() for name in KEPT},
        V=vertex_volumes(mesh).astype(np.float32),
        folded=folded,
    )
    return whole.only(np.ones(len(whole.quads), dtype=bool), KEPT)


def twisted(angle):
    """Turn a column along Y by ``angle`` [rad] a metre."""

    def move(X):
        c, s = np.cos(angle * X[:, 1]), np.sin(angle * X[:, 1])
        return np.stack([c * X[:, 0] + s * X[:, 2], X[:, 1], c * X[:, 2] - s * X[:, 0]], axis=1)

    return move


def horseshoe(turn):
    """Bend a column along Y by ``turn`` [rad] a metre, in the plane of X and Y."""

    def move(X):
        radius = 1.0 / turn + X[:, 0]
        c, s = np.cos(turn * X[:, 1]), np.sin(turn * X[:, 1])
        return np.stack([radius * c, radius * s, X[:, 2]], axis=1)

    return move
