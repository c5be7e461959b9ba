"""The file format: named arrays and a JSON document, checksummed and laid out for mapping.

    8 bytes    magic
    4 + 4      format version, length of the header (little-endian)
    16 bytes   checksum of the version, the length and the header
    header     JSON: {"meta": ..., "size": bytes of the file,
                      "arrays": {name: {dtype, shape, offset, checksum}}}
    arrays     raw, C order, each at a multiple of ALIGNMENT; what lies between is zero and unused

Checksums are XXH3-128: they find damage, not malice. Nothing in a file is ever executed.
"""

from __future__ import annotations

import json
import math
import mmap
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import xxhash
from numpy.typing import NDArray

from engine.errors import InputError, StoreError

MAGIC = b"RELIGHT\x1a"
VERSION = 1
ALIGNMENT = 64
_FIXED = struct.Struct("<8sII16s")
_KINDS = "biufc"  # bool, integers, floats, complex: everything whose bytes are its value


@dataclass(frozen=True)
class Stored:
    """What a file holds.

    arrays  views of the mapped file, as they were written (C order); what is written into them
            stays in this process and never reaches the file
    meta    the JSON document; tuples came back as lists
    """

    arrays: dict[str, NDArray[Any]]
    meta: dict[str, Any]


def save(file: BinaryIO, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]) -> None:
    """Write arrays and meta to an open, empty file.

    Raises InputError for arrays that are not plain numbers and for meta that is not JSON.
    """
    packed = {name: _plain(name, array) for name, array in arrays.items()}
    # The header holds the offsets and its own length moves them: lay out with room to spare.
    room = 256 * (len(packed) + 1) + sum(len(json.dumps(name)) for name in packed)
    room += len(_dump(meta))
    offset = _aligned(_FIXED.size + room)
    places: dict[str, dict[str, Any]] = {}
    for name, array in packed.items():
        places[name] = {
            "dtype": array.dtype.str,
            "shape": array.shape,
            "offset": offset,
            "checksum": xxhash.xxh3_128_hexdigest(_octets(array)),
        }
        offset = _aligned(offset + array.nbytes)
    header = _dump({"meta": meta, "arrays": places, "size": offset}).encode()
    file.write(_FIXED.pack(MAGIC, VERSION, len(header), _header_checksum(VERSION, header)))
    file.write(header)
    for name, array in packed.items():
        file.seek(places[name]["offset"])
        file.write(_octets(array))
    file.truncate(offset)


def load(path: Path) -> Stored:
    """Map a file and verify it.

    Raises StoreError, with what is wrong, where the file is damaged or of another version, and
    FileNotFoundError where there is none.
    """
    with path.open("rb") as file:
        size = file.seek(0, 2)
        if size < _FIXED.size:
            raise StoreError(f"{size} bytes are too few for a stored file")
        # Private pages: writable arrays, which Numba compiles for already, over a file that stays.
        mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY)
    header = _header(mapped)
    if header["size"] != size:
        raise StoreError(f"{size} bytes long where it should be {header['size']}")
    arrays = {}
    for name, place in header["arrays"].items():
        dtype, shape, offset = np.dtype(place["dtype"]), place["shape"], place["offset"]
        array = np.frombuffer(mapped, dtype, math.prod(shape), offset)
        if xxhash.xxh3_128_hexdigest(_octets(array)) != place["checksum"]:
            raise StoreError(f"the data of {name!r} do not match their checksum")
        arrays[name] = array.reshape(shape)
    return Stored(arrays, header["meta"])


def _header(mapped: mmap.mmap) -> dict[str, Any]:
    magic, version, length, checksum = _FIXED.unpack_from(mapped)
    if magic != MAGIC:
        raise StoreError("not a stored file (wrong first bytes)")
    if version != VERSION:
        raise StoreError(f"format version {version} where this program reads {VERSION}")
    header = mapped[_FIXED.size : _FIXED.size + length]
    if checksum != _header_checksum(version, header):
        raise StoreError("the header does not match its checksum")
    document: dict[str, Any] = json.loads(header)
    return document


def _header_checksum(version: int, header: bytes) -> bytes:
    return xxhash.xxh3_128_digest(struct.pack("<II", version, len(header)) + header)


def _plain(name: str, array: NDArray[Any]) -> NDArray[Any]:
    array = np.asarray(array, order="C")
    if array.dtype.kind not in _KINDS:
        raise InputError(f"cannot store an array of {array.dtype}, only numbers", field=name)
    return array


def _octets(array: NDArray[Any]) -> memoryview:
    octets: Any = array.reshape(-1).view(np.uint8)
    return memoryview(octets)


def _dump(value: Any) -> str:
    try:
        return json.dumps(value, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError) as error:
        raise InputError(f"not JSON: {error}", field="meta") from None


def _aligned(offset: int) -> int:
    return -(-offset // ALIGNMENT) * ALIGNMENT
