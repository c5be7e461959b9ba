"""Small files of every kind that may be sent in, and ways to damage them."""

from __future__ import annotations

import base64
import copy
import io
import json
import re
import struct
import zipfile
from collections.abc import Callable, Mapping
from typing import Any

import imagecodecs
import numpy as np
from PIL import Image

from engine.brdf.acquisition.csv_table import COLUMNS
from engine.images import encode_exr

CORNERS = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.uint16)
LIGHTS = {"lights": [{"type": "spot", "intensity": 100.0, "spot": {"outerConeAngle": 0.5}}]}
QUAD = """\
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
"""
OBJ = f"""\
mtllib quad.mtl
{QUAD}vn 0 0 1
usemtl shiny
f 1/1/1 2/2/1 3/3/1
f 1/1/1 3/3/1 4/4/1
"""
MTL = "newmtl shiny\nKd 0.5 0.4 0.3\nKs 0.1 0.1 0.1\nNs 20\nmap_Kd seen.png\n"
PLY_HEADER = """\
ply
format {kind} 1.0
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
end_header
"""
BRDF = "# paint\n# num wls\n3\n450 550\n650\n" + "".join(
    f"{i:.3f} 0 {o:.3f} {p:.3f} 0.1 0.1 0.1\n"
    for i in (0.2, 1.2)
    for o in (0.2, 1.2)
    for p in (0, 3)
)


def picture() -> bytes:
    """A PNG of 2 x 2 pixels."""
    file = io.BytesIO()
    Image.fromarray(np.arange(12, dtype=np.uint8).reshape(2, 2, 3) * 20).save(file, "PNG")
    return file.getvalue()


def gltf(**changes: Any) -> tuple[dict[str, Any], bytes]:
    """The header and the buffer of a quad with a texture under a lamp; `changes` are of entries."""
    image = picture()
    chunks = [CORNERS.tobytes(), FACES.tobytes(), (CORNERS[:, :2] / 2 + 0.5).tobytes(), image]
    offsets = np.cumsum([0] + [len(chunk) + -len(chunk) % 4 for chunk in chunks])
    binary = b"".join(chunk + bytes(-len(chunk) % 4) for chunk in chunks)
    header: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 2]}],
        "nodes": [
            {"children": [1], "translation": [0, 0, 1]},
            {"mesh": 0, "rotation": [0, 0, 0, 1]},
            {"translation": [0, 0, 5], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}
        ]}],
        "materials": [{"name": "m", "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0}, "metallicFactor": 0.2, "roughnessFactor": 0.5,
        }}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": int(offset), "byteLength": len(chunk)}
            for offset, chunk in zip(offsets, chunks, strict=False)
        ],
        "buffers": [{"byteLength": len(binary)}],
        "extensions": {"KHR_lights_punctual": copy.deepcopy(LIGHTS)},
        "extensionsUsed": ["KHR_lights_punctual"],
    }  # fmt: skip
    for place, value in changes.items():
        table, *keys = place.split("__")
        entry = header[table]
        for key in keys[:-1]:
            entry = entry[int(key) if key.isdigit() else key]
        entry[int(keys[-1]) if keys[-1].isdigit() else keys[-1]] = value
    return header, binary


def glb(header: Mapping[str, Any], binary: bytes) -> bytes:
    """A GLB file of a header and a buffer."""
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def in_one(header: Mapping[str, Any], binary: bytes) -> bytes:
    """A glTF file with its buffer in itself."""
    uri = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    return json.dumps({**header, "buffers": [{"byteLength": len(binary), "uri": uri}]}).encode()


def ply(kind: str = "binary_little_endian", **header: str) -> bytes:
    """A PLY file; `header` are replacements in its header."""
    text = PLY_HEADER.format(kind=kind)
    for old, new in header.items():
        text = text.replace(old.replace("_", " "), new)
    if kind == "ascii":
        rows = [*(" ".join(map(str, row)) for row in CORNERS), "3 0 1 2", "3 0 2 3"]
        return (text + "\n".join(rows) + "\n").encode()
    faces = b"".join(struct.pack("<B3i", 3, *row) for row in FACES.tolist())
    return text.encode() + CORNERS.tobytes() + faces


