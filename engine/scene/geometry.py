"""Put parts into the world and lay them out flat."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.diagnosis import Diagnosis
from engine.errors import SceneError
from engine.scene.normals import with_normals
from engine.scene.part import Part
from engine.scene.scene import Geometry
from engine.scene.tangents import vertex_tangents

MAX_TRIANGLES = 1 << 26
MAX_UV = 1e6  # beyond it float32 has nothing left for the texel
MAX_COORDINATE = 1e9  # metres; beyond it float32 has nothing left for the shape


class Placed(NamedTuple):
    """A part, its (4, 4) matrix to the world, the indices of its material and of its object."""

    part: Part
    matrix: NDArray[np.float64]
    material: int
    object: int


def assemble(
    placed: Sequence[Placed], names: Sequence[str]
) -> tuple[Geometry, tuple[Diagnosis, ...]]:
    """All parts in one set of flat arrays, and what had to be mended on the way.

    names are the objects'. Raises SceneError for an object that has no triangle left.
    """
    total = sum(len(place.part.triangles) for place in placed)
    if total > MAX_TRIANGLES:
        raise SceneError(f"the scene has {total:,} triangles; {MAX_TRIANGLES:,} are the most")
    made: set[str] = set()
    dropped: dict[str, int] = {}
    ready: dict[int, Part] = {}
    parts = []
    for part, matrix, _, index in placed:
        if id(part) not in ready:
            ready[id(part)] = _with_usable_normals(part)
        if ready[id(part)].normals is not part.normals:
            made.add(names[index])
        if np.linalg.det(matrix[:3, :3]) == 0:
            raise SceneError(
                f"the matrix of object {names[index]!r} has no inverse: it flattens the object",
                field="objects",
            )
        world = _in_world(ready[id(part)], matrix)
        if not np.abs(world.positions).max(initial=0) <= MAX_COORDINATE:
            raise SceneError(
                f"object {names[index]!r} reaches beyond {MAX_COORDINATE:g} metres", field="objects"
            )
        kept = _has_area(world)
        if not kept.all():
            dropped[names[index]] = dropped.get(names[index], 0) + int((~kept).sum())
            world = Part(
                world.positions, world.triangles[kept], world.normals, world.uvs, world.material
            )
        parts.append(world)
    left = [0] * len(names)
    for world, place in zip(parts, placed, strict=True):
        left[place.object] += len(world.triangles)
    if 0 in left:
        empty = left.index(0)
        what = "every triangle has zero area" if names[empty] in dropped else "it has no triangles"
        raise SceneError(f"object {names[empty]!r} is empty: {what}", field=f"objects.{empty}.mesh")
    return _flat(parts, placed), _mended(made, dropped, len(names))


def _with_usable_normals(part: Part) -> Part:
    """The part with unit normals: its own where all of them are good, else made ones."""
    if part.normals is not None and len(part.normals) == len(part.positions):
        length = np.linalg.norm(part.normals, axis=1)
        used = np.zeros(len(length), bool)
        used[part.triangles] = True
        if np.all(np.isfinite(length) & (length > 1e-6), where=used):
            return part
    return with_normals(part) if len(part.triangles) else part


def _in_world(part: Part, matrix: NDArray[np.float64]) -> Part:
    """The part in the world. A mirroring matrix turns the triangles round to keep them outward."""
    linear = matrix[:3, :3]
    positions = (part.positions @ linear.T + matrix[:3, 3]).astype(np.float32).astype(np.float64)
    triangles = part.triangles[:, ::-1] if np.linalg.det(linear) < 0 else part.triangles
    # Normals go by the inverse transpose, so that they stay normal under uneven scales.
    normals = np.zeros_like(positions) if part.normals is None else part.normals
    normals = np.nan_to_num(normals) @ np.linalg.inv(linear)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 0, normals / np.where(length > 0, length, 1), [0.0, 1.0, 0.0])
    uvs = np.zeros((len(positions), 2)) if part.uvs is None else part.uvs
    uvs = np.where(np.abs(uvs) <= MAX_UV, uvs, 0)  # NaN as well
    return Part(positions, triangles, normals, uvs, part.material)


def _has_area(part: Part) -> NDArray[np.bool_]:
    """Which triangles (t,) are more than a point or a line."""
    a, b, c = (part.positions[part.triangles[:, k]] for k in range(3))
    twice_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    edges = np.stack([b - a, c - b, a - c])
    longest = np.sum(edges * edges, axis=2).max(axis=0, initial=0)
    return np.asarray(twice_area > 1e-9 * longest)


def _flat(parts: Sequence[Part], placed: Sequence[Placed]) -> Geometry:
    starts = np.cumsum([0] + [len(part.positions) for part in parts])
    counts = [len(part.triangles) for part in parts]

    def flat(arrays: list[NDArray], dtype: type) -> NDArray:
        return np.ascontiguousarray(np.concatenate(arrays), dtype)

    positions = flat([part.positions for part in parts], np.float32)
    triangles = flat(
        [p.triangles + start for p, start in zip(parts, starts[:-1], strict=True)], np.int32
    )
    normals = flat([part.normals for part in parts if part.normals is not None], np.float32)
    uvs = flat([part.uvs for part in parts if part.uvs is not None], np.float32)
    return Geometry(
        positions,
        triangles,
        normals,
        uvs,
        vertex_tangents(positions, triangles, normals, uvs),
        np.repeat([place.material for place in placed], counts).astype(np.int32),
        np.repeat([place.object for place in placed], counts).astype(np.int32),
    )


def _mended(made: set[str], dropped: dict[str, int], objects: int) -> tuple[Diagnosis, ...]:
    found = []
    if made:
        found.append(
            Diagnosis(
                "normals_made",
                f"{_some(sorted(made))}: no usable shading normals in the file; smooth ones were "
                "made, with creases where faces meet at more than 40 degrees",
                len(made) / objects,
            )
        )
    if dropped:
        count = sum(dropped.values())
        found.append(
            Diagnosis(
                "degenerate_triangles",
                f"{count} triangle{'s' * (count > 1)} of {_some(sorted(dropped))} had no area and "
                f"{'were' if count > 1 else 'was'} left out",
                float(count),
            )
        )
    return tuple(found)


def _some(names: Sequence[str]) -> str:
    """At most three names and how many more there are."""
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return f"{', '.join(names[:3])}{more}"
