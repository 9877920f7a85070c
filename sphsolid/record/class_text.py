"""What a class of a user's own does, in a few digits: an edit of its text is seen.

The sources of this package are known by their hash and libraries by their versions; a user's file
is known by nothing.  As for laws (``continuum.law_source``), what is read is the compiled text
(bytecode): a file, a notebook and a text given to ``exec`` all have it, and comments do not count.
Read are the methods and attributes of the class and its bases, and the user's functions, classes
and constants that these name.  What the text itself writes to is no part of it, nor are lists and
dicts, which may fill up while a simulation runs.  Nothing is refused: a law can make a kernel old,
and must be read completely; here something unreadable is left out.
"""

from __future__ import annotations

import dis
import functools
import hashlib
import sys
import sysconfig
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher

from sphsolid.continuum.class_content import attributes_of
from sphsolid.record.array_words import array_words

#: Their sources are in the hash that a checkpoint has of the kernels.
_OURS = ("sphsolid", "fem_reference")
_PATHS = sysconfig.get_paths()
_LIBRARIES = tuple({Path(_PATHS[name]) for name in ("stdlib", "purelib", "platlib")})
#: CPython's flag of classes that are made while a program runs.
_MADE_BY_PYTHON = 1 << 9
_PLAIN = (bool, int, float, complex, str, bytes, type(None))
_READS, _WRITES = ("LOAD_GLOBAL", "LOAD_NAME"), ("STORE_GLOBAL", "STORE_ATTR")
_ATTRIBUTES = ("LOAD_ATTR", "LOAD_METHOD")
#: What makes an object; whatever else writes to its attributes changes it while it is used.
_MAKERS = ("__init__", "__post_init__", "__new__", "__setstate__")


def text_of(made_by: type | FunctionType) -> str:
    """Twelve digits of what a class or function does; empty for one of this package or a library.

    Empty too where it cannot be read at all.
    """
    if is_known(made_by):
        return ""
    reader = _Reader()
    try:
        reader.read("", made_by)
    except Exception:
        # A class may do anything when its attributes are looked at.
        return ""
    return reader.digest


def is_known(thing: type | FunctionType) -> bool:
    """True for what is defined in this package or in a library."""
    if isinstance(thing, FunctionType):
        home = thing.__globals__.get("__name__")
        return isinstance(home, str) and _is_known_module(home)
    if thing.__module__ == "builtins":
        # A class of a text that was executed without a name says this too.
        return not thing.__flags__ & _MADE_BY_PYTHON
    return _is_known_module(thing.__module__)


def changed_by_use(kind: type) -> set[str]:
    """Attributes that methods of ``kind`` other than its makers write to: state, no parameters."""
    found: set[str] = set()
    for name, value in attributes_of(kind):
        if name not in _MAKERS and isinstance(value, FunctionType):
            found.update(_named(value.__code__, ("STORE_ATTR",)))
    return found


def _is_known_module(name: str) -> bool:
    root = name.split(".")[0]
    if root in _OURS:
        return True
    module = sys.modules.get(root)
    if module is None or root == "__main__":
        return False
    places = [getattr(module, "__file__", None) or "", *getattr(module, "__path__", ())]
    if not any(places):
        return root in sys.stdlib_module_names
    return any(Path(place).is_relative_to(lib) for place in places if place for lib in _LIBRARIES)


@cache
def _instructions(code: CodeType) -> tuple[tuple[str, str], ...]:
    return tuple((each.opname, str(each.argval)) for each in dis.get_instructions(code))


def _named(code: CodeType, kinds: tuple[str, ...]) -> Iterator[str]:
    yield from (name for kind, name in _instructions(code) if kind in kinds)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _named(constant, kinds)


class _Reader:
    def __init__(self) -> None:
        self._words: list[tuple[str, str]] = []
        self._met: dict[int, object] = {}
        self._written: set[str] = set()

    @property
    def digest(self) -> str:
        kept = [f"{name}\x1f{text}" for name, text in self._words if name not in self._written]
        return hashlib.sha256("\x1e".join(kept).encode()).hexdigest()[:12]

    def read(self, name: str, thing: Any, asked: frozenset[str] = frozenset()) -> None:
        """Take in ``thing``, found under ``name``; ``asked`` may be asked of a module."""
        if isinstance(thing, _PLAIN):
            self._words.append((name, f"{type(thing).__name__} {thing!r}"))
        elif isinstance(thing, np.ndarray | np.generic):
            self._words.append((name, array_words(np.asarray(thing))))
        elif id(thing) not in self._met:
            # Kept, so that its id stays its own.
            self._met[id(thing)] = thing
            self._parts(name, thing, asked)

    def _parts(self, name: str, thing: Any, asked: frozenset[str]) -> None:
        if isinstance(thing, FunctionType):
            self._function(thing)
        elif isinstance(thing, Dispatcher):
            self.read(name, thing.py_func)
        elif isinstance(thing, type):
            self._class(thing)
        elif isinstance(thing, ModuleType):
            if not _is_known_module(thing.__name__):
                for word in sorted(asked & vars(thing).keys()):
                    self.read(word, vars(thing)[word], asked)
        elif isinstance(thing, tuple):
            self._each(name, thing)
        elif isinstance(thing, frozenset):
            self._words.append((name, str(sorted(map(repr, thing)))))
        elif is_dataclass(thing):
            self.read(name, type(thing))
            self._each(name, [getattr(thing, each.name, None) for each in fields(thing)])
        elif isinstance(thing, property):
            self._each(name, (thing.fget, thing.fset, thing.fdel))
        elif isinstance(thing, staticmethod | classmethod):
            self.read(name, thing.__func__)
        elif isinstance(thing, functools.cached_property):
            self.read(name, thing.func)
        elif isinstance(thing, functools.partial):
            self._each(name, (thing.func, thing.args, tuple(sorted(thing.keywords.items()))))

    def _each(self, name: str, things: Any) -> None:
        for thing in things:
            self.read(name, thing)

    def _class(self, kind: type) -> None:
        if is_known(kind):
            self._words.append(("", kind.__qualname__))
            return
        self._words.append(("", " ".join(base.__qualname__ for base in kind.__mro__)))
        for name, value in attributes_of(kind):
            self.read(name, value)

    def _function(self, function: FunctionType) -> None:
        if is_known(function):
            self._words.append(("", function.__qualname__))
            return
        code = function.__code__
        self._code(code, function.__doc__)
        self._written.update(_named(code, _WRITES))
        asked = frozenset(_named(code, _ATTRIBUTES))
        for name in sorted(set(_named(code, _READS)) & function.__globals__.keys()):
            self.read(name, function.__globals__[name], asked)
        for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
            try:
                held = cell.cell_contents
            except ValueError:
                continue
            self.read(name, held, asked)
        self._each("", function.__defaults__ or ())
        self._each("", tuple(sorted((function.__kwdefaults__ or {}).items())))

    def _code(self, code: CodeType, documentation: str | None) -> None:
        words = (
            code.co_name, code.co_code.hex(), code.co_names, code.co_varnames, code.co_freevars,
            code.co_argcount, code.co_kwonlyargcount, code.co_exceptiontable.hex(),
        )  # fmt: skip
        self._words.append(("", repr(words)))
        for constant in code.co_consts:
            if isinstance(constant, CodeType):
                self._code(constant, None)
            elif isinstance(constant, frozenset):
                self._words.append(("", str(sorted(map(repr, constant)))))
            elif documentation is None or constant != documentation:
                self._words.append(("", repr(constant)))
