"""Arithmetic on four float32 at once, for the innermost lines of a kernel.

Numba makes vectors of plain loops over arrays, not of three channels in the middle of a loop with
branches. So here formulas are written down for LLVM: `Lanes` is a vector that Python's operators
act on while the code of an intrinsic is generated.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir

COUNT = 4
FLOATS = ir.VectorType(ir.FloatType(), COUNT)
INTS = ir.VectorType(ir.IntType(32), COUNT)
OCTETS = ir.VectorType(ir.IntType(8), COUNT)
_ZEROS = ir.Constant(INTS, [ir.Constant(ir.IntType(32), 0)] * COUNT)

# 2^f for f in [-1/2, 1/2], fitted to the relative error at Chebyshev points.
LOG2_E = 1.4426950408889634
POWERS = (1.00000007, 0.69314695, 0.24022122, 0.05550743, 0.00967546, 0.0013267)
MOST = 126.0


class Lanes:
    """A vector of four float32 in a function that is being built."""

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder, self.value = builder, value

    def _of(self, other: Lanes | float) -> Any:
        if isinstance(other, Lanes):
            return other.value
        return ir.Constant(FLOATS, [ir.Constant(ir.FloatType(), other)] * COUNT)

    def __add__(self, other: Lanes | float) -> Lanes:
        return Lanes(
            self.builder, self.builder.fadd(self.value, self._of(other), flags=("contract",))
        )

    def __sub__(self, other: Lanes | float) -> Lanes:
        return Lanes(
            self.builder, self.builder.fsub(self.value, self._of(other), flags=("contract",))
        )

    def __mul__(self, other: Lanes | float) -> Lanes:
        return Lanes(
            self.builder, self.builder.fmul(self.value, self._of(other), flags=("contract",))
        )

    def __truediv__(self, other: Lanes) -> Lanes:
        return Lanes(self.builder, self.builder.fdiv(self.value, other.value))

    def within(self, most: float) -> Lanes:
        """Brought into [-most, most]."""
        value = self.value
        for sign, limit in (("<", most), (">", -most)):
            bound = self._of(limit)
            value = self.builder.select(self.builder.fcmp_ordered(sign, value, bound), value, bound)
        return Lanes(self.builder, value)

    def exp(self) -> Lanes:
        """e^x, off by less than 5e-6 of itself; within float32's range where |x| is larger."""
        y = (self * LOG2_E).within(MOST)
        # y + 127 is positive, so cutting off after adding a half rounds to nearest.
        n = self.builder.fptosi((y + 127.5).value, INTS)
        f = y - (Lanes(self.builder, self.builder.sitofp(n, FLOATS)) - 127.0)
        c0, c1, c2, c3, c4, c5 = POWERS
        ff = f * f
        p = (f * c1 + c0) + ff * ((f * c3 + c2) + ff * (f * c5 + c4))
        shift = ir.Constant(INTS, [ir.Constant(ir.IntType(32), 23)] * COUNT)
        return p * Lanes(self.builder, self.builder.bitcast(self.builder.shl(n, shift), FLOATS))


def spread(builder: Any, value: Any) -> Lanes:
    """One float32 in all lanes."""
    single = builder.insert_element(ir.Constant(FLOATS, ir.Undefined), value, _ZEROS.constant[0])
    return first_everywhere(Lanes(builder, single))


def first_everywhere(lanes: Lanes) -> Lanes:
    """The first lane in all of them."""
    return Lanes(lanes.builder, lanes.builder.shuffle_vector(lanes.value, lanes.value, _ZEROS))


def either(condition: Any, there: Lanes, otherwise: Lanes | float) -> Lanes:
    """One or the other vector, as a single bit says."""
    value = there.builder.select(condition, there.value, there._of(otherwise))
    return Lanes(there.builder, value)


def load_floats(builder: Any, address: Any) -> Lanes:
    """Four float32 at an address, a 64-bit number."""
    return Lanes(builder, builder.load(builder.inttoptr(address, FLOATS.as_pointer()), align=4))


def load_octets(builder: Any, address: Any) -> Lanes:
    """Four octets at an address, as numbers from 0 to 255."""
    octets = builder.load(builder.inttoptr(address, OCTETS.as_pointer()), align=1)
    return Lanes(builder, builder.sitofp(builder.zext(octets, INTS), FLOATS))


def store_floats(lanes: Lanes, address: Any) -> None:
    """Write four float32 to an address."""
    pointer = lanes.builder.inttoptr(address, FLOATS.as_pointer())
    lanes.builder.store(lanes.value, pointer, align=4)
