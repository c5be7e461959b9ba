"""Where kernels find what a BRDF knows that does not fit into its row.

A row is a few numbers; a measured material has a few hundred thousand. So its row holds a *key*, a
digest of its bytes, and kernels ask for the bytes that are filed under the key. Rows therefore stay
plain numbers that may be stored, copied and compared, and mean the same in every process that has
loaded the material; a key that nothing is filed under gets none.

Kernels cannot be handed a table that grows while they run, so they get at it by a function of a
fixed name that the linker knows, which returns the address of an open-addressed hash table. Behind
it stand functions that are compiled once for all kernels, see `engine.numerics.far_call`.
Entries stay for as long as the process does: what somebody renders with must not go away.
"""

from __future__ import annotations

import hashlib
import threading

import llvmlite.binding as llvm
import numpy as np
from numba import cfunc, njit, types
from numpy.typing import NDArray

from engine.errors import InputError
from engine.numerics.memory import uint64_at

SLOTS = 8192
MOST = SLOTS // 2
DIGITS = 24  # of a key in one place of a row: what float32 holds exactly
_SYMBOL = "relight_brdf_library"

# Per slot: the key, or 0 where it is free; the address of its bytes. Then the addresses of the
# functions that know what to do with them.
_table = np.zeros((SLOTS + 2, 2), np.uint64)
_kept: dict[int, NDArray[np.uint8]] = {}
_lock = threading.Lock()
_ADDRESS = _table.ctypes.data


@cfunc("uint64()")
def _address():
    return _ADDRESS


llvm.add_symbol(_SYMBOL, _address.address)
_library = types.ExternalFunction(_SYMBOL, types.uint64())


def key_of(data: NDArray[np.uint8]) -> tuple[float, float]:
    """The key of some bytes, as it stands in two places of a row."""
    octets = hashlib.blake2b(data.data, digest_size=2 * DIGITS // 8).digest()
    digest = int.from_bytes(octets) or 1
    return float(digest >> DIGITS), float(digest & ((1 << DIGITS) - 1))


def file(data: NDArray[np.uint8]) -> tuple[float, float]:
    """File bytes (n,), which must not change from now on, and return their key.

    Filing the same bytes twice keeps the first. Raises InputError when the library is full.
    """
    high, low = key_of(data)
    key = _join(high, low)
    with _lock:
        if key in _kept:
            return high, low
        if len(_kept) >= MOST:
            raise InputError(f"more than {MOST} measured materials in one process")
        owned = np.ascontiguousarray(data)
        slot = key % SLOTS
        while _table[slot, 0]:
            slot = (slot + 1) % SLOTS
        _kept[key] = owned
        _table[slot, 1] = owned.ctypes.data
        _table[slot, 0] = key
    return high, low


def filed(high: float, low: float) -> NDArray[np.uint8] | None:
    """The bytes under a key, None where there are none."""
    return _kept.get(_join(high, low))


def packed() -> NDArray[np.uint32]:
    """(n,) all of it in words, for `shaders/brdf/measured.glsl`.

    How many blocks there are, of each its key as two float32 and the word where it begins, then
    the blocks.
    """
    with _lock:
        entries = sorted(_kept.items())
    index = np.zeros(1 + 3 * len(entries), np.uint32)
    index[0] = len(entries)
    words, size = [index], len(index)
    for k, (key, data) in enumerate(entries):
        place = index[1 + 3 * k : 4 + 3 * k]
        place[:2].view(np.float32)[:] = key >> DIGITS, key & ((1 << DIGITS) - 1)
        place[2] = size
        words.append(data.view(np.uint32))
        size += len(words[-1])
    return np.concatenate(words)


def count() -> int:
    """Blocks that are filed."""
    return len(_kept)


def _join(high: float, low: float) -> int:
    return int(high) << DIGITS | int(low)


def install(*functions: int) -> None:
    """Say where functions lie that kernels ask for by number: up to four."""
    _table.reshape(-1)[2 * SLOTS :][: len(functions)] = functions


@njit
def function(number):
    """The address of an installed function; 0 where there is none."""
    return uint64_at(_library(), 2 * SLOTS + number)


@njit
def find(high, low):
    """The address of the bytes under a key; 0 where there are none."""
    key = np.uint64(high) << np.uint64(DIGITS) | np.uint64(low)
    table = _library()
    slot = key % np.uint64(SLOTS)
    for _ in range(SLOTS):
        found = uint64_at(table, 2 * np.int64(slot))
        if found == key:
            return uint64_at(table, 2 * np.int64(slot) + 1)
        if found == np.uint64(0):
            return np.uint64(0)
        slot = (slot + np.uint64(1)) % np.uint64(SLOTS)
    return np.uint64(0)
