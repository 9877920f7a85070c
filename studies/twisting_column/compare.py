"""Fields of two runs on different lattices compared: the finer is interpolated to the coarser."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from sphsolid.look.percentiles import weighted_percentile

Array = NDArray[np.float64]
Row = dict[str, Any]
#: Height [m] above which the clamp and the singular stress at its corners are not felt.
CLAMP = 0.5
#: Percentiles of the pressure that are told.
SHARES = (1, 50, 99)


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
    weights = [np.ones(len(axis)) for axis in planes]
    for weight in weights:
        weight[[0, -1]] = 0.5
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
            row |= {f"{name}_mean_{s} [Pa]": p for s, p in _percentiles(values).items()}
    return row


def _free_pressures(run: Row, other: Row, name: str) -> tuple[Array, Array]:
    """Pressures of both at the centroids of ``run`` above the clamp."""
    at = centres(run["cells"])
    free = at[1] > CLAMP
    others = _resampled(centres(other["cells"]), np.array(other[name]), at)[..., 0]
    return np.reshape(run[name], others.shape)[:, free], others[:, free]


def _percentiles(values: Array) -> dict[int, float]:
    """Of what cells of one volume have."""
    flat = values.ravel()
    return dict(zip(SHARES, weighted_percentile(flat, np.ones(len(flat)), SHARES), strict=True))


def of_means(grid: Sequence[float], cells: int) -> dict[str, float]:
    """``pressure_mean_*`` [Pa]: percentiles of the pressures of a grid above the clamp."""
    free = centres(cells)[1] > CLAMP
    above = np.reshape(grid, (cells, 6 * cells, cells))[:, free]
    return {f"pressure_mean_{share}": value for share, value in _percentiles(above).items()}


def _relative_rms(own: Array, others: Array) -> float:
    return float(np.sqrt(np.mean((own - others) ** 2) / np.mean(others**2)))


def kink(run: Row) -> float:
    """Largest part [rad] of the twist that alternates from layer to layer of vertices.

    The twist of a layer is its best-fit rotation about Y; the alternating part is half its
    distance from the mean of its neighbours.  A nodal gradient, a central difference, does not
    see it; a smooth twist of six radians on nineteen layers has 0.01.
    """
    X, Y, Z = nodes(run["cells"])
    x = np.reshape(run["grid_x"], (len(X), len(Y), len(Z), 3))
    now = x - x.mean(axis=(0, 2), keepdims=True)
    before = X[:, None, None] + 1j * Z[None, None, :]
    turn = np.sum((now[..., 0] + 1j * now[..., 2]) * np.conj(before), axis=(0, 2))
    twist = np.unwrap(np.angle(turn))
    return float(np.max(np.abs(0.5 * (0.5 * (twist[2:] + twist[:-2]) - twist[1:-1]))))


def differences(
    runs: Sequence[Row], *, reference: str, pairs: Sequence[tuple[str, str]]
) -> Iterator[Row]:
    """From the finest run of ``reference``, for every run; and between ``pairs`` on one lattice.

    Runs that diverged are left out.
    """
    ended = [run for run in runs if run["survived"]]
    for run in ended:
        named = {name: run[name] for name in ("method", "cells", "cfl", "nu", "kept", "usual")}
        known = [one for one in ended if one["method"] == reference and one["nu"] == run["nu"]]
        others = [max(known, key=lambda one: int(one["cells"]))] if known else []
        others = [other for other in others if other["cells"] > run["cells"]]
        same = ("cells", "cfl", "nu", "kept")
        others += [
            other for other in ended if (other["method"], run["method"]) in pairs
            and all(other[name] == run[name] for name in same)
        ]  # fmt: skip
        for other in others:
            found = difference(run, other)
            yield named | {"other": other["method"], "other_cells": other["cells"]} | found
