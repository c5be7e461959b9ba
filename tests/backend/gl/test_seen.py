"""What the GPU sees through a camera is what rays meet."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from backend.gl.one_call import call
from methods.scenes import camera, cornell, rectangle, scene

from engine.backend.gl.context import Device
from engine.backend.gl.raster import TriangleIds
from engine.backend.gl.seen import Sight
from engine.methods.free_view import NEAR, STEP, look
from engine.methods.free_view import Seen as Expected
from engine.scene.camera import Camera
from engine.scene.open import open_scene
from engine.scene.scene import Scene

pytestmark = pytest.mark.gl
MET = np.dtype(
    [("triangle", np.int32), ("b1", np.float32), ("b2", np.float32), ("distance", np.float32)]
)


def sight(gpu: Device, of: Scene, near: float = NEAR) -> Sight:
    return Sight(gpu, of.geometry, near * of.diagonal, STEP)


def seen_from(of: Scene, **fields: Any) -> Camera:
    return Camera.model_validate({**of.camera.model_dump(), **fields})


def read(buffer: Any, count: int) -> np.ndarray:
    return np.frombuffer(buffer.read(), MET)[:count]


def assert_same(found: np.ndarray, expected: Expected, of: Scene, ties: float = 0.0) -> None:
    """Ties are what part of the rays meets an edge between triangles, to within rounding."""
    same = found["triangle"] == expected.triangle
    assert (~same).mean() <= ties
    hit = same & (found["triangle"] >= 0)
    np.testing.assert_allclose(found["distance"][hit], expected.distance[hit], rtol=2e-5)
    # On a sliver barycentric coordinates may differ by much where the points do not.
    corners = of.geometry.positions[of.geometry.triangles[found["triangle"][hit]]]
    apart = sum(
        (found[name][hit] - getattr(expected, name)[hit])[:, None] * (corners[:, k] - corners[:, 0])
        for k, name in ((1, "b1"), (2, "b2"))
    )
    assert np.linalg.norm(apart, axis=1).max() < 3e-5 * of.diagonal


@pytest.mark.parametrize("step", [1, 2, 3])
@pytest.mark.parametrize("name", ["cornell-box", "knot"])
def test_a_scene(gpu: Device, name: str, step: int) -> None:
    """Also at edges, and of sizes that are no multiples of anything."""
    of = open_scene(name)
    through = seen_from(of, width=150, height=101)
    found, expected = sight(gpu, of).look(through, step), look(of, through, step)
    n = expected.shape[0] * expected.shape[1]
    assert found.shape == expected.shape
    assert_same(read(found.centre, n), expected.centre, of, ties=2e-4)
    edge = np.frombuffer(found.edge.read(4 * (1 + found.edges)), np.int32)[1:]
    np.testing.assert_array_equal(np.sort(edge), expected.edge)
    assert (found.edges > 0) == (step == 1)
    if found.edges:
        sub = read(found.sub, 4 * found.edges).reshape(-1, 4)[np.argsort(edge)]
        assert_same(sub.ravel(), expected.sub, of, ties=1e-3)


def test_rays_mend_what_the_rasteriser_rounds(gpu: Device) -> None:
    """It is nearly right by itself, and with rays right but for ties."""
    of = open_scene("knot")
    expected = look(of, of.camera, 2).centre.triangle
    ids = TriangleIds(gpu, of.geometry.positions, of.geometry.triangles)
    drawn = np.frombuffer(ids.draw(of.camera, 2, NEAR * of.diagonal).read(), np.int32) - 1
    mended = read(sight(gpu, of).look(of.camera, 2).centre, len(expected))["triangle"]
    wrong, left = (drawn != expected).mean(), (mended != expected).mean()
    assert 0 < wrong < 5e-3
    assert left < 0.05 * wrong


@pytest.mark.parametrize("near", [0, NEAR])
def test_what_is_farthest_is_not_lost(gpu: Device, near: float) -> None:
    """The back wall of the box, which lies in the plane that is farthest of all."""
    box = cornell(32)
    found = read(sight(gpu, box, near).look(box.camera, 2).centre, 256)["triangle"]
    back = box.object_names.index("back wall")
    seen = box.geometry.object[found[found >= 0]]
    assert (seen == back).mean() > 0.1


@pytest.mark.parametrize(("height", "is_near"), [(1e-5, True), (5e-4, True), (0.1, False)])
@pytest.mark.parametrize("step", [1, 2])
def test_a_floor_right_below_the_eye(gpu: Device, height: float, is_near: bool, step: int) -> None:
    """It goes on behind the eye, and is seen nearer than the rasteriser draws it."""
    floor = rectangle("floor", [2, 2], [0, 0, 0], [-90, 0, 0])
    of = scene(
        camera=camera(40, position=[0.1, height, 0.2], target=[0, 0, -0.1], fov_y_degrees=120),
        materials={"floor": {"type": "diffuse", "diffuse": [0.5] * 3}},
        objects=[{**floor, "material": "floor"}],
    )
    eye = sight(gpu, of)
    inverse = np.linalg.inv(of.camera.to_pixels(step))
    assert eye._is_near(of.camera, inverse, of.camera.shape(step)) == is_near
    found, expected = eye.look(of.camera, step), look(of, of.camera, step)
    centre = read(found.centre, expected.shape[0] * expected.shape[1])
    assert_same(centre, expected.centre, of, ties=1e-3)
    assert (expected.centre.triangle >= 0).any()


def test_nothing_behind_the_eye_is_drawn(gpu: Device) -> None:
    of = cornell(32)
    there, here = np.array(of.camera.target), np.array(of.camera.position)
    away = seen_from(of, target=(2 * here - there).tolist())
    assert (read(sight(gpu, of).look(away, 2).centre, 256)["triangle"] == -1).all()


def test_where_a_ray_meets_a_plane(gpu: Device) -> None:
    """From corners by their barycentrics, at any distance."""
    rng = np.random.default_rng(1)
    corners = rng.normal(size=(200, 3, 3))
    b = rng.uniform(-0.5, 1.5, (200, 2))
    weights = np.column_stack([1 - b.sum(axis=1), b])
    aim = (weights[:, :, None] * corners).sum(axis=1)
    distance = np.linalg.norm(aim - [0.1, 0.2, 0.3], axis=1)
    packed = np.zeros((200, 3, 4), np.float32)
    packed[:, :, :3] = corners
    w = (aim - [0.1, 0.2, 0.3]) / distance[:, None]
    found = call(
        gpu, "common/seen.glsl", "m.b1, m.b2, m.distance", 3,
        before="Seen m = meet(i, w);", buffers={"b_triangles": gpu.upload(packed)},
        uniforms={"u_eye": (0.1, 0.2, 0.3)}, w=w.astype(np.float32),
    )  # fmt: skip
    n = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    slope = np.abs((n * w).sum(axis=1)) / np.linalg.norm(n, axis=1)
    off = np.abs(found - np.column_stack([b, distance])) * slope[:, None]
    assert off.max() < 1e-4
    assert np.median(off) < 1e-6
