"""What of the compiled kernels may lie on disk.

numba keeps a list of what is stored beside every kernel, by the types of its arguments, and a type
by the module and name of its class.  Whoever reads the list imports those modules.  A parameter
class of a user's file handed to a kernel as it is (``law.in_kernels`` hands over one of this
package instead) would end every other program on that cache, so such a kernel is not stored.
"""

from __future__ import annotations

from typing import Any

_PACKAGES = ("sphsolid", "fem_reference")


def is_foreign(kind: Any) -> bool:
    """True for a numba type that names a class of neither package."""
    held = getattr(kind, "types", ())
    if any(is_foreign(part) for part in held):
        return True
    named = getattr(kind, "instance_class", None)
    return named is not None and named.__module__.split(".")[0] not in _PACKAGES


def keep_own_kernels(dispatcher: Any) -> Any:
    """Let a cached kernel store only what any program can read; returns it."""
    cache = dispatcher._cache
    load, save = cache.load_overload, cache.save_overload

    def load_own(types: Any, context: Any) -> Any:
        return None if any(map(is_foreign, types)) else load(types, context)

    def save_own(types: Any, data: Any) -> None:
        if not any(map(is_foreign, types)):
            save(types, data)

    cache.load_overload, cache.save_overload = load_own, save_own
    return dispatcher
