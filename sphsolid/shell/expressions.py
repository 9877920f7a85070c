"""Formulas in a case file: arithmetic and functions of numpy in ``X, Y, Z, t``, and nothing else.

A formula is read by Python's parser and worked out here, node by node.  What is not on the lists
of this file is refused before anything is computed: no names but the variables, no attributes, no
indices, no strings.
"""

from __future__ import annotations

import ast
import functools
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, nearest, require

Array = NDArray[np.float64]
CONSTANTS = {"pi": math.pi, "e": math.e}
FUNCTIONS: dict[str, tuple[Callable[..., Any], tuple[int, ...]]] = {
    **{name: (getattr(np, name), (1,)) for name in (
        "sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "exp", "log",
        "log10", "sqrt", "abs", "sign", "floor", "ceil",
    )},
    **{name: (getattr(np, name), (2,)) for name in (
        "arctan2", "hypot", "minimum", "maximum", "heaviside",
    )},
    "min": (np.minimum, (2,)),
    "max": (np.maximum, (2,)),
    "where": (np.where, (3,)),
    "clip": (np.clip, (3,)),
}  # fmt: skip
_BINARY: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: np.power, ast.Mod: operator.mod,
}  # fmt: skip
_UNARY: dict[type[ast.AST], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos, ast.USub: operator.neg, ast.Not: np.logical_not,
}  # fmt: skip
_COMPARED: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
    ast.Eq: operator.eq, ast.NotEq: operator.ne,
}  # fmt: skip
#: Longer or deeper ones are no formulas any more.
_LONGEST, _DEEPEST = 2000, 60


@functools.lru_cache(maxsize=512)
def parsed(text: str, names: tuple[str, ...]) -> ast.expr:
    """The tree of a formula in ``names``; raises ``InputError`` for anything that is none."""
    require(len(text) <= _LONGEST, f"the formula is longer than {_LONGEST} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else str(error)
        hint = "; write ** for a power" if "^" in text else ""
        raise InputError(f"{text!r} is no formula: {reason}{hint}") from None
    try:
        _check(tree, text, names, 0)
    except RecursionError:
        raise InputError(f"{text[:60]!r} ... is nested more than {_DEEPEST} deep") from None
    return tree


def _check(node: ast.expr, text: str, names: tuple[str, ...], depth: int) -> None:
    require(depth <= _DEEPEST, f"{text!r} is nested more than {_DEEPEST} deep")
    if isinstance(node, ast.Name):
        known = [*names, *CONSTANTS]
        if node.id not in known:
            called = "; a function needs its brackets" if node.id in FUNCTIONS else ""
            raise InputError(
                f"{text!r} has an unknown name {node.id!r}{called or nearest(node.id, known)}; "
                f"known here: {', '.join(known)}"
            )
    elif isinstance(node, ast.Constant):
        require(
            isinstance(node.value, int | float) and not isinstance(node.value, bool),
            f"{text!r}: {node.value!r} is not a number",
        )
    elif isinstance(node, ast.Call):
        _check_call(node, text)
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitXor):
        raise InputError(f"{text!r}: ^ is no power; write **")
    elif not (
        (isinstance(node, ast.BinOp) and type(node.op) in _BINARY)
        or (isinstance(node, ast.UnaryOp) and type(node.op) in _UNARY)
        or (isinstance(node, ast.Compare) and all(type(op) in _COMPARED for op in node.ops))
        or isinstance(node, ast.BoolOp | ast.IfExp)
    ):
        raise InputError(
            f"{text!r} is no formula of numbers: {ast.unparse(node)!r} is not allowed; use "
            "arithmetic, comparisons and functions"
        )
    for child in _children(node):
        _check(child, text, names, depth + 1)


def _check_call(node: ast.Call, text: str) -> None:
    name = node.func.id if isinstance(node.func, ast.Name) else ast.unparse(node.func)
    if name not in FUNCTIONS:
        raise InputError(
            f"{text!r} calls an unknown function {name!r}{nearest(name, FUNCTIONS)}; known are "
            f"{', '.join(FUNCTIONS)}"
        )
    counts = FUNCTIONS[name][1]
    require(
        not node.keywords and len(node.args) in counts,
        f"{text!r}: {name} takes {counts[0]} argument{'s' if counts[0] > 1 else ''}, by position",
    )


def _children(node: ast.expr) -> Sequence[ast.expr]:
    if isinstance(node, ast.Call):
        return node.args
    return [child for child in ast.iter_child_nodes(node) if isinstance(child, ast.expr)]


