"""What of the compiled kernels lies on disk, and that it need not.

numba keeps a list of what is stored beside every kernel, by the types of its arguments, and a type
by the module and name of its class.  Whoever reads the list imports those modules.  A parameter
class of a user's file handed to a kernel as it is (``law.in_kernels`` hands over one of this
package instead) would end every other program on that cache, so such a kernel is not stored.

What is stored can be made anew: a damaged cache, a full disk or a missing right costs time only.
"""

from __future__ import annotations

import warnings
from contextlib import suppress
from typing import Any

from numba.core.caching import FunctionCache

_PACKAGES = ("sphsolid", "fem_reference")
_said_not_kept = False


def is_foreign(kind: Any) -> bool:
    """True for a numba type that names a class of neither package."""
    held = getattr(kind, "types", ())
    if any(is_foreign(part) for part in held):
        return True
    named = getattr(kind, "instance_class", None)
    return named is not None and named.__module__.split(".")[0] not in _PACKAGES


def say_not_kept(why: Exception) -> None:
    """Warn, once in a process, that kernels are not stored."""
    global _said_not_kept
    if not _said_not_kept:
        _said_not_kept = True
        text = f"kernels are compiled in memory, anew in every process: {why}"
        text += "" if "set SPHSOLID_CACHE" in text else "; set SPHSOLID_CACHE"
        # Not at a line of the caller: one line is all there is to say.
        warnings.warn_explicit(text, RuntimeWarning, "sphsolid", 0)


class OptionalCache(FunctionCache):
    """numba's cache of one kernel, which may fail without harm; it stores what anybody can read."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The stored kernel for these types, or None."""
        if any(map(is_foreign, sig)):
            return None
        try:
            return super().load_overload(sig, target_context)
        except Exception:
            # Whatever is wrong with what is there, it can be made anew.
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store a kernel, if that can be done."""
        if any(map(is_foreign, sig)):
            return
        try:
            super().save_overload(sig, data)
        except OSError as failure:
            say_not_kept(failure)
