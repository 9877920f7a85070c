"""How a result was made: command, sources, versions, machine, date."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sphsolid.compiled import SOURCE_HASH
from studies.engine.sources import ROOT

_PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "scikit-fem", "pandas", "matplotlib", "typst")


def package_version() -> str:
    """Version of this package: of the checkout where there is one, else of what is installed."""
    project = ROOT / "pyproject.toml"
    if project.exists():
        return str(tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"])
    return importlib.metadata.version("sphsolid")


def describe_run(
    *,
    study: str,
    command: str,
    sources: str,
    argv: Sequence[str],
    mode: str,
    jobs: int,
    threads: int,
    cluster: bool,
    wall_s: float,
    cases: int,
    failed: int,
    resumed: int,
    sampled: int,
    older_times: int,
) -> dict[str, Any]:
    """What ``run.json`` holds; names no folder of the machine it was made on."""
    return {
        "study": study,
        "command": " ".join([command, *map(_relative, argv)]),
        "mode": mode,
        "date_utc": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M:%S"),
        "wall_s": round(wall_s, 1),
        "cases": cases,
        "cases_failed": failed,
        "cases_resumed": resumed,
        "cases_sampled": sampled,
        "cases_with_older_times": older_times,
        "version": package_version(),
        "commit": commit(),
        "sources_modified": bool(
            _git("status", "--porcelain", "--", "sphsolid", "fem_reference", "studies")
        ),
        "source_hash": SOURCE_HASH,
        "study_hash": sources,
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in _PACKAGES},
        "system": f"{platform.system()} {platform.machine()}",
        "cpu": cpu_model(),
        "cores": cores(),
        "jobs": jobs,
        "cluster": cluster,
        "threads_per_job": threads,
    }


def commit() -> str:
    """The commit that is checked out."""
    return _git("rev-parse", "HEAD")


def cores() -> int:
    """Cores this process may use (a container may have fewer than the machine)."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def cpu_model() -> str:
    """Name of the processor, or what the platform calls it."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    if sys.platform == "darwin":
        return _output("sysctl", "-n", "machdep.cpu.brand_string") or platform.machine()
    return platform.processor() or platform.machine()


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _git(*arguments: str) -> str:
    return _output("git", *arguments) if (ROOT / ".git").exists() else ""


def _output(*command: str) -> str:
    try:
        return subprocess.run(
            command, cwd=ROOT, capture_output=True, text=True, check=True, timeout=20
        ).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""


def _relative(argument: str) -> str:
    """An absolute path inside the present folder relative to it, any other one by its name."""
    name, equals, value = argument.rpartition("=")
    path = Path(value)
    if not path.is_absolute():
        return argument
    here = Path.cwd()
    shown = path.relative_to(here) if path.is_relative_to(here) else Path(path.name)
    return f"{name}{equals}{shown.as_posix()}"
