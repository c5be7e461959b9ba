"""Cube maps of what is open, by the rasteriser and by rays."""

from __future__ import annotations

import numpy as np
import pytest
from backend.gl.one_call import call
from methods.scenes import cornell

from engine.backend.gl.context import Device
from engine.backend.gl.visibility import EYES, CubeVisibility
from engine.methods.glossy_prt.occluders import occluders
from engine.methods.glossy_prt.vertices import build_vertices
from engine.methods.glossy_prt.visibility import open_parts
from engine.numerics import cube_map
from engine.scene.open import open_scene
from engine.scene.scene import Scene

pytestmark = pytest.mark.gl
SEES = 40  # a vertex of the box that has something open before it


def both(gpu: Device, of: Scene, count: int, light: int, fine: int) -> list[np.ndarray]:
    """Counts by the rasteriser and by a ray for every part, at vertices here and there."""
    vertices, geometry = build_vertices(of), of.geometry
    drawn = np.random.default_rng(1).integers(0, len(vertices.eye), count - 1)
    some = np.append(SEES, drawn)
    eye, normal = vertices.eye[some], vertices.normal[some]
    visibility = CubeVisibility(gpu, geometry.positions, geometry.triangles, 1e-3 * of.rays.epsilon)
    found = visibility.open_parts(eye, normal, light=light, fine=fine)
    return [found, open_parts(occluders(of), eye, normal, light=light, fine=fine, coarse=fine)]


@pytest.mark.parametrize(("light", "fine"), [(8, 8), (16, 32), (64, 64)])
@pytest.mark.parametrize("count", [1, EYES, EYES + 1])
def test_the_cornell_box(gpu: Device, count: int, light: int, fine: int) -> None:
    found, expected = both(gpu, cornell(), count, light, fine)
    assert found.dtype == np.uint8
    assert found.max() == (fine // light) ** 2
    assert (found != expected).mean() < 1e-4


def test_the_knot(gpu: Device) -> None:
    """Silhouettes of small triangles all around."""
    found, expected = both(gpu, open_scene("knot"), 3, 64, 128)
    assert 0.1 < (expected > 0).mean() < 0.6
    assert (found != expected).mean() < 1e-4


def test_the_same_again_in_any_size(gpu: Device) -> None:
    of = cornell()
    vertices, geometry = build_vertices(of), of.geometry
    visibility = CubeVisibility(gpu, geometry.positions, geometry.triangles, 1e-9)
    some = vertices.eye[:5], vertices.normal[:5]
    first = visibility.open_parts(*some, light=16, fine=32)
    assert visibility.open_parts(*some, light=8, fine=8).shape == (5, 6 * 8 * 8)
    np.testing.assert_array_equal(visibility.open_parts(*some, light=16, fine=32), first)


def test_places_on_faces(gpu: Device) -> None:
    """The directions of all texels, in their order, and back."""
    n = 16
    found = call(
        gpu, "common/cube_map.glsl", "d.x, d.y, d.z, p.x / p.z, p.y / p.z", 5,
        before=f"int face = i / {n * n};"
        f"vec2 x = (2.0 * from_morton(i % {n * n}) + 1.0) / {n}.0 - 1.0;"
        "vec3 d = normalize(on_face(face, x)), p = to_face(face, d); d += 0.0 * w;",
        w=np.zeros((6 * n * n, 3), np.float32),
    )  # fmt: skip
    np.testing.assert_allclose(found[:, :3], cube_map.directions(n), atol=1e-6)
    x, y = cube_map.coordinates(n)
    np.testing.assert_allclose(found[:, 3], np.tile((2 * x + 1) / n - 1, 6), atol=1e-6)
    np.testing.assert_allclose(found[:, 4], np.tile((2 * y + 1) / n - 1, 6), atol=1e-6)
