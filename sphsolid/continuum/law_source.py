"""All that makes up a law, read once: a hash of it, and copies that a later edit cannot change.

A kernel is as old as the oldest text in it.  :meth:`LawSource.read` follows a law's functions into
what they call and the values they use.  These are constants and helper functions of their modules,
of modules they import, and of closures, decorated for numba or not.  Classes count with all they
hold, objects with what a pickle of them would hold.  What is read is the compiled text (bytecode),
which a notebook, a text given to ``exec`` and a file all have.  Libraries and this room count by
name and version (``known_by_name``).  What cannot be followed is refused: a kernel could be older
than it.

The copies call copies.  numba keeps what it compiled of a helper function for as long as the
process lives, with the constants it had then.  A copy made after a change is a new function.  The
same copies are what plain Python calls for a simulation that was built before the change.
"""

from __future__ import annotations

import dis
import enum
import hashlib
import itertools
from collections.abc import Iterator
from types import CellType, CodeType, FunctionType, ModuleType
from typing import Any

import numba
import numpy as np
from numba.core.registry import cpu_target
from numba.np.ufunc.dufunc import DUFunc

from sphsolid.compiled import inlined
from sphsolid.continuum.class_content import attributes_of, copy_of_attribute, is_open
from sphsolid.continuum.known_by_name import known_by_name
from sphsolid.continuum.reduced import parts_of, put_together
from sphsolid.errors import InputError

_PLAIN = {bool, int, float, complex, str, bytes, type(None), type(Ellipsis),
          type(NotImplemented)}  # fmt: skip
_copies = itertools.count()


def is_ours(thing: Any) -> bool:
    """True for what is defined in a room whose sources are in the kernel cache's own key."""
    return str(getattr(thing, "__module__", "")).startswith("sphsolid.continuum.")


def _names(code: CodeType, kinds: tuple[str, ...]) -> Iterator[str]:
    for instruction in dis.get_instructions(code):
        if instruction.opname in kinds:
            yield str(instruction.argval)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant, kinds)


