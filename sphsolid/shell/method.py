"""``[method]``: the keywords of a simulation."""

from __future__ import annotations

from typing import Any

from sphsolid.shell.names import FEM, FEM_NUMBERS, SPH, SPH_NUMBERS
from sphsolid.shell.objects import Builder
from sphsolid.shell.problems import MISSING


def read_method(values: dict[str, Any], solver: str, builder: Builder) -> dict[str, Any]:
    """Keywords of the ``solver``'s simulation; what is left out is chosen by its defaults."""
    table = values.get("method", {})
    if not isinstance(table, dict):
        builder.problems.add(("method",), f"{table!r} is no table; write [method]")
        return {}
    objects, numbers = (FEM, FEM_NUMBERS) if solver == "fem" else (SPH, SPH_NUMBERS)
    made: dict[str, Any] = {}
    for key, value in table.items():
        place = ("method", key)
        if key in objects:
            made[key] = builder.make(value, place, objects[key], key.replace("_", " "))
        elif key == "cfl" and value == "auto" and solver == "sph":
            made[key] = value
        elif key in numbers:
            made[key] = builder.number(value, place)
        else:
            other = "sph" if solver == "fem" else "fem"
            if key in (SPH if solver == "fem" else FEM):
                builder.problems.add(place, f"{key} belongs to solver = {other!r}")
            else:
                builder.problems.unknown(("method",), key, [*objects, *numbers])
    return {key: value for key, value in made.items() if value is not MISSING}
