"""Which sources a row is made of: functions, and all that they reach.

A figure, a claim or a text changes no row, and nothing is run again for it.  So what is hashed of
studies is not files but definitions: those that a function names, those that these name, and so on.
Of the solvers it is every module that is reached, whole, with all that it imports: their kernels
and laws are found by type, not by name.  A scene or a method that a study does not use is not
reached, so a new one makes no report old.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
Definition = tuple[str, str]
#: It runs cases and changes none of their rows.
_ENGINE = "studies.engine"
#: Followed by modules.
_SOLVERS = ("sphsolid", "fem_reference")


def real_name(module: str) -> str:
    """The name to import ``module`` by: ``python -m studies.x`` calls it ``__main__``."""
    if module != "__main__":
        return module
    spec = getattr(sys.modules[module], "__spec__", None)
    return module if spec is None else str(spec.name).removesuffix(".__main__")


def command_of(module: str) -> str:
    """How the study in ``module`` is started: ``python -m studies.x`` or ``python own.py``."""
    name = real_name(module)
    if name == "__main__":
        return f"python {Path(sys.argv[0]).name}"
    parts = name.split(".")
    return "python -m " + ".".join(parts[:2] if parts[0] == "studies" else parts)


def hash_of_sources(*made_by: Callable[..., Any] | type) -> str:
    """Hash of the text of functions and classes and of every definition that they reach.

    Followed are names of the same package, of ``studies`` without its engine, and of the solvers;
    what lies beside a script is of its package.  Docstrings, blank lines and the places of
    definitions do not count.
    """
    return _hash(tuple((real_name(m.__module__), m.__qualname__.split(".")[0]) for m in made_by))


@cache
def _hash(roots: tuple[Definition, ...]) -> str:
    own = {"studies", *_SOLVERS}.union(*(_package(module) for module, _ in roots))
    texts = set[str]()
    seen: set[Definition] = set()
    waiting = list(roots)
    while waiting:
        one = waiting.pop()
        followed = one[0].split(".")[0] in own and not one[0].startswith(_ENGINE)
        module = _read(one[0]) if followed else None
        if module is not None and module.is_part_of_a_solver:
            one = one[0], ""
        if module is None or one in seen:
            continue
        seen.add(one)
        if module.is_part_of_a_solver:
            texts.update(module.whole_text)
            waiting += module.imported_anywhere
            continue
        if one[1] in module.imported:
            waiting.append(module.imported[one[1]])
        elif module.is_package and one[1] not in module.defined:
            waiting.append((f"{one[0]}.{one[1]}", ""))
        for node in module.defined.get(one[1], ()):
            texts.add(module.text(node))
            waiting += module.used(node)
    return hashlib.sha256("\0".join(sorted(texts)).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class _Module:
    """The statements of a module by the names they give, and the names that it imports."""

    lines: Sequence[str]
    name: str
    is_package: bool
    statements: list[ast.stmt]
    defined: dict[str, list[ast.stmt]]
    imported: dict[str, Definition]

    @property
    def is_part_of_a_solver(self) -> bool:
        """True for a module of theirs; a package only hands on the names of its modules."""
        return self.name.split(".")[0] in _SOLVERS and not self.is_package

    @cached_property
    def whole_text(self) -> frozenset[str]:
        """Of all that it defines; its own docstring is none of that."""
        return frozenset(map(self.text, (node for node in self.statements if not _is_text(node))))

    @cached_property
    def imported_anywhere(self) -> list[Definition]:
        """What it imports, inside functions too."""
        tree = ast.Module(self.statements, [])
        return [one for node in ast.walk(tree) for one in _imports(node, self.name).values()]

    def text(self, node: ast.stmt) -> str:
        """Its lines, decorators too, without docstrings and blank ones."""
        first = min([node.lineno, *(each.lineno for each in getattr(node, "decorator_list", ()))])
        kept = set(range(first, (node.end_lineno or first) + 1))
        for each in ast.walk(node):
            if isinstance(each, ast.FunctionDef | ast.ClassDef) and ast.get_docstring(each):
                kept -= set(range(each.body[0].lineno, (each.body[0].end_lineno or 0) + 1))
        lines = (self.lines[number - 1].rstrip() for number in sorted(kept))
        return "\n".join(filter(None, lines))

    def used(self, node: ast.AST, local: frozenset[str] = frozenset()) -> Iterator[Definition]:
        """What a statement may refer to; of an imported module what is taken of it."""
        if isinstance(node, _SCOPES):
            local |= _bound(node)
        if isinstance(node, ast.Name) and node.id not in local:
            yield self.name, node.id
        elif isinstance(node, ast.Attribute):
            first, *others = ast.unparse(node).split(".")
            if first in self.imported:
                module = ".".join([*filter(None, self.imported[first]), *others[:-1]])
                yield module, others[-1]
        for child in ast.iter_child_nodes(node):
            yield from self.used(child, local)


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


_SCOPES = (
    ast.FunctionDef, ast.Lambda, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp,
)  # fmt: skip


def _bound(scope: ast.AST) -> set[str]:
    """Names of a function, lambda or comprehension itself: they hide those of the module."""
    found, waiting = set[str](), list(ast.iter_child_nodes(scope))
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.arg):
            found.add(node.arg)
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        if not isinstance(node, (*_SCOPES, ast.ClassDef)):
            waiting += ast.iter_child_nodes(node)
    return found


@cache
def _read(module: str) -> _Module | None:
    path = _file_of(module)
    if path is None:
        return None
    return _parsed(module, path.name == "__init__.py", path.read_text(encoding="utf-8"))


@cache
def _parsed(module: str, is_package: bool, text: str) -> _Module:
    within = f"{module}.__init__" if is_package else module
    defined: dict[str, list[ast.stmt]] = {}
    imported: dict[str, Definition] = {}
    statements = ast.parse(text).body
    for node in statements:
        if isinstance(node, ast.ImportFrom | ast.Import):
            imported |= _imports(node, within)
        else:
            for name in _names(node):
                defined.setdefault(name, []).append(node)
    return _Module(text.splitlines(), module, is_package, statements, defined, imported)


def _imports(node: ast.AST, within: str) -> dict[str, Definition]:
    """Names that an import in the module ``within`` gives, and what they stand for."""
    if isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            base = f"{within.rsplit('.', node.level)[0]}.{base}".rstrip(".")
        return {each.asname or each.name: (base, each.name) for each in node.names}
    if not isinstance(node, ast.Import):
        return {}
    names = ((each.asname or each.name.split(".")[0], each) for each in node.names)
    return {name: (each.name if each.asname else name, "") for name, each in names}


def _names(node: ast.stmt) -> set[str]:
    """Names that a statement at the top of a module gives to something."""
    return {node.name} if isinstance(node, ast.FunctionDef | ast.ClassDef) else _bound(node)


def _package(module: str) -> set[str]:
    """Top-level names that count as the study's own."""
    path = _file_of(module)
    if "." in module or path is None or path.name == "__init__.py":
        return {module.split(".")[0]}
    return {each.stem for each in path.parent.glob("*.py")} | {
        each.parent.name for each in path.parent.glob("*/__init__.py")
    }


def _file_of(module: str) -> Path | None:
    if module == "__main__":
        script = getattr(sys.modules[module], "__file__", None)
        return Path(script) if script else None
    try:
        spec = importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return None
    return Path(spec.origin) if spec and spec.origin and Path(spec.origin).exists() else None
