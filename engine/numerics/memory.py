"""Plain memory for kernels: words of a block that stands still, and scratch on the stack.

A kernel that is handed arrays pays for their descriptors at every call that is not inlined; the
address of a block is one number. Loads count as invariant: the block must not change any more.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic


def _loader(kind: Any, what: ir.Type, *, stands: bool = True) -> Any:
    size = {ir.FloatType(): 4, ir.DoubleType(): 8}.get(what) or what.width // 8

    def load(typing_context: Any, address: Any, index: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            base = builder.inttoptr(arguments[0], what.as_pointer())
            value = builder.load(builder.gep(base, [arguments[1]]), align=size)
            if stands:
                value.set_metadata("invariant.load", builder.module.add_metadata([]))
            return value

        return kind(types.uint64, types.int64), generate

    return intrinsic(load)


float32_at = _loader(types.float32, ir.FloatType())
int32_at = _loader(types.int32, ir.IntType(32))
uint16_at = _loader(types.uint16, ir.IntType(16))
uint8_at = _loader(types.uint8, ir.IntType(8))
uint64_at = _loader(types.uint64, ir.IntType(64))


load_float = _loader(types.float32, ir.FloatType(), stands=False)
load_int = _loader(types.int32, ir.IntType(32), stands=False)
load_double = _loader(types.float64, ir.DoubleType(), stands=False)


def _storer(kind: Any, what: ir.Type) -> Any:
    def store(typing_context: Any, address: Any, index: Any, value: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            base = builder.inttoptr(arguments[0], what.as_pointer())
            builder.store(arguments[2], builder.gep(base, [arguments[1]]), align=4)
            return context.get_dummy_value()

        return types.void(types.uint64, types.int64, kind), generate

    return intrinsic(store)


store_float = _storer(types.float32, ir.FloatType())
store_int = _storer(types.int32, ir.IntType(32))
store_double = _storer(types.float64, ir.DoubleType())


@intrinsic
def stack_words(typing_context: Any, count: Any) -> Any:
    """The address of `count` words of 32 bits, a constant, on the stack.

    They last as long as the function that asks for them.
    """
    if not isinstance(count, types.IntegerLiteral):
        raise TypingError("the room on the stack must be known when a kernel is compiled")
    size = count.literal_value

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = cgutils.alloca_once(builder, ir.ArrayType(ir.IntType(32), size))
        return builder.ptrtoint(place, ir.IntType(64))

    return types.uint64(types.literal(size)), generate
