"""Whether the tables of a glTF file fit together: what one names another has, no node holds itself.

Readers believe what a file says of itself, so lies are found before they are followed: numbers of a
table that is shorter, bytes past the end of a buffer, nodes in a circle, files that lie elsewhere.
See glTF 2.0 §3.5.2 (nodes), §3.6 (buffers, views, accessors).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from engine.errors import SceneError
from engine.scene.companions import Companions

COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
MOST_ZEROS = 1 << 28  # bytes of an accessor that has none in the file
SHOWN = 80  # characters of a name


def check_tables(header: dict[str, Any], binary: int | None, beside: Companions, file: str) -> None:
    """Raises SceneError, naming the entry, where a glTF header contradicts itself or its bytes.

    binary  bytes of a GLB file's own buffer, None where it has none
    """
    try:
        for table in ("buffers", "bufferViews", "accessors", "images", "meshes", "nodes", "scenes"):
            if not all(isinstance(entry, dict) for entry in header.get(table, [])):
                raise SceneError("is not a list of objects", field=table)
        sizes = list(_buffers(header, binary, beside))
        for k, view in enumerate(header.get("bufferViews", [])):
            _check_view(view, sizes, f"bufferViews.{k}")
        for k, accessor in enumerate(header.get("accessors", [])):
            _check_accessor(accessor, header, f"accessors.{k}")
        for k, image in enumerate(header.get("images", [])):
            if "uri" in image:
                _check_place(image["uri"], f"images.{k}.uri")
        _check_nodes(header)
    except SceneError as error:
        raise SceneError(error.message, field=error.field, file=file) from None
    except (KeyError, TypeError, AttributeError) as error:
        reason = f"{type(error).__name__}: {error}"
        raise SceneError(f"cannot be read as glTF: its tables are broken ({reason})", file=file) \
            from None  # fmt: skip


def _buffers(header: dict[str, Any], binary: int | None, beside: Companions) -> Iterator[int]:
    """The bytes that each buffer says to have; it has them."""
    for k, buffer in enumerate(header.get("buffers", [])):
        field = f"buffers.{k}"
        said = _number(buffer.get("byteLength"), f"{field}.byteLength")
        if "uri" in buffer:
            there = _bytes_at(buffer["uri"], beside, f"{field}.uri")
        elif k == 0 and binary is not None:
            there = binary
        else:
            raise SceneError("has neither a uri nor bytes in the file", field=field)
        if said > there:
            raise SceneError(
                f"says to have {said:,} bytes, but there are {there:,}", field=f"{field}.byteLength"
            )
        yield said


def _bytes_at(uri: Any, beside: Companions, field: str) -> int:
    """How many bytes a uri leads to: its own, or those of a file beside."""
    _check_place(uri, field)
    if uri.startswith("data:"):
        # Four letters of base64 are three bytes.
        return (len(uri) - uri.find(",") - 1) * 3 // 4
    path = beside.find(uri)
    if path is None:
        raise SceneError(
            f"names {uri[:SHOWN]}, which is not beside the file: put it there, or save as GLB",
            field=field,
        )
    return path.stat().st_size


def _check_place(uri: Any, field: str) -> None:
    if not isinstance(uri, str):
        raise SceneError("is no text", field=field)
    if "://" in uri[:16] or uri.startswith(("//", "file:", "http:", "https:")):
        raise SceneError(
            f"names {uri[:SHOWN]}: nothing is fetched from elsewhere, put it into the file",
            field=field,
        )


def _check_view(view: dict[str, Any], sizes: list[int], field: str) -> None:
    buffer = _index(view["buffer"], len(sizes), "buffer", f"{field}.buffer")
    start = _number(view.get("byteOffset", 0), f"{field}.byteOffset")
    end = start + _number(view["byteLength"], f"{field}.byteLength")
    if end > sizes[buffer]:
        raise SceneError(
            f"ends at byte {end:,} of buffer {buffer}, which has {sizes[buffer]:,}", field=field
        )


def _check_accessor(accessor: dict[str, Any], header: dict[str, Any], field: str) -> None:
    count = _number(accessor["count"], f"{field}.count")
    component, kind = accessor["componentType"], accessor["type"]
    if component not in COMPONENT_BYTES or kind not in COMPONENTS:
        raise SceneError(f"has no such type: {component}, {kind}"[:SHOWN], field=field)
    size = COMPONENT_BYTES[component] * COMPONENTS[kind]
    if "bufferView" not in accessor:
        if count * size > MOST_ZEROS:
            raise SceneError(f"counts {count:,} and has no bytes", field=f"{field}.count")
        return
    views = header.get("bufferViews", [])
    number = _index(accessor["bufferView"], len(views), "view", f"{field}.bufferView")
    stride = _number(views[number].get("byteStride", size), f"bufferViews.{number}.byteStride")
    start = _number(accessor.get("byteOffset", 0), f"{field}.byteOffset")
    end = start + (count - 1) * stride + size if count else start
    length = views[number]["byteLength"]
    if end > length:
        raise SceneError(
            f"counts {count:,}, which end at byte {end:,} of view {number}, which has {length:,}",
            field=field,
        )


def _check_nodes(header: dict[str, Any]) -> None:
    """Names of nodes and meshes are there, and no node is below itself."""
    nodes, meshes = header.get("nodes", []), len(header.get("meshes", []))
    scenes = header.get("scenes", [])
    if scenes:
        _index(header.get("scene", 0), len(scenes), "scene", "scene")
    for k, scene in enumerate(scenes):
        for root in scene.get("nodes", []):
            _index(root, len(nodes), "node", f"scenes.{k}.nodes")
    parents = [0] * len(nodes)
    for k, node in enumerate(nodes):
        if "mesh" in node:
            _index(node["mesh"], meshes, "mesh", f"nodes.{k}.mesh")
        for child in node.get("children", []):
            parents[_index(child, len(nodes), "node", f"nodes.{k}.children")] += 1
    # Take away what has no parent left, again and again: a circle stays.
    free = [k for k, count in enumerate(parents) if count == 0]
    for k in free:
        for child in nodes[k].get("children", []):
            parents[child] -= 1
            if parents[child] == 0:
                free.append(child)
    if len(free) < len(nodes):
        circle = next(k for k, count in enumerate(parents) if count)
        raise SceneError("is below itself: nodes go in a circle", field=f"nodes.{circle}")


def _index(value: Any, count: int, what: str, field: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < count:
        raise SceneError(f"names {what} {value!r:.20}, but there are {count}", field=field)
    return value


def _number(value: Any, field: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise SceneError(f"is {value!r:.20}, not a number of bytes or items", field=field)
    return value
