"""Objects as a case file writes them: ``"SUPG(xi_F=0.0)"``, or a table with their ``type``.

Both are read into the same call of the same class.  Keywords are those of its signature, so the
file knows no option that Python does not, and no default of its own.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from sphsolid.errors import InputError, nearest
from sphsolid.shell.expressions import number_in
from sphsolid.shell.lines import Place
from sphsolid.shell.names import PARTS, Named
from sphsolid.shell.problems import MISSING, Problems

#: Arguments that name a file, beside the case file unless they are absolute.
_FILES = {
    "MeshFile": ("path",), "PointCloud": ("points", "surface"), "PointCloud.fill": ("surface",),
}  # fmt: skip
#: The type of a place or a vector, and types of arguments that are words.
_TRIPLE = "Triple"
_WORDS = ("str", "Literal", "OneOf", "Family", "Start", "Unit", "GradientKind")


class Builder:
    """Makes objects, and tells ``problems`` what cannot be made; files lie beside ``folder``.

    ``files`` are those that the objects read: what comes of a case depends on them.
    """

    def __init__(self, problems: Problems, folder: Path) -> None:
        self.problems, self.folder = problems, folder
        self.files: list[Path] = []

    def make(self, value: Any, place: Place, known: Named, what: str) -> Any:
        """The object that ``value`` stands for, one of ``known``; ``MISSING`` with a problem."""
        of_name = place
        if isinstance(value, str):
            value = self._read(value, place)
            if value is MISSING:
                return MISSING
        else:
            of_name = (*place, "type")
        if not isinstance(value, Mapping):
            self.problems.add(
                place,
                f"{value!r} is no {what}; write a name such as {next(iter(known))!r}, with "
                f"arguments in brackets, or a table with its type; known are {', '.join(known)}",
            )
            return MISSING
        name = value.get("type")
        if not isinstance(name, str):
            self.problems.add(place, f"the {what} needs a type: one of {', '.join(known)}")
            return MISSING
        if name not in known:
            self.problems.add(
                of_name,
                f"{name!r} is no {what}{nearest(name, known)}; known are {', '.join(known)}",
            )
            return MISSING
        given = {key: each for key, each in value.items() if key != "type"}
        return self.call(known[name], name, given, place)

    def call(
        self, function: Callable[..., Any], name: str, given: dict[str, Any], place: Place
    ) -> Any:
        """``function(**given)`` with every argument read by the type in its signature."""
        parameters = inspect.signature(function).parameters
        before, arguments = len(self.problems.found), {}
        positional = given.pop("", [])
        names = list(parameters)
        if len(positional) > len(names):
            self.problems.add(place, f"{name} takes {len(names)} arguments: {', '.join(names)}")
            return MISSING
        given = dict(zip(names, positional, strict=False)) | given
        for key, value in given.items():
            if key not in parameters:
                self.problems.unknown(place, key, names)
                continue
            kind = str(parameters[key].annotation)
            value = self._argument(value, kind, (*place, key))
            if isinstance(value, str) and key in _FILES.get(name, ()):
                value = self._file(value, (*place, key))
            arguments[key] = value
        lacking = [
            key for key, each in parameters.items()
            if each.default is inspect.Parameter.empty and key not in given
        ]  # fmt: skip
        if lacking:
            self.problems.add(place, f"{name} needs {', '.join(lacking)}")
        if len(self.problems.found) > before:
            return MISSING
        try:
            return function(**arguments)
        except InputError as error:
            # Messages name an argument with its value: that is where it stands.
            blamed = [key for key in arguments if f"{key} = " in str(error)]
            self.problems.add((*place, blamed[0]) if blamed else place, str(error))
        except (TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
            self.problems.add(place, f"{name}: {error}")
        return MISSING

    def number(self, value: Any, place: Place, unit: str = "") -> Any:
        """A number, or a formula of numbers such as ``"1/6"``; ``MISSING`` with a problem."""
        if isinstance(value, str):
            try:
                return number_in(value)
            except InputError as error:
                self.problems.add(place, str(error))
                return MISSING
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.problems.add(
                place, f"{value!r} is not a number" + (f"; give it in {unit}" if unit else "")
            )
            return MISSING
        return value

    def _file(self, value: str, place: Place) -> Any:
        file = self.folder / Path(value).expanduser()
        if not file.is_file():
            self.problems.add(place, f"there is no file {file}")
            return MISSING
        self.files.append(file)
        return str(file)

    # ------------------------------------------------------------------ arguments
    def _argument(self, value: Any, kind: str, place: Place) -> Any:
        if kind == "bool":
            if not isinstance(value, bool):
                self.problems.add(place, f"{value!r} is neither true nor false")
            return value
        if kind == "int":
            if isinstance(value, bool) or not isinstance(value, int):
                self.problems.add(place, f"{value!r} is not a whole number")
            return value
        if kind in ("float", "float | None"):
            return self.number(value, place)
        if kind == _TRIPLE or kind.startswith("tuple"):
            return self._list(value, 3 if kind == _TRIPLE else None, place)
        if any(word in kind for word in _WORDS):
            return value if not isinstance(value, Mapping) else self._part(value, place)
        if isinstance(value, list | tuple):
            return tuple(self._member(each, (*place, k)) for k, each in enumerate(value))
        return self._part(value, place)

    def _list(self, value: Any, length: int | None, place: Place) -> Any:
        if not isinstance(value, list | tuple) or length not in (None, len(value)):
            wanted = "a list" if length is None else f"a list of {length} numbers"
            self.problems.add(place, f"{value!r} is not {wanted}")
            return MISSING
        if length is None:
            return tuple(self._member(each, (*place, k)) for k, each in enumerate(value))
        return tuple(self.number(each, (*place, k)) for k, each in enumerate(value))

    def _member(self, value: Any, place: Place) -> Any:
        if isinstance(value, list | tuple):
            return tuple(self._member(each, (*place, k)) for k, each in enumerate(value))
        return self.number(value, place)

    def _part(self, value: Any, place: Place) -> Any:
        """A number, or an object within an object."""
        if isinstance(value, bool | int | float):
            return value
        if isinstance(value, str) and not value.strip()[:1].isalpha():
            return self.number(value, place)
        return self.make(value, place, PARTS, "object of that place")

    # ------------------------------------------------------------------ text
    def _read(self, text: str, place: Place) -> Any:
        """``Name(...)`` as a table; positional arguments stand under the empty key."""
        try:
            return _table(ast.parse(text.strip(), mode="eval").body)
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            reason = error.msg if isinstance(error, SyntaxError) else error
            self.problems.add(place, f"{text!r} cannot be read as an object: {reason}")
            return MISSING


def _table(node: ast.expr) -> Any:
    """A name, a call, a number, a text or a list of those."""
    if isinstance(node, ast.Name):
        return {"type": node.id}
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute):
        made: dict[str, Any] = {"type": ast.unparse(node.func)}
        if node.args:
            made[""] = [_table(each) for each in node.args]
        for each in node.keywords:
            if each.arg is None or each.arg == "type":
                raise ValueError("arguments are written name=value")
            made[each.arg] = _table(each.value)
        return made
    if isinstance(node, ast.Constant) and isinstance(node.value, bool | int | float | str):
        return node.value
    if isinstance(node, ast.List | ast.Tuple):
        return [_table(each) for each in node.elts]
    if isinstance(node, ast.BinOp | ast.UnaryOp):
        return number_in(ast.unparse(node))
    raise ValueError(f"{ast.unparse(node)!r} is neither a name, a number, a text nor a list")
