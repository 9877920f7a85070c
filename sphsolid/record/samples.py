"""What a problem's functions say, in a few numbers, so that two problems can be told apart.

A checkpoint cannot hold a function, but it can hold what the function says at some instants:
of the values ``f_a`` at the points, the mean, the root mean square and a mean with uneven weights,
which sees an exchange of two values too.  What a function does only between two of the instants is
not seen: a pulse that is shorter than the gaps between them.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.mesh import Mesh
from sphsolid.record.exact_samples import exact_functions
from sphsolid.scenes.callbacks import asked
from sphsolid.scenes.functions_of_time import functions_of_time
from sphsolid.scenes.scene import FromGeometry, Scene

Array = NDArray[np.float64]
#: ``{name: (instants, numbers)}``; initial data have one instant.
Samples = dict[str, Array]
#: Relative difference up to which numbers are the same: another processor may round otherwise.
SAME = 1.0e-9
#: Instants of a span besides its ends: no gap is wider than a fiftieth of it.
_INSTANTS = 128
#: Half steps ahead of a checkpoint that are sampled.
_AHEAD = 8
#: Points at which an exact solution is asked, about.
_FEW = 100
_GOLDEN = 0.6180339887498949


def instants(scene: Scene, *, until: float | None = None) -> list[float]:
    """The start, the end, and instants [s] at irrational parts of the scene's time, spread evenly.

    The same of the span of a run that ends at another ``until`` [s].
    """
    found = [0.0]
    for end in dict.fromkeys((scene.end_time, scene.end_time if until is None else until)):
        found += [end * (k * _GOLDEN % 1.0) for k in range(1, _INSTANTS)] + [end]
    return found


def instants_ahead(now: float, dt: float) -> list[float]:
    """Instants [s] of the next steps of ``dt`` [s]: what a run that goes on asks for first."""
    return [now + 0.5 * dt * k for k in range(_AHEAD + 1)]


class Sampler:
    """Asks the functions of ``scene`` at the vertices of ``mesh``; what was asked is kept."""

    def __init__(self, scene: Scene, mesh: Mesh) -> None:
        self._scene, self._mesh = scene, mesh
        self._kept: dict[str, dict[float | None, Array]] = {}
        # Of an exact solution a few points say enough: it is a formula.
        self._few = mesh.vertices[:: max(1, len(mesh.vertices) // _FEW)]

    def at(self, times: Sequence[float]) -> Samples:
        """Samples of initial data, loads, prescribed motions and the exact solution."""
        scene, X = self._scene, self._mesh.vertices
        found: Samples = {}

        def sample(
            name: str,
            function: Callable[..., Any],
            points: tuple[Array, ...],
            instants: Sequence[float | None],
            *,
            tensor: bool = False,
        ) -> None:
            name = _free(name, found)
            kept = self._kept.setdefault(name, {})
            new = [t for t in dict.fromkeys(instants) if t not in kept]
            if new:
                kept.update(zip(new, _numbers(function, points, new, tensor=tensor), strict=True))
            found[name] = np.array([kept[t] for t in instants])

        sample("initial displacement", scene.initial_displacement, (X,), [None])
        sample("initial velocity", scene.initial_velocity, (X,), [None])
        stated = scene.initial_deformation_gradient
        if not isinstance(stated, FromGeometry):
            sample("initial deformation gradient", stated, (X,), [None], tensor=True)
        for each in functions_of_time(scene, self._mesh):
            sample(each.what, each.function, each.points, times)
        for name, function, tensor in exact_functions(scene.exact):
            sample(name, function, (self._few,), times, tensor=tensor)
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
