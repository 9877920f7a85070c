"""What a problem statement must be made of, refused in one sentence where it is not."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np

from sphsolid.errors import InputError, require
from sphsolid.protocols import members as members
from sphsolid.protocols import number as number
from sphsolid.scenes.places import Places


def as_float(value: Any) -> Any:
    """A real number of any type as a ``float``; anything else, and a bool, as it is."""
    if isinstance(value, bool):
        return value
    return float(value) if isinstance(value, Real) else value


def function(what: str, value: object, call: str) -> None:
    """Raises ``InputError`` unless ``value`` can be called; ``call`` shows how."""
    if isinstance(value, type):
        raise InputError(f"{what} = {value.__name__} is a class; make an object of it")
    if not callable(value):
        raise InputError(
            f"{what} = {value!r} is not a function; for a constant write "
            f"{call}: np.tile([0.0, 0.0, 1.0], (len(X), 1))"
        )


def orientation(what: str, F: Any, X: Any) -> None:
    """Raises ``InputError`` unless ``det F > 0`` for every ``F (n, 3, 3)`` at ``X (n, 3)`` [m]."""
    J = np.linalg.det(F)
    bad = np.flatnonzero(~(J > 0.0))
    if len(bad):
        a = int(bad[0])
        raise InputError(
            f"{what} is inside out at {len(bad)} of {len(X)} points, the first at X = "
            f"{X[a].tolist()} m (det F = {J[a]:.3g}); it must have det F > 0"
        )


def probes(what: str, value: object) -> dict[str, tuple[float, float, float]]:
    """Names and places [m] of probes, checked and copied; nobody can change the copy."""
    if not isinstance(value, Mapping):
        raise InputError(f'{what} = {value!r} is not a dict of points: {{"tip": (0.0, 0.0, 1.0)}}')
    checked = {}
    for name, place in value.items():
        try:
            point = np.asarray(place, dtype=float)
        except (TypeError, ValueError):
            point = np.zeros(0)
        if not isinstance(name, str) or point.shape != (3,) or not np.isfinite(point).all():
            raise InputError(
                f"{what}: probe {name!r} at {place!r}; wanted are a name and three finite "
                "coordinates [m] of the undeformed body"
            )
        checked[name] = (float(point[0]), float(point[1]), float(point[2]))
    return Places(checked)


def body(what: str, value: Any) -> None:
    """Raises ``InputError`` unless ``value`` is an object that can be meshed."""
    if isinstance(value, type) or not callable(getattr(value, "mesh", None)):
        raise InputError(
            f"{what} = {value!r} is no body; use Box(...), Blocks(...), MeshFile(path) or "
            "PointCloud(...)"
        )


def material(what: str, value: Any) -> None:
    """Raises ``InputError`` unless ``value`` is an object with positive moduli and density."""
    for name in ("mu", "kappa", "density"):
        if isinstance(value, type) or not hasattr(value, name):
            raise InputError(
                f"{what} = {value!r} is no material (it has no {name}); use "
                "NeoHookean.from_young(...) or MooneyRivlin.from_young(...)"
            )
        modulus = number(f"{what} {name}", getattr(value, name), "SI units")
        require(
            modulus > 0.0,
            f"{what} {name} = {modulus} must be positive and finite; "
            "build the material with its from_young(...)",
        )
