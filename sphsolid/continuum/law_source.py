"""All that makes up a law, read once: a hash of it, and copies that a later edit cannot change.

A kernel is as old as the oldest text in it.  :func:`read` follows a law's functions into what they
call and the values they use: constants and helper functions of their modules, of modules they
import, and of closures, decorated for numba or not.  What is read is the compiled text (bytecode),
which a notebook, a text given to ``exec`` and a file all have.  NumPy, the standard library's
mathematics, numba and this package itself count by name: the package's sources are in the key of
the kernel cache already.

The copies call copies.  numba keeps what it compiled of a helper function for as long as the
process lives, with the constants it had then; a copy made after a change is a new function.
"""

from __future__ import annotations

import dis
import enum
import hashlib
import itertools
import os
import sys
from collections.abc import Iterator
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, ModuleType
from typing import Any

import numba
import numpy as np
from numba.core.registry import cpu_target

from sphsolid.compiled import inlined

#: Packages that count by name.
_BY_NAME = {"builtins", "math", "cmath", "operator", "numpy", "numba", "llvmlite", "scipy"}
_PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis), np.generic, np.dtype)
_copies = itertools.count()


def is_ours(thing: Any) -> bool:
    """True for what is defined in a room whose sources are in the kernel cache's own key."""
    return str(getattr(thing, "__module__", "")).startswith("sphsolid.continuum.")


def _by_name(module: str) -> bool:
    return module.split(".")[0] in _BY_NAME or module.startswith("sphsolid.continuum")


def _names(code: CodeType, kinds: tuple[str, ...]) -> Iterator[str]:
    for instruction in dis.get_instructions(code):
        if instruction.opname in kinds:
            yield str(instruction.argval)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant, kinds)


class LawSource:
    """``digest`` of everything read so far; ``copies`` of the functions met."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256(f"{sys.version_info[:2]} {numba.__version__}".encode())
        #: Copy of every function met, and the function, so that its id stays its own.
        self._met: dict[int, tuple[FunctionType, FunctionType]] = {}
        self._modules: dict[tuple[str, frozenset[str]], ModuleType] = {}
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

        ``attributes`` are the names that may be asked of a module.
        """
        if isinstance(thing, _PLAIN):
            self.note(type(thing).__name__, repr(thing))
            return thing
        if isinstance(thing, numba.core.dispatcher.Dispatcher):
            self.note("compiled", sorted(thing.targetoptions.items(), key=str))
            return numba.jit(**thing.targetoptions)(self._function(thing.py_func))
        if isinstance(thing, FunctionType):
            return self._python_function(thing)
        if isinstance(thing, ModuleType):
            return self._module(thing, attributes)
        return self._value(thing, attributes)

    def _value(self, thing: Any, attributes: frozenset[str]) -> Any:
        if isinstance(thing, enum.Enum):
            self.note("member", thing, repr(thing.value))
            return thing
        if isinstance(thing, np.ndarray):
            self.note("array", thing.dtype.str, thing.shape, thing.tobytes().hex())
            return thing
        if isinstance(thing, tuple | list):
            self.note(type(thing).__name__, getattr(thing, "_fields", ""), len(thing))
            copies = [self.read(item, attributes) for item in thing]
            return copies if isinstance(thing, list) else _rebuilt(thing, copies)
        if isinstance(thing, dict):
            self.note("dict", len(thing))
            return {key: self.read(value, attributes) for key, value in thing.items()}
        if isinstance(thing, type | BuiltinFunctionType | np.ufunc) or _by_name(
            str(getattr(thing, "__module__", ""))
        ):
            name = getattr(thing, "__qualname__", getattr(thing, "__name__", repr(thing)))
            self.note("named", getattr(thing, "__module__", ""), name)
            self.note(getattr(thing, "_fields", ""))
            return thing
        # What cannot be followed is never taken for what another process had.
        self.note("unknown", os.getpid(), id(thing), os.urandom(8).hex())
        return thing

    def _module(self, module: ModuleType, attributes: frozenset[str]) -> ModuleType:
        self.note("module", module.__name__)
        if _by_name(module.__name__):
            return module
        known = self._modules.get((module.__name__, attributes))
        if known is not None:
            return known
        # numba tells modules apart by their names.
        copy = ModuleType(f"{module.__name__}_copy_{next(_copies)}")
        self._modules[module.__name__, attributes] = copy
        for name in sorted(attributes & vars(module).keys()):
            self.note(name)
            setattr(copy, name, self.read(getattr(module, name), attributes))
        return copy

    def _python_function(self, function: FunctionType) -> Any:
        if _by_name(function.__module__ or ""):
            self.note("named", function.__module__, function.__qualname__)
            return function
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
        copy = FunctionType(code, known, function.__name__, function.__defaults__, cells)
        copy.__kwdefaults__ = function.__kwdefaults__
        copy.__qualname__ = function.__qualname__
        copy.__module__ = function.__module__
        self._met[id(function)] = (copy, function)
        self.copies.append(copy)
        asked = frozenset(_names(code, ("LOAD_ATTR", "LOAD_METHOD")))
        for name in sorted(set(_names(code, ("LOAD_GLOBAL", "LOAD_NAME")))):
            if name in function.__globals__:
                self.note("global", name)
                known[name] = self.read(function.__globals__[name], asked)
        for cell, original in zip(cells, function.__closure__ or (), strict=True):
            cell.cell_contents = self.read(original.cell_contents, asked)
        self.read(function.__defaults__)
        self.read(function.__kwdefaults__)
        return copy

    def _code(self, code: CodeType) -> None:
        self.note(
            code.co_code.hex(), code.co_names, code.co_varnames, code.co_freevars,
            code.co_cellvars, code.co_argcount, code.co_kwonlyargcount, code.co_flags,
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