def stl(count: int = 2) -> bytes:
    """A binary STL file of two triangles that says to have so many."""
    rows = b"".join(
        struct.pack("<12fH", 0, 0, 1, *CORNERS[row].ravel(), 0) for row in FACES.tolist()
    )
    return bytes(80) + struct.pack("<I", count) + rows


def stl_text() -> bytes:
    """The same as a text."""
    facets = [
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CORNERS[row])
        + "endloop\nendfacet\n"
        for row in FACES.tolist()
    ]
    return ("solid quad\n" + "".join(facets) + "endsolid quad\n").encode()


def description(**changes: Any) -> bytes:
    """A scene.json that names a mesh, a texture, a map and a projector's image beside it."""
    return json.dumps({
        "camera": {"position": [0, 0, 4], "target": [0, 0, 0], "width": 16, "height": 12},
        "environment": {"map": "maps/sky.exr"},
        "lights": [{"id": "beam", "type": "projector", "position": [0, 0, 4], "target": [0, 0, 0],
                    "intensity": [9, 9, 9], "image": "seen.png"}],
        "materials": {"paint": {"type": "diffuse", "diffuse": {"texture": "seen.png"}}},
        "objects": [{"name": "quad", "mesh": "quad.ply", "material": "paint"}],
        **changes,
    }).encode()  # fmt: skip


def files(**changes: Any) -> dict[str, bytes]:
    """What belongs to `description`."""
    return {
        "scene.json": description(**changes),
        "quad.ply": ply(),
        "seen.png": picture(),
        "maps/sky.exr": exr(),
    }


