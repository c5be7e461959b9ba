"""Kernels made of kernels: one of several chosen by an integer, one called for many directions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from numba import njit

from engine.numerics.borrow import borrow


def by_index(functions: Sequence[Callable], arguments: int) -> Any:
    """A kernel f(index, *args) that calls functions[index](*args).

    All functions take `arguments` arguments and return the same type. An index past the end calls
    the last one. It compiles to a chain of comparisons within the caller.
    """
    names = ", ".join(f"a{k}" for k in range(arguments))
    lines = [f"def choose(index, {names}):"]
    for k in range(len(functions) - 1):
        lines += [f"    if index == {k}:", f"        return f{k}({names})"]
    lines.append(f"    return f{len(functions) - 1}({names})")
    scope: dict[str, Any] = {f"f{k}": f for k, f in enumerate(functions)}
    exec("\n".join(lines), scope)  # the text is made of the integers above alone
    return njit(forceinline=True)(scope["choose"])


formula = njit(forceinline=True, error_model="numpy")
"""Decorates what `along` calls, and what that calls: only then is it done for several at a time."""

contracted = njit(forceinline=True, error_model="numpy", fastmath={"contract"})
"""The same where a product and a sum may be one instruction."""


def along(function: Callable) -> Any:
    """A kernel f(p, x, y, z, count, b, out) that fills out[:, q] with function(p, (x, y, z)[q], b).

    One plain loop over many directions, of which a processor does several at a time.
    """
    call: Any = function

    @njit(fastmath={"contract", "reassoc"}, error_model="numpy")
    def loop(p, x, y, z, count, b, out):
        row = borrow(p)
        for q in range(count):
            values = call(row, (x[q], y[q], z[q]), b)
            for c in range(len(values)):
                out[c, q] = values[c]

    return loop
