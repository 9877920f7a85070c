"""What a name and a version say all about: Python, NumPy, SciPy, numba, and this room.

Nothing counts by the name alone: the thing must be what is found under that name.  A text given to
``exec`` has the names of ``builtins``, and ``functools.wraps`` gives a function those of another.
"""

from __future__ import annotations

import sys
import sysconfig
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

_PACKAGES = ("numpy", "numba", "llvmlite", "scipy")
#: Its sources are in the key of the kernel cache, and a checkpoint names them.
_ROOM = "sphsolid.continuum"
_STANDARD = Path(sysconfig.get_paths()["stdlib"])


def known_by_name(thing: Any) -> str:
    """Name and version of ``thing``; empty where they do not say all that it does."""
    if isinstance(thing, ModuleType):
        return _version(thing.__name__) if sys.modules.get(thing.__name__) is thing else ""
    if isinstance(thing, np.ufunc):
        homes: tuple[Any, ...] = ("numpy", "scipy.special")
    else:
        homes = (getattr(thing, "__module__", None),)
    name = getattr(thing, "__qualname__", getattr(thing, "__name__", None))
    if not isinstance(name, str):
        return ""
    for home in homes:
        if isinstance(home, str) and _version(home) and _found(home, name) is thing:
            return f"{_version(home)} {name}"
    return ""


def _found(module: str, name: str) -> Any:
    found: Any = sys.modules.get(module)
    for word in name.split("."):
        found = getattr(found, word, None)
    return found


def _version(module: str) -> str:
    """The module and its version; empty for one that may be edited."""
    root = module.split(".")[0]
    if root in _PACKAGES:
        return f"{module} {getattr(sys.modules.get(root), '__version__', '')}"
    if f"{module}.".startswith(f"{_ROOM}."):
        return module
    return f"{module} {sys.version}" if _is_standard(root) else ""


def _is_standard(root: str) -> bool:
    """True for the standard library's own module, not a user's file of the same name."""
    if root not in sys.stdlib_module_names:
        return False
    file = getattr(sys.modules.get(root), "__file__", None)
    return file is None or Path(file).is_relative_to(_STANDARD)
