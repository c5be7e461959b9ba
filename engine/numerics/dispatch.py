"""Choose one of several kernels by an integer, inside a kernel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from numba import njit


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
