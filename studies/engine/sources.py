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


@cache
def hash_of_sources(module: str) -> str:
    """Hash of the text of ``module`` and of all it imports of its own top-level package.

    The engine itself is left out: it runs cases and changes none of their rows.
    """
    seen: dict[str, bytes] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        path = _file_of(name)
        if name in seen or path is None or name.startswith("studies.engine"):
            continue
        seen[name] = path.read_bytes()
        waiting += _imports(seen[name], {module.split(".")[0], "studies"})
    digest = hashlib.sha256()
    for name in sorted(seen):
        digest.update(name.encode() + hashlib.sha256(seen[name]).digest())
    return digest.hexdigest()[:16]


def _file_of(module: str) -> Path | None:
    if module == "__main__":
        script = getattr(sys.modules[module], "__file__", None)
        return Path(script) if script else None
    try:
        spec = importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return None
    return Path(spec.origin) if spec and spec.origin and Path(spec.origin).exists() else None


def _imports(source: bytes, packages: set[str]) -> Iterator[str]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names = [node.module, *(f"{node.module}.{each.name}" for each in node.names)]
        elif isinstance(node, ast.Import):
            names = [each.name for each in node.names]
        else:
            continue
        yield from (name for name in names if name.split(".")[0] in packages)
