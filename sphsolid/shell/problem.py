"""``[scene]``, ``[body]``, ``[material]``, ``[[constraints]]``, ``[[tractions]]``: the problem."""

from __future__ import annotations

import inspect
from typing import Any

from sphsolid.errors import InputError, nearest, require
from sphsolid.geometry import Region, Tagged
from sphsolid.scenes import Constraint, Scene, Traction
from sphsolid.shell.expressions import (
    PLACE,
    VARIABLES,
    Condition,
    FaceField,
    Field,
    TimeField,
    is_condition,
    is_finite_somewhere,
)
from sphsolid.shell.lines import Place
from sphsolid.shell.names import BODIES, MATERIALS, SCENES
from sphsolid.shell.objects import Builder
from sphsolid.shell.problems import MISSING

_OWN = ("type", "name", "end_time", "initial_displacement", "initial_velocity", "body_force",
        "probes", "provenance")  # fmt: skip
_MODULI = ("young_modulus", "poisson_ratio", "density")
#: Of fields, by the key that they stand under.
_UNITS = {
    "initial_displacement": "m", "initial_velocity": "m/s", "velocity": "m/s",
    "body_force": "N/m^3", "value": "Pa",
}  # fmt: skip
_OWN_TABLES = ("body", "constraints", "tractions")


def read_scene(values: dict[str, Any], builder: Builder, name: str) -> Any:
    """The scene of a file, ``MISSING`` where something is wrong with it."""
    problems = builder.problems
    table = _table(values, "scene", builder)
    material = _table(values, "material", builder)
    if table is MISSING or material is MISSING:
        return MISSING
    kind = table.get("type", "Scene")
    if kind == "Scene":
        return _own(values, table, material, builder, name)
    if not isinstance(kind, str) or kind not in SCENES:
        known = ["Scene", *SCENES]
        problems.add(
            ("scene", "type"),
            f"{kind!r} is no scene{nearest(str(kind), known)}; known are {', '.join(SCENES)}, or "
            '"Scene" for one of your own',
        )
        return MISSING
    for key in _OWN_TABLES:
        if key in values and not (key == "body" and _takes(kind, "body")):
            problems.add((key,), f"the scene {kind} brings its own {key}; leave the table out")
    given = {key: value for key, value in table.items() if key != "type"}
    for key, value in material.items():
        if key not in _MODULI or not _takes(kind, key):
            problems.unknown(("material",), key, [each for each in _MODULI if _takes(kind, each)])
        elif key in given:
            problems.add(("material", key), f"{key} is given in [scene], too; give it once")
        else:
            made = builder.number(value, ("material", key))
            if made is not MISSING:
                given[key] = made
    if "body" in values and _takes(kind, "body"):
        given["body"] = values["body"]
    before = len(problems.found)
    scene = builder.call(SCENES[kind], kind, given, ("scene",))
    return scene if len(problems.found) == before else MISSING


def _takes(kind: str, key: str) -> bool:
    return key in inspect.signature(SCENES[kind]).parameters


def _table(values: dict[str, Any], key: str, builder: Builder) -> Any:
    table = values.get(key, {})
    if not isinstance(table, dict):
        builder.problems.add((key,), f"{table!r} is no table; write [{key}]")
        return MISSING
    return table


def _own(
    values: dict[str, Any], table: dict[str, Any], material: dict[str, Any], builder: Builder,
    name: str,
) -> Any:  # fmt: skip
    """A scene of one's own: every part is read before anything is said of the whole."""
    problems = builder.problems
    before = len(problems.found)
    for key in table:
        if key not in _OWN:
            problems.unknown(("scene",), key, _OWN)
    parts: dict[str, Any] = {
        "name": table.get("name", name),
        "body": _body(values, builder),
        "material": _material(material, builder),
        "constraints": _members(values, "constraints", _constraint, builder),
        "tractions": _members(values, "tractions", _traction, builder),
        "probes": _probes(table.get("probes", {}), builder),
        "provenance": table.get("provenance", f"case file {problems.file}"),
    }
    if "end_time" in table:
        parts["end_time"] = builder.number(table["end_time"], ("scene", "end_time"), "s")
    else:
        problems.add(("scene",), "end_time [s] is missing")
    for key, kind in (
        ("initial_displacement", Field), ("initial_velocity", Field), ("body_force", TimeField),
    ):  # fmt: skip
        if key in table:
            parts[key] = read_field(table[key], kind, ("scene", key), builder)
    if len(problems.found) > before:
        return MISSING
    try:
        return Scene(**parts)
    except InputError as error:
        problems.add(("scene",), str(error))
        return MISSING


def _probes(table: Any, builder: Builder) -> Any:
    """Places by name, with formulas of numbers worked out; the rest is the scene's to judge."""
    if not isinstance(table, dict):
        return table
    return {
        name: [
            builder.number(each, ("scene", "probes", name, k)) if isinstance(each, str) else each
            for k, each in enumerate(place)
        ]
        if isinstance(place, list)
        else place
        for name, place in table.items()
    }


