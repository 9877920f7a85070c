"""Four numbers side by side, which a kernel adds and multiplies in one instruction.

The loops over the ten multipliers of a pair are too short for the compiler to use vector registers
by itself.  ``Lanes`` is such a register as a number of its own: ``lanes_of`` reads one from a
table ``(N, m, 4)``, ``+``, ``-``, ``*`` act on each of the four, a float may stand on the left of
``*``, and ``set_lanes`` writes it back.  Every operation is that of IEEE arithmetic, one after the
other as written: the bits are those of four loops.
"""

from __future__ import annotations

import operator
from typing import Any

import sphsolid.compiled  # noqa: F401  (chooses numba's threads and cache before numba is used)

# ruff: isort: split
from llvmlite import ir
from numba import types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model
from numba.np.arrayobj import make_array

#: Numbers of a register: the three components of a vector, and one that is not used.
WIDTH = 4
_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)
_INDEX = ir.IntType(32)


class LanesType(types.Type):
    """The type of ``Lanes`` inside kernels; there is none outside."""

    def __init__(self) -> None:
        super().__init__("Lanes")


LANES = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _spread(builder: Any, value: Any) -> Any:
    """The same float in every lane."""
    undefined = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(undefined, value, ir.Constant(_INDEX, 0))
    everywhere = ir.Constant(ir.VectorType(_INDEX, WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(one, undefined, everywhere)


def _arithmetic(symbol: Any, instruction: str) -> None:
    @infer_global(symbol)
    class _Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            if len(args) == 2 and args[1] == LANES and args[0] in (LANES, types.float64):
                return signature(LANES, *args)
            return None

    @lower_builtin(symbol, LANES, LANES)
    def _both(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args)

    @lower_builtin(symbol, types.float64, LANES)
    def _scaled(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return getattr(builder, instruction)(_spread(builder, args[0]), args[1])


_arithmetic(operator.add, "fadd")
_arithmetic(operator.sub, "fsub")
_arithmetic(operator.mul, "fmul")


def _place(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Pointer to the lanes ``[row, column]`` of a table."""
    table = make_array(sig.args[0])(context, builder, args[0])
    row, column = (
        context.cast(builder, args[i], sig.args[i], types.intp) for i in (1, 2)
    )
    columns = builder.extract_value(table.shape, 1)
    at = builder.add(builder.mul(row, columns), column)
    at = builder.mul(at, context.get_constant(types.intp, WIDTH))
    return builder.bitcast(builder.gep(table.data, [at]), _VECTOR.as_pointer())


def _is_table(table: Any) -> bool:
    return bool(table.ndim == 3 and table.layout == "C" and table.dtype == types.float64)


@intrinsic
def lanes_of(typingctx, table, row, column):  # type: ignore[no-untyped-def]
    """``table[row, column, :]`` of a contiguous ``(N, m, 4)``."""
    if not _is_table(table):
        return None

    def generate(context, builder, sig, args):  # type: ignore[no-untyped-def]
        value = builder.load(_place(context, builder, sig, args))
        value.align = 8
        return value

    return LANES(table, row, column), generate


@intrinsic
def set_lanes(typingctx, table, row, column, value):  # type: ignore[no-untyped-def]
    """``table[row, column, :] = value`` of a contiguous ``(N, m, 4)``."""
    if not _is_table(table):
        return None

    def generate(context, builder, sig, args):  # type: ignore[no-untyped-def]
        stored = builder.store(args[3], _place(context, builder, sig, args))
        stored.align = 8
        return context.get_dummy_value()

    return types.none(table, row, column, value), generate


@intrinsic
def no_lanes(typingctx):  # type: ignore[no-untyped-def]
    """Four zeros."""

    def generate(context, builder, sig, args):  # type: ignore[no-untyped-def]
        return ir.Constant(_VECTOR, [0.0] * WIDTH)

    return LANES(), generate