class LawSource:
    """``digest`` of everything read so far; ``copies`` of the functions met."""

    def __init__(self, law: str) -> None:
        self._law = law
        self._hash = hashlib.sha256(f"{numba.__version__} {np.__version__}".encode())
        #: Copy of every function met, and the function, so that its id stays its own.
        self._met: dict[int, tuple[FunctionType, FunctionType]] = {}
        self._classes: dict[int, type] = {}
        self._modules: dict[tuple[int, frozenset[str]], ModuleType] = {}
        #: Names under which what is being read was found, and values it is in.
        self._trail: list[str] = []
        self._within: set[int] = set()
        self.copies: list[FunctionType] = []
        # numba learns of a decorated function when it next compiles one.
        cpu_target.typing_context.refresh()

    @property
    def digest(self) -> str:
        """Sixteen hexadecimal digits."""
        return self._hash.hexdigest()[:16]

    def compilable(self) -> None:
        """Let kernels call the copies."""
        for copy in self.copies:
            inlined(copy)

    def note(self, *words: object) -> None:
        """Add words to what is hashed."""
        self._hash.update("\x1f".join(map(str, words)).encode() + b"\x1e")

    def read(self, thing: Any, attributes: frozenset[str] = frozenset()) -> Any:
        """Hash ``thing`` and return what stands for it in a copy.

        ``attributes`` are the names that may be asked of a module.  Raises ``InputError`` for what
        cannot be followed.
        """
        if type(thing) in _PLAIN or isinstance(thing, np.dtype | numba.types.Type):
            self.note(type(thing).__name__, repr(thing))
            return thing
        if isinstance(thing, np.generic):
            self.note("scalar", repr(thing.dtype), thing.tobytes().hex())
            return thing.copy()
        if words := known_by_name(thing):
            self.note("named", words)
            return thing
        if isinstance(thing, numba.core.dispatcher.Dispatcher):
            self.note("compiled", sorted(thing.targetoptions.items(), key=str))
            return numba.jit(**thing.targetoptions)(self._function(thing.py_func))
        if isinstance(thing, DUFunc):
            self.note("universal", thing.identity)
            return DUFunc(self._function(thing._dispatcher.py_func), identity=thing.identity)
        if isinstance(thing, FunctionType):
            return self._python_function(thing)
        if isinstance(thing, ModuleType):
            return self._module(thing, attributes)
        if isinstance(thing, type):
            return self._class(thing)
        if id(thing) in self._within:
            raise self._refusal(thing, "holds itself")
        self._within.add(id(thing))
        try:
            return self._value(thing, attributes)
        finally:
            self._within.discard(id(thing))

    def attributes(self, kind: type) -> dict[str, Any]:
        """Hash what a class holds, and return copies of it by name."""
        self.note(*map(known_by_name, kind.__mro__))
        return {name: self._attribute(name, value) for name, value in attributes_of(kind)}

    def _attribute(self, name: str, value: Any) -> Any:
        self.note(name)
        return copy_of_attribute(value, lambda part: self._named(name, part), self.note)

    def _named(self, name: str, thing: Any, asked: frozenset[str] = frozenset()) -> Any:
        self.note("name", name)
        self._trail.append(name)
        copy = self.read(thing, asked)
        self._trail.pop()
        return copy

    def _refusal(self, thing: Any, why: str) -> InputError:
        return InputError(
            f"law {self._law} reads {'.'.join(self._trail) or 'a value'}, of type "
            f"{type(thing).__module__}.{type(thing).__qualname__}, which {why}: a compiled kernel "
            "could be older than it; let the law read numbers, NumPy arrays, functions, "
            "NamedTuples and Enums only (docs/laws.md)"
        )

    def _class(self, kind: type) -> type:
        if id(kind) in self._classes:
            self.note("again", list(self._classes).index(id(kind)))
            return kind
        if not is_open(kind):
            raise self._refusal(kind, "is a compiled class")
        self._classes[id(kind)] = kind
        self.note("class", kind.__name__, getattr(kind, "_fields", ""))
        if issubclass(kind, enum.Enum):
            for name, member in kind.__members__.items():
                self._named(name, member.value)
        self.read(dict(getattr(kind, "_field_defaults", {})))
        self.attributes(kind)
        return kind

    def _value(self, thing: Any, attributes: frozenset[str]) -> Any:
        if isinstance(thing, enum.Enum):
            self.note("member", thing.name)
            self.read(type(thing))
            return thing
        if type(thing) is np.ndarray and not thing.dtype.hasobject:
            order = thing.flags.f_contiguous, thing.flags.c_contiguous
            self.note("array", repr(thing.dtype), thing.shape, order, thing.tobytes().hex())
            return thing.copy(order="K")
        if type(thing) in (tuple, list) or hasattr(thing, "_fields"):
            self.read(type(thing))
            self.note(len(thing))
            copies = [self.read(item, attributes) for item in thing]
            return copies if isinstance(thing, list) else _rebuilt(thing, copies)
        if type(thing) is dict:
            self.note("dict", len(thing))
            return {self.read(key): self._named(str(key), thing[key]) for key in thing}
        if type(thing) in (set, frozenset) and all(type(item) in _PLAIN for item in thing):
            self.note("set", sorted(map(repr, thing)))
            return type(thing)(thing)
        if type(thing).__module__.startswith("numba."):
            raise self._refusal(thing, "cannot be followed")
        try:
            parts = parts_of(thing)
        except Exception:
            # An object may do anything when it is asked what a pickle would hold.
            raise self._refusal(thing, "cannot be followed") from None
        copies = [self.read(part) for part in parts]
        try:
            return put_together(copies)
        except Exception:
            raise self._refusal(thing, "cannot be copied") from None

    def _module(self, module: ModuleType, attributes: frozenset[str]) -> ModuleType:
        self.note("module", module.__name__)
        known = self._modules.get((id(module), attributes))
        if known is not None:
            return known
        # numba tells modules apart by their names.
        copy = ModuleType(f"{module.__name__}_copy_{next(_copies)}")
        self._modules[id(module), attributes] = copy
        for name in sorted(attributes & vars(module).keys()):
            setattr(copy, name, self._named(name, getattr(module, name), attributes))
        return copy

    def _python_function(self, function: FunctionType) -> Any:
        other = [f for f in _overloads(function) if not f.__qualname__.startswith("register_jit")]
        if other:
            # What a kernel calls is not this function but what was written in its place.
            for replacement in other:
                self._function(replacement)
            return function
        return self._function(function)

    def _function(self, function: FunctionType) -> FunctionType:
        if id(function) in self._met:
            self.note("again", list(self._met).index(id(function)))
            return self._met[id(function)][0]
        code = function.__code__
        self._code(code)
        known: dict[str, Any] = {"__name__": function.__module__}
        cells = tuple(CellType() for _ in code.co_freevars)
        copy = FunctionType(code, known, function.__name__, None, cells)
        copy.__qualname__ = function.__qualname__
        copy.__module__ = function.__module__
        self._met[id(function)] = (copy, function)
        self.copies.append(copy)
        asked = frozenset(_names(code, ("LOAD_ATTR", "LOAD_METHOD")))
        for name in sorted(set(_names(code, ("LOAD_GLOBAL", "LOAD_NAME")))):
            if name in function.__globals__:
                known[name] = self._named(name, function.__globals__[name], asked)
        closure = zip(code.co_freevars, cells, function.__closure__ or (), strict=True)
        for name, cell, original in closure:
            cell.cell_contents = self._named(name, original.cell_contents, asked)
        copy.__defaults__ = self.read(function.__defaults__)
        copy.__kwdefaults__ = self.read(function.__kwdefaults__)
        return copy

    def _code(self, code: CodeType) -> None:
        self.note(
            code.co_code.hex(), code.co_names, code.co_varnames, code.co_freevars,
            code.co_cellvars, code.co_argcount, code.co_kwonlyargcount, code.co_flags,
            code.co_exceptiontable.hex(),
        )  # fmt: skip
        for constant in code.co_consts:
            if isinstance(constant, CodeType):
                self._code(constant)
            elif isinstance(constant, frozenset):
                self.note("set", sorted(map(repr, constant)))
            else:
                self.note(type(constant).__name__, repr(constant))


def _rebuilt(original: tuple[Any, ...], items: list[Any]) -> tuple[Any, ...]:
    if type(original) is tuple:
        return tuple(items)
    return type(original)(*items) if hasattr(original, "_fields") else original


def _overloads(function: FunctionType) -> list[FunctionType]:
    """What numba was told to compile where ``function`` is called."""
    try:
        known = cpu_target.typing_context.resolve_value_type(function)
    except Exception:  # numba has several kinds of error for "never heard of it"
        return []
    templates = getattr(known, "templates", ())
    return [t._overload_func for t in templates if hasattr(t, "_overload_func")]
