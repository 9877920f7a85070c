"""What a problem's functions say, in a few numbers, so that two problems can be told apart.

A checkpoint cannot hold a function, but it can hold what the function says at some instants:
of the values ``f_a`` at the points, the mean, the root mean square and a mean with uneven weights,
which sees an exchange of two values too.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.callbacks import asked
from sphsolid.scenes.constraint import Fixed, vertex_normals
from sphsolid.scenes.scene import FromGeometry, NoBodyForce, Scene

Array = NDArray[np.float64]
#: ``{name: (instants, numbers)}``; initial data have one instant.
Samples = dict[str, Array]
#: Relative difference up to which numbers are the same: another processor may round otherwise.
SAME = 1.0e-9
_INSTANTS = 16
_GOLDEN = 0.6180339887498949


def instants(scene: Scene) -> list[float]:
    """The start, and instants [s] at irrational parts of the scene's time, spread evenly."""
    return [0.0, *(scene.end_time * (k * _GOLDEN % 1.0) for k in range(1, _INSTANTS))]


class Sampler:
    """Asks the functions of ``scene`` at the vertices of ``mesh``; what was asked is kept."""

    def __init__(self, scene: Scene, mesh: Mesh) -> None:
        self._scene, self._mesh = scene, mesh
        self._kept: dict[tuple[float, ...], Samples] = {}

    def at(self, times: Sequence[float]) -> Samples:
        """Samples of initial data, loads and prescribed motions; see the module."""
        key = tuple(times)
        if key not in self._kept:
            self._kept[key] = self._asked(key)
        return self._kept[key]

    def _asked(self, times: tuple[float, ...]) -> Samples:
        scene, X = self._scene, self._mesh.vertices
        found: Samples = {
            "initial displacement": _numbers(scene.initial_displacement, (X,), [None]),
            "initial velocity": _numbers(scene.initial_velocity, (X,), [None]),
        }
        stated = scene.initial_deformation_gradient
        if not isinstance(stated, FromGeometry):
            found["initial deformation gradient"] = _numbers(stated, (X,), [None], tensor=True)
        for constraint in scene.constraints:
            if not isinstance(constraint.velocity, Fixed):
                particles, _ = vertex_normals(self._mesh, constraint.face)
                name = _free(f"prescribed velocity on {constraint.face}", found)
                found[name] = _numbers(constraint.velocity, (X[particles],), times)
        for traction in scene.tractions:
            particles, normal = vertex_normals(self._mesh, traction.face)
            name = _free(f"traction on {traction.face}", found)
            found[name] = _numbers(traction.value, (X[particles], normal), times)
        if not isinstance(scene.body_force, NoBodyForce):
            found["body force"] = _numbers(scene.body_force, (X,), times)
        return found


def differences(there: Samples, here: Samples, times: Sequence[float]) -> list[str]:
    """What differs between two problems sampled at the same ``times`` [s], in words."""
    found = []
    for name in sorted(there.keys() | here.keys()):
        if name not in there or name not in here:
            found.append(f"{name}: only {'there' if name in there else 'here'}")
            continue
        a, b = there[name], here[name]
        if a.shape != b.shape:
            found.append(f"{name} differs")
            continue
        scale = np.nanmax(np.abs([a, b]), initial=0.0)
        same = (np.abs(a - b) <= SAME * scale) | (np.isnan(a) & np.isnan(b))
        if not same.all():
            k = int(np.flatnonzero(~same.all(axis=1))[0])
            at = f"at t = {times[k]:.6g} s " if len(a) > 1 else ""
            width = (a.shape[1] - 1) // 2
            what, part = ("mean", slice(width))
            if same[k, :width].all():
                what, part = ("root mean square and spread over the points", slice(width, None))
            found.append(
                f"{name} differs: {at}its {what} is {_said(a[k, part])} there and "
                f"{_said(b[k, part])} here"
            )
    return found


def _numbers(
    function: Callable[..., Any],
    points: tuple[Array, ...],
    times: Sequence[float | None],
    *,
    tensor: bool = False,
) -> Array:
    """``(T, 2 w + 1)`` of a function with ``w`` components; nan where it does not answer."""
    width = 9 if tensor else 3
    uneven = np.cos(_GOLDEN * np.arange(len(points[0])) ** 1.5)[:, None]
    rows = []
    try:
        # A copy is asked: a function with a memory must not notice that it is watched.
        own = copy.deepcopy(function)
    except Exception:
        own = function
    for t in times:
        try:
            f = asked(own, *points, what="", tensor=tensor, t=t).reshape(-1, width)
        except Exception:
            # It may fail, or have no answer, at an instant that no run gets to.
            rows.append(np.full(2 * width + 1, np.nan))
            continue
        mean, rms = f.mean(axis=0), np.sqrt(np.mean(f * f))
        rows.append(np.concatenate([mean, [rms], np.mean(uneven * f, axis=0)]))
    return np.array(rows)


def _free(name: str, taken: Samples) -> str:
    number = 2
    free = name
    while free in taken:
        free, number = f"{name} ({number})", number + 1
    return free


def _said(values: Array) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in values) + ")"
