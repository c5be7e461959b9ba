"""Functions that are compiled once, and called by their address.

Numba compiles whatever a kernel calls again with each kernel. What is long, and slow next to a
call, had better be a `cfunc` of its own. Such a one takes the address of a row of float32, two
vectors, and the address of three float64 for what it finds.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from engine.numerics.memory import load_double, stack_words

SIGNATURE = types.void(
    types.uint64,
    types.float64, types.float64, types.float64,
    types.float64, types.float64, types.float64,
    types.uint64,
)  # fmt: skip


@intrinsic
def _far_call(
    typing_context: Any, function: Any, row: Any, ax: Any, ay: Any, az: Any, bx: Any, by: Any,
    bz: Any, found: Any,
) -> Any:  # fmt: skip
    """Call the function at an address with arguments as of SIGNATURE."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word, number = ir.IntType(64), ir.DoubleType()
        kind = ir.FunctionType(ir.VoidType(), [word, *[number] * 6, word])
        function, *rest = arguments
        builder.call(builder.inttoptr(function, kind.as_pointer()), rest)
        return context.get_dummy_value()

    return types.void(types.uint64, *SIGNATURE.args), generate


@njit
def call(function, row, a, b):
    """What the function at an address finds; `row` an array of float32, a, b tuples of three."""
    found = stack_words(6)
    _far_call(function, row.ctypes.data, a[0], a[1], a[2], b[0], b[1], b[2], found)
    return load_double(found, 0), load_double(found, 1), load_double(found, 2)