def zipped(entries: Mapping[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """A zip of files by their names."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as packed:
        for name, data in entries.items():
            packed.writestr(name, data)
    return file.getvalue()


def exr() -> bytes:
    """An even map."""
    return encode_exr(np.full((4, 8, 3), 0.5, np.float32))


def hdr() -> bytes:
    """The same in the other format."""
    return bytes(imagecodecs.rgbe_encode(np.full((4, 8, 3), 0.5, np.float32)))


def csv() -> bytes:
    """A material that was measured in few places."""
    rows = [f"{i},0,{o},{p},0.2,0.1,0.1" for i in (10, 70) for o in (10, 70) for p in (0, 90, 180)]
    return "\n".join([",".join(COLUMNS), *rows]).encode()


SEEDS: dict[str, Callable[[], bytes]] = {
    "quad.glb": lambda: glb(*gltf()),
    "quad.gltf": lambda: in_one(*gltf()),
    "quad.obj": lambda: OBJ.encode(),
    "quad.ply": ply,
    "text.ply": lambda: ply("ascii"),
    "quad.stl": stl,
    "text.stl": stl_text,
    "scene.zip": lambda: zipped(files()),
    "mesh.zip": lambda: zipped(
        {"a/quad.obj": OBJ.encode(), "a/quad.mtl": MTL.encode(), "a/seen.png": picture()}
    ),
    "sky.exr": exr,
    "sky.hdr": hdr,
    "paint.csv": csv,
    "paint.brdf": lambda: BRDF.encode(),
    "paint.binary": lambda: struct.pack("<3i", 90, 90, 180) + bytes(240),
}

_NUMBER = re.compile(rb"(?<![\w.])-?\d+(\.\d+)?(?![\w.])")
_TEXTS = [b"nan", b"1e999", b"-1", b"0", b"99999999999", b"4294967295", b"1e38", b"", b"null",
          b'"x"', b"[]", b"{}", b"\xff\xfe", b"../../secret", b"1" * 5000, b"[" * 5000]  # fmt: skip
_VALUES: list[Any] = [None, True, -1, 0, 1, 2, 5, 1e-300, 1e30, 1e300, float("nan"), float("inf"),
                      2**31, 10**30, 10**400, "", "x", "../secret.ply", "/etc/passwd", "http://x/y",
                      "data:,", "\0", "x" * 300, [], [0], [[]], {}, {"x": 1}, [1e30, 0, 0],
                      [0, 0, 0], [0, 0, 0, 0], [1e-30] * 16]  # fmt: skip
_WORDS = [0, 0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 0x7FC00000, 0x7F800000, 0x10000, 0xFF]


def mutated(name: str, data: bytes, rng: np.random.Generator) -> bytes:
    """The file with some damage of one kind or another."""
    if name.endswith(".zip") and rng.random() < 0.8:
        with zipfile.ZipFile(io.BytesIO(data)) as packed:
            entries = {entry: packed.read(entry) for entry in packed.namelist()}
        chosen = sorted(entries)[rng.integers(len(entries))]
        entries[chosen] = _damaged(entries[chosen], rng)
        return zipped(entries)
    if name.endswith(".glb") and rng.random() < 0.8:
        header, binary = gltf()
        if rng.random() < 0.3:
            return glb(header, _damaged(binary, rng))
        change_tree(header, rng)
        return glb(header, binary)
    return _damaged(data, rng)


def _damaged(data: bytes, rng: np.random.Generator) -> bytes:
    if data.startswith(b"{") and rng.random() < 0.8:
        document = json.loads(data)
        change_tree(document, rng)
        return json.dumps(document).encode()
    ways = [_flipped, _flipped, _cut, _spliced, _overwritten, _changed_number, _changed_number]
    for _ in range(rng.integers(1, 3)):
        if data:
            data = ways[rng.integers(len(ways))](data, rng)
    return data


def change_tree(document: Any, rng: np.random.Generator) -> None:
    """Somewhere in a JSON document another value, one entry less, or the same one twice."""
    places: list[tuple[Any, Any]] = []
    todo = [document]
    while todo:
        one = todo.pop()
        inner = list(one.items()) if isinstance(one, dict) else list(enumerate(one))
        places += [(one, key) for key, _ in inner]
        todo += [value for _, value in inner if isinstance(value, dict | list)]
    holder, key = places[rng.integers(len(places))]
    if rng.random() < 0.1:
        del holder[key]
    elif rng.random() < 0.1 and isinstance(holder, list):
        holder.append(copy.deepcopy(holder[key]))
    else:
        holder[key] = copy.deepcopy(_VALUES[rng.integers(len(_VALUES))])


def _flipped(data: bytes, rng: np.random.Generator) -> bytes:
    made = bytearray(data)
    for place in rng.integers(len(made), size=rng.integers(1, 5)):
        made[place] ^= 1 << int(rng.integers(8))
    return bytes(made)


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: rng.integers(len(data))]


def _spliced(data: bytes, rng: np.random.Generator) -> bytes:
    """A piece of it, or of the beginning, once more somewhere."""
    start = int(rng.integers(len(data))) if rng.random() < 0.5 else 0
    piece = data[start : start + int(rng.integers(1, 200))]
    place = int(rng.integers(len(data)))
    return data[:place] + piece + data[place + (len(piece) if rng.random() < 0.5 else 0) :]


def _overwritten(data: bytes, rng: np.random.Generator) -> bytes:
    """Four bytes that stand for a count, a size or a NaN where it hurts."""
    place = int(rng.integers(len(data)))
    return data[:place] + struct.pack("<I", _WORDS[rng.integers(len(_WORDS))]) + data[place + 4 :]


def _changed_number(data: bytes, rng: np.random.Generator) -> bytes:
    """A number of a text becomes another, or something else."""
    found = list(_NUMBER.finditer(data))
    if not found:
        return _flipped(data, rng)
    one = found[rng.integers(len(found))]
    return data[: one.start()] + _TEXTS[rng.integers(len(_TEXTS))] + data[one.end() :]
