"""Fields of two runs on different lattices compared: the finer is interpolated to the coarser."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from studies.report.percentiles import weighted_percentile
from studies.twisting_column.cases import CLAMP, SHARES
from studies.twisting_column.methods import FEM, H1, H6, LITERAL, LITERAL_H6

Array = NDArray[np.float64]
Row = dict[str, Any]
#: The paper's two settings; where both ran they are compared with each other.
PAIRS = ((H1, H6), (LITERAL, LITERAL_H6))


def nodes(cells: int) -> tuple[Array, Array, Array]:
    """Planes of the lattice with ``cells`` cells per metre [m]."""
    across = np.linspace(-0.5, 0.5, cells + 1)
    return across, np.linspace(0.0, 6.0, 6 * cells + 1), across


def centres(cells: int) -> tuple[Array, Array, Array]:
    """Planes of the centroids of its cells [m]."""
    X, Y, Z = (0.5 * (planes[1:] + planes[:-1]) for planes in nodes(cells))
    return X, Y, Z


def _resampled(planes: tuple[Array, ...], values: Array, targets: tuple[Array, ...]) -> Array:
    grid = values.reshape(*(len(axis) for axis in planes), -1)
    points = np.stack(np.meshgrid(*targets, indexing="ij"), axis=-1)
    return np.asarray(RegularGridInterpolator(planes, grid)(points))


def _tributary(planes: tuple[Array, ...]) -> Array:
    weights = []
    for axis in planes:
        weight = np.ones(len(axis))
        weight[[0, -1]] = 0.5
        weights.append(weight)
    product = np.einsum("i,j,k->ijk", *weights)
    return np.asarray(product / product.sum())


def difference(run: Row, other: Row) -> dict[str, float]:
    """How far ``run`` is from ``other``, which is at least as fine.

    ``position_rms [m]``: root mean square distance of the positions over the body;
    ``pressure_rms``: root mean square difference of the pressure at centroids above the clamp
    over the root mean square of the other's, at the end; ``mean_rms``: the same of the means over
    the time after it, ``own_mean_*, other_mean_* [Pa]`` their percentiles at the same centroids.
    """
    here, there = nodes(run["cells"]), nodes(other["cells"])
    weights = _tributary(here)
    x = np.reshape(run["grid_x"], (*weights.shape, 3))
    apart = x - _resampled(there, np.array(other["grid_x"]), here)
    own, others = _free_pressures(run, other, "grid_pressure")
    row = {
        "position_rms [m]": float(np.sqrt(np.sum(weights * np.sum(apart**2, axis=-1)))),
        "pressure_rms": _relative_rms(own, others),
    }
    if run.get("grid_mean") and other.get("grid_mean"):
        own, others = _free_pressures(run, other, "grid_mean")
        row["mean_rms"] = _relative_rms(own, others)
        for name, values in (("own", own), ("other", others)):
            row |= {
                f"{name}_mean_{share} [Pa]": value
                for share, value in percentiles_of_cells(values).items()
            }
    return row


def _free_pressures(run: Row, other: Row, name: str) -> tuple[Array, Array]:
    """Pressures of both at the centroids of ``run`` above the clamp."""
    at = centres(run["cells"])
    free = at[1] > CLAMP
    others = _resampled(centres(other["cells"]), np.array(other[name]), at)[..., 0]
    return np.reshape(run[name], others.shape)[:, free], others[:, free]


def percentiles_of_cells(values: Array) -> dict[int, float]:
    """Percentiles :data:`SHARES` of what cells of one volume have."""
    flat = values.ravel()
    found = weighted_percentile(flat, np.ones(len(flat)), SHARES)
    return dict(zip(SHARES, found.tolist(), strict=True))


def _relative_rms(own: Array, others: Array) -> float:
    return float(np.sqrt(np.mean((own - others) ** 2) / np.mean(others**2)))


def kink(run: Row) -> float:
    """Largest part [rad] of the twist that alternates from layer to layer of vertices.

    The twist of a layer is its best-fit rotation about Y; the alternating part is half its
    distance from the mean of its neighbours.  A nodal gradient, a central difference, does not
    see it; a smooth twist of six radians on nineteen layers has 0.01.
    """
    X, Y, Z = nodes(run["cells"])
    shape = (len(X), len(Y), len(Z), 3)
    x = np.reshape(run["grid_x"], shape)
    now = x - x.mean(axis=(0, 2), keepdims=True)
    before = X[:, None, None] + 1j * Z[None, None, :]
    turn = np.sum((now[..., 0] + 1j * now[..., 2]) * np.conj(before), axis=(0, 2))
    twist = np.unwrap(np.angle(turn))
    return float(np.max(np.abs(0.5 * (0.5 * (twist[2:] + twist[:-2]) - twist[1:-1]))))


def reference_run(runs: list[Row], nu: float) -> Row | None:
    """The finest finite element run at ``nu`` that reached its end, if there is one."""
    found = [
        run for run in runs if run["label"] == FEM and run["nu"] == nu and run["survived"]
    ]
    return max(found, key=lambda run: int(run["cells"]), default=None)


def differences(runs: list[Row]) -> Iterator[Row]:
    """From the finest finite elements, for every run; and between H1 and H6 where both ran."""
    for run in runs:
        if not run["survived"]:
            continue
        named = {name: run[name] for name in ("label", "cells", "cfl", "nu")}
        finest = reference_run(runs, run["nu"])
        if finest is not None and finest["cells"] > run["cells"]:
            yield named | {"other": FEM, "other_cells": finest["cells"]} | difference(
                run, finest
            )
        for first, second in PAIRS:
            if run["label"] != second:
                continue
            for other in runs:
                same = all(other[name] == run[name] for name in ("cells", "cfl", "nu"))
                if other["label"] == first and same and other["survived"]:
                    yield named | {"other": first, "other_cells": other["cells"]} | difference(
                        run, other
                    )
