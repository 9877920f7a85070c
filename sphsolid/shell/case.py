"""A case file: a thin, typed reading of the objects that a script would make.

    solver = "sph"                       # or "fem"
    spacing = "1/6"                      # m; left out where the body has points of its own
    [scene]    type = "twisting_column"  # one of sphsolid.scenes with its arguments, or
               end_time, initial_velocity, body_force, probes, ...  of a problem of one's own
    [body]     type = "Box", ...         # and [[body.regions]]
    [material] type = "NeoHookean", ...  # of a scene by name: its moduli and density
    [[constraints]], [[tractions]]
    [method]   formulation, operator, ...  the keywords of the simulation
    [run]      until, every, record, folder, frames, vtkhdf, checkpoints, threads

Nothing is guessed: a key that is not known is refused, and all mistakes are said at once.
"""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.geometry.body import AS_MESHED
from sphsolid.paths import path_of
from sphsolid.scenes import Scene
from sphsolid.shell.lines import Place, key_lines, spelled
from sphsolid.shell.method import read_method
from sphsolid.shell.objects import Builder
from sphsolid.shell.problem import read_scene
from sphsolid.shell.problems import MISSING, Problems
from sphsolid.shell.run_table import RunTable, read_run_table

TABLES = ("solver", "spacing", "scene", "body", "material", "constraints", "tractions", "method",
          "run")  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """``--set place=value``."""

    place: Place
    value: Any

    @property
    def name(self) -> str:
        """``material.poisson_ratio``."""
        return spelled(self.place)


@dataclass(frozen=True)
class Case:
    """What a file asks for: a scene, a solver with its keywords, and how to run it.

    ``name`` is that of the file at ``path``; ``values`` the tables as they were read, with what
    was set; ``files`` are those that it names.
    """

    name: str
    scene: Scene
    solver: str
    spacing: Any
    method: dict[str, Any]
    run: RunTable
    values: dict[str, Any]
    problems: Problems
    text: str
    settings: tuple[Setting, ...] = ()
    path: Path = Path()
    files: tuple[Path, ...] = ()

    def simulation(self) -> Any:
        """The simulation; raises ``InputError`` as its constructor does, with the line to blame."""
        kind = {"sph": sph, "fem": fem}[self.solver].Simulation
        try:
            return kind(self.scene, spacing=self.spacing, **self.method)
        except InputError as error:
            self.problems.add(self._blamed(str(error)), str(error))
            self.problems.raise_if_any()
            raise

    def _blamed(self, message: str) -> Place:
        """Where the key stands that a message is about; nowhere if it names none."""
        for table in ("constraints", "tractions"):
            for k, each in enumerate(self.values.get(table, [])):
                if f"tag {each['face']!r}" in message or f"on {each['face']}" in message:
                    return (table, k, "face")
        for key in self.method:
            if f"{key} = " in message:
                return ("method", key)
        if "spacing = " in message and "spacing" in self.values:
            return ("spacing",)
        return ("body",) if "body" in self.values else ("scene",)


def read_case(path: str | Path, *, settings: Sequence[Setting] = ()) -> Case:
    """The case of a file with ``settings`` in the place of what it says.

    Raises one ``InputError`` with all that is wrong, each with its line where the file has it.
    """
    file = path_of(path)
    if not file.is_file():
        raise InputError(f"there is no case file {file}")
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file} cannot be read as a text in UTF-8: {error}") from None
    return case_of(text, name=file.stem, file=file.name, folder=file.parent, settings=settings)


def case_of(
    text: str, *, name: str, file: str, folder: Path, settings: Sequence[Setting] = ()
) -> Case:
    """The case of a ``text``; files that it names lie beside ``folder``."""
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{file} is no TOML: {error}") from None
    values = copy.deepcopy(values)
    problems = Problems(file, key_lines(text), frozenset(each.place for each in settings))
    for each in settings:
        _set(values, each, problems)
    problems.raise_if_any()
    builder = Builder(problems, folder)
    for key in values:
        if key not in TABLES:
            problems.unknown((), key, TABLES)
    solver = values.get("solver", "sph")
    if solver not in ("sph", "fem"):
        problems.add(("solver",), f"{solver!r} is no solver; write \"sph\" or \"fem\"")
    spacing: Any = AS_MESHED
    if "spacing" in values:
        spacing = builder.number(values["spacing"], ("spacing",), "m")
    scene = read_scene(values, builder, name)
    method = read_method(values, solver, builder)
    run = read_run_table(values, builder, scene, name)
    problems.raise_if_any()
    assert scene is not MISSING
    assert run is not MISSING
    return Case(
        name, scene, solver, spacing, method, run, values, problems, text, tuple(settings),
        folder / file, tuple(builder.files),
    )  # fmt: skip


def _set(values: dict[str, Any], setting: Setting, problems: Problems) -> None:
    """Put a value in its place; tables that are not there are made."""
    inside: Any = values
    part: Any
    for k, part in enumerate(setting.place):
        if isinstance(inside, list) and not (isinstance(part, int) and part < len(inside)):
            name = spelled(setting.place[:k])
            rest = setting.place[k + 1 :] if isinstance(part, int) else setting.place[k:]
            problems.add(
                setting.place,
                f"{name} is a list of {len(inside)}, counted from 1; write "
                f"{spelled((*setting.place[:k], 0, *rest))}",
            )
            return
        if not isinstance(inside, dict | list):
            problems.add(setting.place, f"{spelled(setting.place[:k])} is no table")
            return
        if k == len(setting.place) - 1:
            inside[part] = setting.value
        elif isinstance(inside, list):
            inside = inside[part]
        else:
            inside = inside.setdefault(part, {})
