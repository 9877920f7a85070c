"""Can kernels compile a law?  Asked before a solver compiles anything, answered in one sentence."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba

from sphsolid.compiled import serial_kernel
from sphsolid.continuum import law
from sphsolid.continuum.law_registry import law_of
from sphsolid.continuum.tensor import IDENTITY, axpy, contract, scale
from sphsolid.errors import InputError

_COMPILED: set[type] = set()
_OUT = numba.float64[::1]
_NUMBER = numba.float64
_TENSOR = numba.types.UniTuple(_NUMBER, 9)
#: Beginnings of lines that say where numba was, not what it met.
_WHERE = (
    "failed in nopython", "- resolution failure", "during", "file ", "there are", "overload",
    "rejected as", "with argument", "candidate", "- of which", "note:", "enable", "this error",
    "resolution failure", "<source",
)  # fmt: skip
#: What numba says of the thing itself; the first of these that occurs is told.
_TELLING = (
    "Unknown attribute", "Untyped global name", "Untyped freevar name", "Cannot determine",
    "is not defined", "Use of unsupported", "unsupported", "Unsupported", "not supported",
    "Cannot unify", "No implementation of function", "Invalid use",
)  # fmt: skip


@serial_kernel
def every_function(material, out):  # type: ignore[no-untyped-def]
    """Call all that a law is asked for; it lies in the kernel cache once it has been compiled."""
    F, J = scale(out[0], IDENTITY), out[1]
    S_F, S_H, S_J = law.conjugate_stresses(material, F, F, J)
    dS_F, dS_H, dS_J = law.hessian_action(material, F, F, J, F, F, J)
    P = axpy(S_J, S_H, axpy(1.0, S_F, law.first_piola(material, F, F, J)))
    dP = axpy(dS_J, dS_H, axpy(1.0, dS_F, P))
    out[2] = law.energy(material, F, F, J) + contract(P, dP)
    out[3] = law.volumetric_energy(material, J)
    out[4] = law.volumetric_pressure(material, J)
    out[5] = law.volumetric_stiffness(material, J)


def require_compilable(material: Any) -> None:
    """Raise ``InputError`` unless kernels can compile the law of ``material``.

    ``material`` is what ``in_kernels`` returned.  Of this package's laws nothing is asked; of
    another, once in a process, and from the kernel cache where it was compiled before.
    """
    kind = type(material)
    if kind.__module__ != "sphsolid.continuum.law_types" or kind in _COMPILED:
        return
    compiler: Any = every_function
    try:
        compiler.compile((numba.typeof(material), _OUT))
    except Exception as failure:
        raise InputError(_what_fails(material, failure)) from None
    _COMPILED.add(kind)


def _what_fails(material: Any, failure: Exception) -> str:
    functions = law_of(type(material))
    state = (_TENSOR, _TENSOR, _NUMBER)
    asked: tuple[tuple[str, Callable[..., Any], tuple[Any, ...]], ...] = (
        ("energy", functions.energy, state),
        ("conjugate_stresses", functions.conjugate_stresses, state),
        ("first_piola", functions.first_piola, state),
        ("hessian_action", functions.hessian_action, 2 * state),
        ("U, the first of `volumetric`,", functions.volumetric.energy, (_NUMBER,)),
        ("U', the second of `volumetric`,", functions.volumetric.pressure, (_NUMBER,)),
        ("U'', the third of `volumetric`,", functions.volumetric.stiffness, (_NUMBER,)),
    )
    which, why = "what its functions return", failure
    for name, function, types in asked:
        try:
            numba.njit(_call_of(function, len(types))).compile((numba.typeof(material), *types))
        except Exception as alone:
            which, why = name, alone
            break
    kind: Any = type(material)
    name = kind.__base__.__name__
    said = _telling(str(why).replace(kind.__name__, name))
    return (
        f"law {name}: kernels cannot compile {which}: {said}; use the fields of the parameters, "
        "numbers, tuples, functions of the same kind, and math or NumPy functions only "
        "(docs/laws.md)"
    )


def _call_of(function: Callable[..., Any], count: int) -> Callable[..., Any]:
    """A call as kernels make it: of a function that may take any number of arguments."""
    calls: dict[int, Callable[..., Any]] = {
        1: lambda m, J: function(m, J),
        3: lambda m, F, H, J: function(m, F, H, J),
        6: lambda m, F, H, J, dF, dH, dJ: function(m, F, H, J, dF, dH, dJ),
    }
    return calls[count]


def _telling(text: str) -> str:
    """The line of numba's message that names the thing it met, without numba's names of types."""
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and not line.lower().startswith(_WHERE)]
    for words in _TELLING:
        for line in reversed(lines):
            if words in line:
                return _short(line)
    return _short(lines[0] if lines else "numba says nothing")


def _short(line: str) -> str:
    return line if len(line) <= 160 else f"{line[:157]}..."
