"""Imports point one way: the rooms of the house, read from the source of every file."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("sphsolid", "fem_reference", "studies")

#: Anything may import these.
BASE = {
    "sphsolid.compiled", "sphsolid.errors", "sphsolid.fields", "sphsolid.paths",
    "sphsolid.protocols",
}  # fmt: skip
_PHYSICS = BASE | {"sphsolid.continuum"}
_PROBLEM = _PHYSICS | {"sphsolid.geometry", "sphsolid.scenes"}
_SPH = _PROBLEM | {
    "sphsolid.record", "sphsolid.cloud", "sphsolid.scheme", "sphsolid.defaults",
    "sphsolid.describe", "sphsolid.recommendation", "sphsolid.options", "sphsolid.run",
    "sphsolid.sph_snapshot", "sphsolid.simulation", "sphsolid.look",
}  # fmt: skip
#: What each room may import besides itself.  A room that is not here is a new one: decide.
ALLOWED: dict[str, set[str]] = {
    "sphsolid.kernel_cache": set(),
    "sphsolid.compiled": {"sphsolid.kernel_cache"},
    "sphsolid.errors": set(),
    "sphsolid.fields": set(),
    "sphsolid.paths": {"sphsolid.errors"},
    "sphsolid.protocols": {"sphsolid.errors"},
    "sphsolid.continuum": BASE,
    "sphsolid.geometry": {"sphsolid.errors", "sphsolid.paths", "sphsolid.protocols"},
    "sphsolid.scenes": _PHYSICS | {"sphsolid.geometry"},
    "sphsolid.record": _PROBLEM,
    "sphsolid.run": _PROBLEM | {"sphsolid.record"},
    "sphsolid.cloud": _PROBLEM,
    "sphsolid.scheme": _PROBLEM | {"sphsolid.cloud"},
    "sphsolid.defaults": _PROBLEM | {"sphsolid.cloud", "sphsolid.scheme"},
    "sphsolid.recommendation": _PROBLEM
    | {"sphsolid.cloud", "sphsolid.scheme", "sphsolid.defaults"},
    "sphsolid.options": _PROBLEM
    | {
        "sphsolid.cloud", "sphsolid.scheme", "sphsolid.defaults", "sphsolid.recommendation",
        "sphsolid.record",
    },
    "sphsolid.sph_snapshot": _PROBLEM | {"sphsolid.scheme", "sphsolid.record"},
    "sphsolid.describe": _SPH - {"sphsolid.look"},
    "sphsolid.simulation": _SPH - {"sphsolid.look"},
    # Shows what was recorded, by either method; nothing but the user's doors knows it.
    "sphsolid.look": _PROBLEM | {"sphsolid.record"},
    "sphsolid": _SPH,
    # The command line: the one room of the package that knows both methods.
    "sphsolid.shell": _SPH | {"sphsolid", "fem_reference"},
    "sphsolid.__main__": {"sphsolid.shell"},
    "fem_reference": _PROBLEM | {"sphsolid.record", "sphsolid.run"},
    # On top of everything; of the shell they take the executors that sweeps run on.
    "studies": _SPH | {"sphsolid", "sphsolid.shell", "fem_reference"},
}
OURS = {*PACKAGES, "tests"}


def module_name(path: Path, root: Path) -> str:
    """Dotted name of a source file; a package by its own name."""
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def room(module: str) -> str:
    """The part of the house a module belongs to."""
    parts = module.split(".")
    return ".".join(parts[:2]) if parts[0] == "sphsolid" else parts[0]


def imported(path: Path, root: Path) -> set[str]:
    """Every module of ours that a file imports, at its top or inside a function."""
    name = module_name(path, root)
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            parents = package.split(".")
            above = parents[: len(parents) - node.level + 1] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                # "from sphsolid import scheme" imports a module, "... import InputError" does not.
                inner = root / Path(*base.split("."), alias.name)
                is_module = inner.with_suffix(".py").exists() or inner.is_dir()
                found.add(f"{base}.{alias.name}" if is_module else base)
    return {module for module in found if module.split(".")[0] in OURS}


def violations(root: Path) -> list[str]:
    """One sentence for each import that points the wrong way."""
    wrong = []
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            here = room(module_name(path, root))
            where = path.relative_to(root).as_posix()
            if here not in ALLOWED:
                wrong.append(f"{where}: {here} is a new room; say in ALLOWED what it may import")
                continue
            wrong += [
                f"{where} imports {module}, which {here} must not know"
                for module in sorted(imported(path, root))
                if room(module) not in ALLOWED[here] | {here}
            ]
    return wrong


def test_imports_point_one_way():
    assert violations(ROOT) == []


def test_every_package_was_read():
    for package in PACKAGES:
        assert list((ROOT / package).rglob("*.py")), package


@pytest.mark.parametrize(
    ("file", "line", "culprit"),
    [
        ("sphsolid/continuum/law.py", "from sphsolid.scenes.scene import Scene", "sphsolid.scenes"),
        ("sphsolid/geometry/body.py", "import sphsolid.record.norms", "sphsolid.record"),
        ("sphsolid/cloud/cloud.py", "from sphsolid import scheme", "sphsolid.scheme"),
        ("sphsolid/cloud/cloud.py", "from ..scheme import tvd_rk2", "sphsolid.scheme"),
        ("sphsolid/scheme/time_step.py", "def f():\n    import sphsolid.simulation", "simulation"),
        ("sphsolid/record/march.py", "from sphsolid.cloud import cloud", "sphsolid.cloud"),
        ("sphsolid/simulation.py", "import studies.x", "studies"),
        ("fem_reference/simulation.py", "from sphsolid.cloud.cloud import Cloud", "sphsolid.cloud"),
        ("fem_reference/simulation.py", "import sphsolid", "sphsolid"),
        ("fem_reference/simulation.py", "from sphsolid import Simulation", "sphsolid"),
        ("studies/report/order.py", "from tests.unit import helper", "tests"),
        ("sphsolid/errors.py", "from sphsolid.compiled import kernel", "sphsolid.compiled"),
        ("sphsolid/newroom/thing.py", "", "new room"),
    ],
)
def test_a_planted_violation_is_found(tmp_path, file, line, culprit):
    for folder in ("scheme", "cloud", "record", "scenes", "geometry", "continuum"):
        (tmp_path / "sphsolid" / folder).mkdir(parents=True)
    path = tmp_path / file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(line + "\n")
    [found] = violations(tmp_path)
    assert file in found
    assert culprit in found


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("sphsolid/continuum/law.py", "from sphsolid.compiled import overload\nimport numpy"),
        ("sphsolid/continuum/law.py", "from . import tensor\nfrom .tensor import add"),
        ("sphsolid/scheme/x.py", "from sphsolid.cloud.cloud import Cloud"),
        ("sphsolid/__init__.py", "from sphsolid.simulation import Simulation"),
        ("fem_reference/x.py", "from sphsolid.record import march\nfrom fem_reference import y"),
        ("studies/x.py", "import sphsolid as sph\nimport fem_reference as f\nimport studies.x"),
    ],
)
def test_what_is_allowed_passes(tmp_path, file, line):
    path = tmp_path / file
    path.parent.mkdir(parents=True)
    path.write_text(line + "\n")
    assert violations(tmp_path) == []
