"""How this package compiles: one place for numba's threads, cache and decorators.

Why a module of its own:

* numba's disk cache does not notice an edit in *another* file, so a cached caller can return
  the old stress after the material law changed.  The cache directory is therefore keyed by a
  hash of every source file that can end up in a kernel: those that import this module or are
  in a room that does.
* The threading layer and its wait policy must be chosen before numba starts its threads.
* A cache is a convenience: where none can be written, kernels are compiled in memory, and a warning
  of one line says so.
* GNU's threads do not survive a fork; a forked process gets others:
  :func:`_change_threads`.

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
    "sphsolid/continuum/check_law.py", "sphsolid/geometry/", "sphsolid/scenes/",
    "sphsolid/record/", "sphsolid/simulation.py", "sphsolid/defaults.py", "sphsolid/describe.py",
    "sphsolid/recommendation.py", "sphsolid/paths.py", "sphsolid/protocols.py", "sphsolid/run/",
    "sphsolid/options.py", "sphsolid/sph_snapshot.py", "sphsolid/look/", "sphsolid/shell/",
    "sphsolid/__main__.py",
)  # fmt: skip
#: What shows results and what starts runs: they change no number.
_NO_RESULT = ("sphsolid/look/", "sphsolid/shell/", "sphsolid/__main__.py")


def _hash(skipped: tuple[str, ...]) -> str:
    digest = hashlib.sha256()
    for package in _COMPILED_PACKAGES:
        for path in sorted((_ROOT / package).rglob("*.py")):
            name = path.relative_to(_ROOT).as_posix()
            if not name.startswith(skipped):
                digest.update(name.encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


#: Hashes of the sources as this process found them when it began: of all that can change a result,
#: and of all that can end up inside a compiled kernel.
SOURCE_HASH = _hash(_NO_RESULT)
KERNEL_HASH = _hash(_NOT_COMPILED)


def cache_base() -> Path:
    """Folder of everything that can be made anew: ``SPHSOLID_CACHE`` or the user's cache.

    Raises ``OSError`` where there is neither, nor a home folder.  An empty or relative
    ``XDG_CACHE_HOME`` counts as unset, as its specification says.
    """
    chosen, shared = os.environ.get("SPHSOLID_CACHE"), os.environ.get("XDG_CACHE_HOME", "")
    try:
        if chosen:
            return Path(chosen).expanduser().absolute()
        return (Path(shared) if os.path.isabs(shared) else Path.home() / ".cache") / "sphsolid"
    except RuntimeError as homeless:
        raise OSError(f"there is no cache folder ({homeless}); set SPHSOLID_CACHE") from None


def _cache_dir() -> Path | None:
    try:
        return cache_base() / "kernels" / KERNEL_HASH
    except OSError:
        return None


#: Folder of compiled kernels; None where there is no place for one.
CACHE_DIR = _cache_dir()

# A process that shares the machine should sleep while it has nothing for its threads, but to wake
# them costs more than many a kernel: they wait actively for as long as it takes Python to come to
# the next one, some 0.1 to 0.3 ms.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("GOMP_SPINCOUNT", "10000")
os.environ.setdefault("NUMBA_THREADING_LAYER", "omp")

import numba  # noqa: E402  (the environment above must be set first)
from numba import prange  # noqa: E402
from numba.extending import overload, register_jitable  # noqa: E402
from numba.np.ufunc import parallel as _threading  # noqa: E402

from sphsolid.kernel_cache import OptionalCache, say_not_kept  # noqa: E402

if CACHE_DIR is not None:
    numba.config.CACHE_DIR = str(CACHE_DIR)


_KERNELS: list[Any] = []


def _compiled(function: Callable[..., Any], *, parallel: bool) -> Any:
    made: Any = numba.njit(parallel=parallel, error_model="numpy")(function)
    _KERNELS.append(made)
    try:
        if CACHE_DIR is None:
            cache_base()
        cache = OptionalCache(function)
        # numba's next choice is a folder beside the source, which knows nothing of other sources.
        if not Path(cache.cache_path).is_relative_to(Path(numba.config.CACHE_DIR)):
            raise OSError(f"{CACHE_DIR} cannot be written")
        made._cache = cache
    except (OSError, RuntimeError) as failure:
        say_not_kept(failure)
    return made


def _change_threads() -> None:
    """In a forked process: numba's own threads instead of GNU OpenMP's, which ended with the fork.

    GNU OpenMP ends a process that goes on with it.  Kernels are linked anew, from the cache where
    there is one; their results do not depend on who runs the threads.
    """
    if not (_threading._is_initialized and _threading._threading_layer == "omp"):
        return
    count = numba.get_num_threads()
    _threading._is_initialized = False
    numba.config.THREADING_LAYER = "workqueue"
    numba.set_num_threads(count)
    for each in _KERNELS:
        each._reset_overloads()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_change_threads)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a gather loop: threads over the outer ``prange``, strict IEEE arithmetic."""
    return _compiled(function, parallel=True)


def serial_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a loop that must run in order (set-up work, totals)."""
    return _compiled(function, parallel=False)


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
        "threading_layer": numba.config.THREADING_LAYER,
        "wait_policy": os.environ["OMP_WAIT_POLICY"],
    }


__all__ = [
    "CACHE_DIR",
    "KERNEL_HASH",
    "SOURCE_HASH",
    "cache_base",
    "description",
    "inlined",
    "kernel",
    "overload",
    "prange",
    "register_jitable",
    "serial_kernel",
    "set_threads",
    "threads",
]
