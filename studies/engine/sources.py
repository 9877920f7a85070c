"""Which sources a study is made of: its own module and what that imports of its package."""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


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


def hash_of_sources(module: str) -> str:
    """Hash of the text of ``module`` and of all it imports of its own package and of ``studies``.

    What lies beside a script is of its package.  The engine itself is left out: it runs cases and
    changes none of their rows.
    """
    return _hash(real_name(module))


@cache
def _hash(module: str) -> str:
    own = _package(module) | {"studies"}
    seen: dict[str, bytes] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        path = _file_of(name)
        if name in seen or path is None or name.startswith("studies.engine"):
            continue
        seen[name] = path.read_bytes()
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        waiting += [each for each in _imports(seen[name], package) if each.split(".")[0] in own]
    digest = hashlib.sha256()
    for name in sorted(seen):
        digest.update(name.encode() + hashlib.sha256(seen[name]).digest())
    return digest.hexdigest()[:16]


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


def _imports(source: bytes, package: str) -> Iterator[str]:
    """Names that ``source``, a module of ``package``, may import."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                inside = package.rsplit(".", node.level - 1)[0]
                base = f"{inside}.{base}".rstrip(".")
            yield base
            yield from (f"{base}.{each.name}" for each in node.names)
        elif isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
