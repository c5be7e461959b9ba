"""Shapes: closed, facing outwards, of the right size, with true normals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from engine.scene import shapes
from engine.scene.part import Part

ANY: TypeAdapter[Any] = TypeAdapter(shapes.AnyShape)


def make(**shape: Any) -> Part:
    return shapes.make(ANY.validate_python(shape))


def corners(part: Part) -> np.ndarray:
    return part.positions[part.triangles]


def face_normals(part: Part) -> np.ndarray:
    c = corners(part)
    return np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0])


def volume(part: Part) -> float:
    c = corners(part)
    return float(np.sum(c[:, 0] * np.cross(c[:, 1], c[:, 2])) / 6)


SHAPES: list[dict[str, Any]] = [
    {"shape": "rectangle", "size": [2, 3]},
    {"shape": "box", "size": [1, 2, 3]},
    {"shape": "sphere", "radius": 2, "rings": 32},
    {"shape": "disk", "radius": 2},
    {"shape": "cylinder", "radius": 1, "height": 3},
    {"shape": "cylinder", "radius": 1, "top_radius": 0.4, "height": 3},
    {"shape": "torus_knot", "turns": [2, 3]},
    {"shape": "revolution", "profile": [[0, 0], [2, 0], [0.5, 2], [1, 3]], "segments": 32},
    {"shape": "tube", "points": [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 2, 1]]},
    {"shape": "teapot", "segments": 32},
    {"shape": "polygons", "polygons": [[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.5, 2, 0], [0, 1, 0]]]},
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s["shape"])
def test_normals_are_unit_and_agree_with_the_winding(shape: dict[str, Any]) -> None:
    part = make(**shape)
    assert part.normals is not None
    assert part.uvs is not None
    assert np.allclose(np.linalg.norm(part.normals, axis=1), 1)
    flat = face_normals(part)
    area = np.linalg.norm(flat, axis=1)
    assert area.min() > 1e-9
    for k in range(3):
        cosine = np.sum(flat * part.normals[part.triangles[:, k]], axis=1) / area
        assert cosine.min() > 0.9
    assert part.uvs.min() >= -1e-12
    assert part.uvs.max() <= 1 + 1e-12


@pytest.mark.parametrize(
    ("shape", "expected", "tolerance"),
    [
        (SHAPES[1], 6.0, 1e-12),
        (SHAPES[2], 4 / 3 * math.pi * 8, 0.01),
        (SHAPES[4], math.pi * 3, 0.01),
        (SHAPES[5], math.pi * (1 + 0.4 + 0.16), 0.01),
        # A torus, by Pappus; a knot with as long a curve would have as much.
        ({"shape": "torus_knot", "turns": [1, 0]}, math.pi * 0.01 * math.tau * 0.7, 0.01),
    ],
)
def test_closed_shapes_hold_their_volume(
    shape: dict[str, Any], expected: float, tolerance: float
) -> None:
    # The divergence theorem gives the volume only if the surface is closed and faces outwards;
    # moving the shape must then change nothing.
    part = make(**shape)
    moved = Part(part.positions + np.array([10.0, -20.0, 30.0]), part.triangles)
    assert volume(part) == pytest.approx(expected, rel=tolerance)
    assert volume(moved) == pytest.approx(volume(part), rel=1e-9)


def test_flat_shapes_have_their_area_and_face_z() -> None:
    for shape, area in ((SHAPES[0], 6.0), (SHAPES[3], math.pi * 4), (SHAPES[-1], 1.5)):
        flat = face_normals(make(**shape)).sum(axis=0) / 2
        assert flat[2] == pytest.approx(area, rel=0.01)
        assert np.allclose(flat[:2], 0)


def test_texture_coordinates_are_not_mirrored() -> None:
    # Where u, v grow counter-clockwise with the triangle, an image reads the right way round.
    for shape in SHAPES[:-1]:
        part = make(**shape)
        assert part.uvs is not None
        uv = part.uvs[part.triangles]
        a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
        assert np.min(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) > -1e-12