def _body(values: dict[str, Any], builder: Builder) -> Any:
    if "body" not in values:
        builder.problems.add((), "[body] is missing: " + ", ".join(BODIES))
        return MISSING
    value: Any = values["body"]
    regions: Any = []
    made: list[Any] = []
    if isinstance(value, dict):
        value = dict(value)
        regions = value.pop("regions", [])
    body = builder.make(value, ("body",), BODIES, "body")
    if not isinstance(regions, list):
        builder.problems.add(("body", "regions"), "regions are a list: write [[body.regions]]")
        regions = []
    for k, region in enumerate(regions):
        made.append(_region(region, ("body", "regions", k), builder))
    if body is MISSING or MISSING in made:
        return MISSING
    return Tagged(body, tuple(made)) if made else body


def _region(table: Any, place: Place, builder: Builder) -> Any:
    found = _keys(table, place, ("name", "face", "where"), builder)
    if found is MISSING:
        return MISSING
    try:
        require(
            is_condition(str(found["where"]), PLACE),
            f"{found['where']!r} is no condition; write for example \"X > 0.5\"",
        )
    except InputError as error:
        builder.problems.add((*place, "where"), str(error))
        return MISSING
    return Region(found["name"], found["face"], Condition(str(found["where"])))


def _material(table: dict[str, Any], builder: Builder) -> Any:
    if not table:
        builder.problems.add(
            (), "[material] is missing: type, young_modulus, poisson_ratio, density"
        )
        return MISSING
    kind = table.get("type", "NeoHookean")
    if not isinstance(kind, str) or kind not in MATERIALS:
        builder.problems.add(
            ("material", "type"),
            f"{kind!r} is no law{nearest(str(kind), MATERIALS)}; known are {', '.join(MATERIALS)}",
        )
        return MISSING
    law: Any = MATERIALS[kind]
    given = {key: value for key, value in table.items() if key != "type"}
    by_young = any(key in given for key in _MODULI[:2]) or "mu" not in given
    made = builder.call(
        law.from_young if by_young else law, kind, given, ("material",)
    )
    return made


def _members(values: dict[str, Any], key: str, read: Any, builder: Builder) -> Any:
    tables = values.get(key, [])
    if not isinstance(tables, list):
        builder.problems.add((key,), f"{key} are a list: write [[{key}]]")
        return MISSING
    return tuple(read(table, (key, k), builder) for k, table in enumerate(tables))


def _constraint(table: Any, place: Place, builder: Builder) -> Any:
    found = _keys(table, place, ("face", "direction"), builder, also=("velocity",))
    if found is MISSING:
        return MISSING
    arguments = {"face": found["face"], "direction": found["direction"]}
    if "velocity" in found:
        arguments["velocity"] = read_field(
            found["velocity"], TimeField, (*place, "velocity"), builder
        )
        if arguments["velocity"] is MISSING:
            return MISSING
    try:
        return Constraint(**arguments)
    except InputError as error:
        builder.problems.add(place, str(error))
        return MISSING


def _traction(table: Any, place: Place, builder: Builder) -> Any:
    found = _keys(table, place, ("face", "value"), builder)
    if found is MISSING:
        return MISSING
    value = read_field(found["value"], FaceField, (*place, "value"), builder)
    if value is MISSING:
        return MISSING
    try:
        return Traction(found["face"], value)
    except InputError as error:
        builder.problems.add(place, str(error))
        return MISSING


def _keys(
    table: Any, place: Place, needed: tuple[str, ...], builder: Builder,
    *, also: tuple[str, ...] = (),
) -> Any:  # fmt: skip
    """The table, with all that it needs and nothing else; ``MISSING`` otherwise."""
    problems, before = builder.problems, len(builder.problems.found)
    if not isinstance(table, dict):
        problems.add(place, f"{table!r} is no table with {', '.join(needed)}")
        return MISSING
    for key in table:
        if key not in (*needed, *also):
            problems.unknown(place, key, (*needed, *also))
    for key in needed:
        if key not in table:
            problems.add(place, f"{key} is missing")
    for key in ("name", "face"):
        if key in table and not isinstance(table[key], str):
            problems.add((*place, key), f"{table[key]!r} is not a name in quotes")
    return table if len(problems.found) == before else MISSING


def read_field(value: Any, kind: type[Field], place: Place, builder: Builder) -> Any:
    """Three formulas or numbers as a field of ``kind``; tried at a few places and times."""
    if not isinstance(value, list) or len(value) != 3:
        unit = _UNITS[str(place[-1])]
        builder.problems.add(
            place, f"{value!r} are no three components in {unit}; write [\"0\", \"0\", \"1.5*X\"]"
        )
        return MISSING
    names, fine = VARIABLES[kind], True
    parts = []
    for k, part in enumerate(value):
        where = (*place, k)
        if isinstance(part, bool) or not isinstance(part, str | int | float):
            builder.problems.add(where, f"{part!r} is neither a number nor a formula in quotes")
            fine = False
            continue
        try:
            require(
                is_finite_somewhere(str(part), names),
                f"{part!r} is a finite number at none of the places and times that were tried",
            )
        except InputError as error:
            builder.problems.add(where, str(error))
            fine = False
        parts.append(str(part))
    return kind((parts[0], parts[1], parts[2])) if fine else MISSING
