"""The innermost lines of `synthesis`, for all channels at once; addresses are 64-bit numbers."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from engine.numerics import lanes
from engine.numerics.lanes import COUNT, Lanes

_WORD = ir.IntType(64)


@intrinsic
def start(typing_context: Any, reflected: Any, root: Any, below: Any, fx: Any, fy: Any) -> Any:
    """Write the exponentials of what lies between four logarithms to `reflected`, four float32.

    `root` is the address of the upper left ones, three float32, which the right ones follow;
    `below` is how many octets farther the lower ones are.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        at, p, below, *floats = arguments
        right = ir.Constant(_WORD, 12)

        def logarithms(offset: Any) -> Lanes:
            return lanes.load_floats(builder, builder.add(p, offset))

        corners = _square(builder, logarithms, right, below)
        lanes.store_floats(_between(corners, *(lanes.spread(builder, f) for f in floats)).exp(), at)
        return context.get_dummy_value()

    kinds = (types.uint64, types.uint64, types.int64, types.float32, types.float32)
    return types.void(*kinds), generate


@intrinsic
def go_down(
    typing_context: Any, reflected: Any, tap: Any, right: Any, below: Any, step: Any, fx: Any,
    fy: Any, ratio: Any, grey: Any, second: Any,
) -> Any:  # fmt: skip
    """Write what a half reflects, four float32 after those of the whole at `reflected`.

    With e = ratio · exp(-step · code), the first half has 1 / (1 + e) of it, the second
    e / (1 + e). `tap` is the address of the first of four texels, from which the next is so many
    octets to the `right` and that in the next row `below`. Where it is grey one channel is all.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        at, tap, right, below, step, fx, fy, ratio, grey, second = arguments
        step, fx, fy, ratio = (lanes.spread(builder, f) for f in (step, fx, fy, ratio))

        def codes(offset: Any) -> Lanes:
            return lanes.load_octets(builder, builder.add(tap, offset))

        code = _between(_square(builder, codes, right, below), fx, fy) - 128.0
        code = lanes.either(grey, lanes.first_everywhere(code), code)
        e = ratio * (step * code * -1.0).exp()
        part = lanes.either(second, e, 1.0) / (e + 1.0)
        after = builder.add(at, ir.Constant(_WORD, 4 * COUNT))
        lanes.store_floats(lanes.load_floats(builder, at) * part, after)
        return context.get_dummy_value()

    kinds = (
        types.uint64, types.uint64, types.int64, types.int64, types.float32, types.float32,
        types.float32, types.float32, types.boolean, types.boolean,
    )  # fmt: skip
    return types.void(*kinds), generate


def _square(builder: Any, load: Any, right: Any, below: Any) -> tuple[Lanes, Lanes, Lanes, Lanes]:
    here = ir.Constant(_WORD, 0)
    return load(here), load(right), load(below), load(builder.add(right, below))


def _between(corners: tuple[Lanes, Lanes, Lanes, Lanes], fx: Lanes, fy: Lanes) -> Lanes:
    a, b, c, d = corners
    upper = a + fx * (b - a)
    return upper + fy * (c + fx * (d - c) - upper)
