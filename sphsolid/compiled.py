"""How this package compiles: one place for numba's threads, cache and decorators.

Why a module of its own:

* numba's disk cache does not notice an edit in *another* file, so a cached caller can return
  the old stress after the material law changed.  The cache directory is therefore keyed by a
  hash of every source file that can end up in a kernel: those that import this module or are
  in a room that does.
* The threading layer and its wait policy must be chosen before numba starts its threads.

Kernels take arrays and scalars only and write into their last argument.  They *gather*: every
output row is written by exactly one loop iteration, so the bits do not depend on the number of
threads.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

#: Both compiled packages share the cache, because fem_reference inlines sphsolid.continuum.
_ROOT = Path(__file__).resolve().parent.parent
_COMPILED_PACKAGES = ("sphsolid", "fem_reference")
#: Rooms without kernels: they change often and need no new compilation.
_NOT_COMPILED = (
    "sphsolid/continuum/check_law.py",
    "sphsolid/geometry/", "sphsolid/scenes/", "sphsolid/record/", "sphsolid/simulation.py",
    "sphsolid/defaults.py", "sphsolid/describe.py", "sphsolid/recommend.py",
)  # fmt: skip


def _hash(skipped: tuple[str, ...]) -> str:
    digest = hashlib.sha256()
    for package in _COMPILED_PACKAGES:
        for path in sorted((_ROOT / package).rglob("*.py")):
            name = path.relative_to(_ROOT).as_posix()
            if not name.startswith(skipped):
                digest.update(name.encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def source_hash() -> str:
    """Hash of all sources that can change a result."""
    return _hash(())


def kernel_hash() -> str:
    """Hash of all sources that can end up inside a compiled kernel."""
    return _hash(_NOT_COMPILED)


def cache_base() -> Path:
    """Folder of everything that can be made anew: ``SPHSOLID_CACHE`` or the user's cache."""
    chosen = os.environ.get("SPHSOLID_CACHE")
    if chosen:
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "sphsolid"


CACHE_DIR = cache_base() / "kernels" / kernel_hash()

# A process that shares the machine should sleep, not spin, while it waits for its threads.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("NUMBA_THREADING_LAYER", "omp")

import numba  # noqa: E402  (the environment above must be set first)
from numba import prange  # noqa: E402
from numba.extending import overload, register_jitable  # noqa: E402

from sphsolid.kernel_cache import keep_own_kernels  # noqa: E402

numba.config.CACHE_DIR = str(CACHE_DIR)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a gather loop: threads over the outer ``prange``, strict IEEE arithmetic."""
    made = numba.njit(parallel=True, cache=True, error_model="numpy")(function)
    return keep_own_kernels(made)


def serial_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a loop that must run in order (set-up work, totals)."""
    made = numba.njit(cache=True, error_model="numpy")(function)
    return keep_own_kernels(made)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function part of every kernel that calls it, and still plain Python elsewhere.

    LLVM does not inline what it thinks is large, and works on one particle at a time in any loop
    with a call left in it; with this it works on a whole vector register of particles.
    """
    made: Callable[..., Any] = register_jitable(forceinline=True)(function)
    return made


def threads() -> int:
    """Number of threads that kernels use now."""
    return int(numba.get_num_threads())


def set_threads(count: int) -> None:
    """Let kernels use ``count`` threads (results do not depend on it)."""
    numba.set_num_threads(count)


def description() -> dict[str, Any]:
    """Versions and threads, for the header of a run."""
    import llvmlite
    import numpy
    import scipy

    return {
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
        "threads": threads(),
        "threading_layer": os.environ["NUMBA_THREADING_LAYER"],
        "wait_policy": os.environ["OMP_WAIT_POLICY"],
    }


__all__ = [
    "CACHE_DIR",
    "cache_base",
    "description",
    "inlined",
    "kernel",
    "kernel_hash",
    "overload",
    "prange",
    "register_jitable",
    "serial_kernel",
    "set_threads",
    "source_hash",
    "threads",
]