def value_of(text: str, variables: Mapping[str, Any]) -> Any:
    """The formula worked out by the rules of numpy: ``1/0`` is infinite, a root of -1 is nan.

    Both sides of a choice are worked out, and one is taken.  Raises ``InputError`` where it
    cannot be worked out.
    """
    tree = parsed(text, tuple(variables))
    known = {name: np.asarray(value, dtype=float)[()] for name, value in variables.items()}
    try:
        with np.errstate(all="ignore"):
            return _value(tree, known)
    except (OverflowError, ZeroDivisionError, ValueError, TypeError) as error:
        raise InputError(f"{text!r} cannot be worked out: {error}") from None


def _value(node: ast.expr, names: Mapping[str, Any]) -> Any:
    if isinstance(node, ast.Constant):
        # A float: powers of whole numbers could grow without end.  One of numpy: no exceptions.
        return np.float64(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return names[node.id] if node.id in names else np.float64(CONSTANTS[node.id])
    if isinstance(node, ast.BinOp):
        return _BINARY[type(node.op)](_value(node.left, names), _value(node.right, names))
    if isinstance(node, ast.UnaryOp):
        return _UNARY[type(node.op)](_value(node.operand, names))
    if isinstance(node, ast.Call):
        assert isinstance(node.func, ast.Name)
        return FUNCTIONS[node.func.id][0](*(_value(each, names) for each in node.args))
    if isinstance(node, ast.IfExp):
        return np.where(*(_value(each, names) for each in (node.test, node.body, node.orelse)))
    if isinstance(node, ast.BoolOp):
        join = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
        return functools.reduce(join, [_value(each, names) for each in node.values])
    assert isinstance(node, ast.Compare)
    sides = [_value(each, names) for each in (node.left, *node.comparators)]
    pairs = zip(node.ops, sides[:-1], sides[1:], strict=True)
    return functools.reduce(np.logical_and, [_COMPARED[type(op)](a, b) for op, a, b in pairs])


def number_in(text: str) -> float:
    """A number written as a formula without variables: ``1/6``, ``2*pi``.

    Raises ``InputError`` where it is not finite.
    """
    found = float(value_of(text, {}))
    require(math.isfinite(found), f"{text!r} is {found}, which is no finite number")
    return found


def is_finite_somewhere(text: str, names: Sequence[str]) -> bool:
    """Whether a formula in ``names`` is a finite number at any of a few places and times."""
    tried = np.random.default_rng(0).uniform(0.01, 2.0, (len(names), 64))
    signs = np.where(np.arange(64) % 2, 1.0, -1.0)
    values = {
        # Times are not negative.
        name: row if name in AND_TIME else row * signs
        for name, row in zip(names, tried, strict=True)
    }
    return bool(np.isfinite(np.asarray(value_of(text, values), dtype=float)).any())


def is_condition(text: str, names: Sequence[str]) -> bool:
    """Whether a formula says yes or no."""
    return np.asarray(value_of(text, dict.fromkeys(names, 0.5))).dtype == bool


@dataclass(frozen=True)
class Condition:
    """A formula that is true or false at ``X (n, 3)`` [m]."""

    text: str

    def __call__(self, X: Array) -> NDArray[np.bool_]:
        """Which points ``(n,)``."""
        found = value_of(self.text, {"X": X[:, 0], "Y": X[:, 1], "Z": X[:, 2]})
        return np.broadcast_to(np.asarray(found, dtype=bool), (len(X),)).copy()


PLACE, AND_TIME, AND_NORMAL = ("X", "Y", "Z"), ("t",), ("NX", "NY", "NZ")


@dataclass(frozen=True)
class Field:
    """Three formulas, the components of a vector ``(n, 3)`` at ``X (n, 3)`` [m]."""

    parts: tuple[str, str, str]

    def __call__(self, X: Array) -> Array:
        """The vectors."""
        return self._at(X, {})

    def _at(self, X: Array, more: Mapping[str, Any]) -> Array:
        names = {"X": X[:, 0], "Y": X[:, 1], "Z": X[:, 2], **more}
        found = np.empty((len(X), 3))
        for k, part in enumerate(self.parts):
            found[:, k] = value_of(part, names)
        return found


@dataclass(frozen=True)
class TimeField(Field):
    """The same of place and time ``t`` [s]."""

    def __call__(self, X: Array, t: float) -> Array:  # type: ignore[override]
        """The vectors at ``t``."""
        return self._at(X, {"t": float(t)})


@dataclass(frozen=True)
class FaceField(Field):
    """The same of place, outward normal ``NX, NY, NZ`` of the undeformed body, and time."""

    def __call__(self, X: Array, N: Array, t: float) -> Array:  # type: ignore[override]
        """The vectors at ``t``."""
        normal = dict(zip(AND_NORMAL, N.T, strict=True))
        return self._at(X, {**normal, "t": float(t)})


#: The variables of each kind of field.
VARIABLES: dict[type[Field], tuple[str, ...]] = {
    Field: PLACE, TimeField: (*PLACE, *AND_TIME), FaceField: (*PLACE, *AND_NORMAL, *AND_TIME),
}  # fmt: skip
