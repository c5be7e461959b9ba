"""Lend arrays to the inner functions of a kernel without counting references.

Numba counts a reference, atomically, for every array of a tuple that is handed to a function which
it does not inline. A kernel that passes a scene with its dozens of arrays down to helpers for every
ray then spends most of its time counting, and two threads fight for the counters. `borrow` gives
the same tuple without owners. The caller of the kernel keeps the arrays alive meanwhile.
"""

from __future__ import annotations

from typing import Any

from numba.core import cgutils
from numba.core.types.containers import BaseTuple
from numba.core.types.npytypes import Array
from numba.extending import intrinsic
from numba.np.arrayobj import make_array


@intrinsic
def borrow(typing_context: Any, value: Any) -> Any:
    """The same array, or (named) tuple of arrays and numbers at any depth, without owners."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _disown(context, builder, signature.args[0], arguments[0])

    return value(value), generate


def _disown(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    if isinstance(kind, Array):
        array = make_array(kind)(context, builder, value)
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()
    if isinstance(kind, BaseTuple):
        for k, inner in enumerate(kind.types):
            part = builder.extract_value(value, k)
            value = builder.insert_value(value, _disown(context, builder, inner, part), k)
    return value
