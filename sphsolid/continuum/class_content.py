"""What a class holds that a user wrote: attributes, properties and methods of it and its bases."""

from __future__ import annotations

import enum
import functools
import types
from collections import namedtuple
from collections.abc import Callable, Iterator
from typing import Any

from sphsolid.continuum.known_by_name import known_by_name


class _NoMembers(enum.Enum):
    pass


#: What Python itself writes into a class; none of it is a value that a formula reads.
_WRITTEN = {
    "__doc__", "__module__", "__qualname__", "__dict__", "__weakref__", "__annotations__",
    "__orig_bases__", "__parameters__", "__type_params__", "__firstlineno__", "__annotate__",
    "__annotate_func__", "__annotations_cache__", "__static_attributes__", "__abstractmethods__",
    "_abc_impl", "__dataclass_fields__", "__dataclass_params__",
    # Kept in the class by the first pickle or copy of an object.
    "__slotnames__",
}  # fmt: skip
_OF_TUPLES = vars(namedtuple("_NoFields", ())).keys() - {"__slots__"}
_OF_ENUMS = vars(_NoMembers).keys()
_PLACES = (
    types.MemberDescriptorType, types.GetSetDescriptorType, types.WrapperDescriptorType,
    types.MethodDescriptorType, types.ClassMethodDescriptorType,
    type(vars(namedtuple("_OneField", "x"))["x"]),
)  # fmt: skip


def is_open(kind: type) -> bool:
    """False for a class that numba has compiled (``jitclass``)."""
    return not type(kind).__module__.startswith("numba.")


def attributes_of(kind: type) -> Iterator[tuple[str, Any]]:
    """Name and value of all that a class and its bases hold, those of libraries left out."""
    for base in reversed(kind.__mro__):
        if known_by_name(base):
            continue
        left_out = set(_WRITTEN)
        if "_fields" in vars(base):
            left_out |= _OF_TUPLES
        if isinstance(base, enum.EnumMeta):
            left_out |= _OF_ENUMS | base.__members__.keys()
        for name in sorted(vars(base).keys() - left_out):
            yield name, vars(base)[name]


def copy_of_attribute(
    value: Any, read: Callable[[Any], Any], note: Callable[..., None]
) -> Any:
    """Copy of what a class holds under a name, its functions replaced by what ``read`` returns."""
    if isinstance(value, property):
        note("property")
        return property(read(value.fget), read(value.fset), read(value.fdel))
    if isinstance(value, staticmethod | classmethod):
        note(type(value).__name__)
        return type(value)(read(value.__func__))
    if isinstance(value, functools.cached_property):
        note("cached")
        return property(read(value.func))
    if isinstance(value, _PLACES):
        note("place", type(value).__name__)
        return value
    return read(value)
