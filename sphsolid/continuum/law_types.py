"""The types under which kernels know the laws that are not part of this package.

numba stores a compiled kernel under the types of its arguments, and a type by the name of its
class.  A law from a user's file would be stored by the name of that file's module.  An edit of its
text would go unseen.  Another program, which cannot import the module, could not read the list of
what is stored.  A law therefore meets the kernels as an instance of a class of this module whose
name is the hash of all that makes up the law (``law_source``).

A name that this process does not know belongs to another program's law.  It gets an empty class,
so that the list can be read; nothing ever has that type here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_PREFIX = "Law_"
_KNOWN: dict[str, type] = {}


def kernel_type(
    digest: str, parameters: type, attributes: dict[str, Any], again: Callable[..., Any]
) -> type:
    """The subclass of ``parameters`` that stands for the law with this ``digest``.

    It has its own copies of the ``attributes`` of ``parameters``.  An instance is its own copy,
    since nothing in it can change; a pickle of it is ``again(parameters, values)``.
    """
    name = _PREFIX + digest
    own = {word: value for word, value in attributes.items() if not word.startswith("__")}
    content = own | {
        "__slots__": (),
        "__module__": __name__,
        "__copy__": lambda material: material,
        "__deepcopy__": lambda material, memo: material,
        "__repr__": lambda material: repr(tuple.__new__(parameters, material)),
        "__reduce__": lambda material: (again, (parameters, tuple(material))),
    }
    made = type(name, (parameters,), content)
    _KNOWN[name] = made
    return made


def __getattr__(name: str) -> Any:
    if not name.startswith(_PREFIX):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name not in _KNOWN:
        _KNOWN[name] = type(name, (tuple,), {"__module__": __name__, "_fields": ()})
    return _KNOWN[name]
