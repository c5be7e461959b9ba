"""The deep frame-buffer against planes that are known, and its edges where objects meet."""

from __future__ import annotations

import numpy as np
import pytest
from methods.scenes import camera, cornell, rectangle, scene, with_camera

from engine.methods.fixed_view.frame_buffer import SUBSAMPLES, FrameBuffer, build, look_at
from engine.scene.scene import Scene


def wall(size: int = 32, **fields: object) -> Scene:
    """A large plane z = 0, seen from z = 2 a little from the side."""
    return scene(
        camera=camera(size, position=[0.5, 0.3, 2], target=[0, 0, 0], **fields),
        objects=[rectangle("wall", [100, 100], [0, 0, 0])],
    )


def grid(buffer: FrameBuffer) -> tuple[np.ndarray, np.ndarray]:
    """Pixel coordinates of the centres, (n,) each."""
    camera = buffer.camera
    y, x = np.divmod(np.arange(camera.width * camera.height), camera.width)
    return x + 0.5, y + 0.5


@pytest.mark.parametrize(("width", "height"), [(32, 32), (33, 17), (1, 1), (1, 5)])
def test_positions_lie_where_rays_meet_the_plane(width: int, height: int):
    buffer = build(wall(width=width, height=height))
    eye = np.array([0.5, 0.3, 2])
    d = buffer.camera.directions(*grid(buffer)).astype(np.float64)
    expected = eye - d * (eye[2] / d[:, 2:])
    np.testing.assert_allclose(buffer.centre.position, expected, atol=3e-5)
    np.testing.assert_allclose(buffer.centre.normal, np.tile([0, 0, 1], (len(d), 1)), atol=1e-6)
    np.testing.assert_allclose(buffer.centre.view, -d, atol=1e-6)
    assert (buffer.centre.object == 0).all()
    assert len(buffer.edge) == len(buffer.sub) == 0


def test_normals_face_the_eye_from_either_side():
    behind = build(with_camera(wall(), position=(0.2, 0, -2)))
    assert (behind.centre.normal[:, 2] < -0.99).all()
    assert (behind.centre.geometric[:, 2] < -0.99).all()


def test_edges_are_where_objects_meet():
    """Every pixel whose corners see two surfaces is one, and none in the midst of a surface."""
    box = cornell(64)
    buffer = build(box)
    at_edge = np.zeros(64 * 64, bool)
    at_edge[buffer.edge] = True
    x, y = grid(buffer)
    seen = []
    for dx, dy in SUBSAMPLES:
        d = box.camera.directions(x + dx, y + dy)
        hits = box.rays.intersect(np.tile(np.float32(box.camera.position), (len(d), 1)), d)
        t = hits.triangle
        found = np.where(t >= 0, box.geometry.object[t], -1)
        normal = np.where((t >= 0)[:, None], normal_of(box)[t], 0)
        seen.append((found, normal))
    several = np.zeros(64 * 64, bool)
    for found, normal in seen[1:]:
        turned = (np.abs(normal - seen[0][1]) > 0.05).any(axis=1)
        several |= (found != seen[0][0]) | turned
    np.testing.assert_array_equal(at_edge, several)
    assert 200 < at_edge.sum() < 1200
    assert (np.diff(buffer.edge) > 0).all()


def normal_of(scene: Scene) -> np.ndarray:
    a, b, c = np.moveaxis(scene.geometry.positions[scene.geometry.triangles].astype(float), 1, 0)
    n = np.cross(b - a, c - a)
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def test_a_smooth_sphere_has_edges_at_its_rim_only():
    ball = scene(
        camera=camera(64, position=[0, 0, 3], fov_y_degrees=30),
        objects=[{"name": "ball", "mesh": {"shape": "sphere", "rings": 64}}],
    )
    buffer = build(ball)
    x, y = buffer.edge % 64 - 31.5, buffer.edge // 64 - 31.5
    # The rim appears at tan(asin(r / d)) of tan(15°), which is half the picture's width.
    rim = 32 * np.tan(np.arcsin(0.5 / 3)) / np.tan(np.radians(15))
    radius = np.hypot(x, y)
    # A curve meets 4 s / π squares of side s for each unit of its length; s is half a pixel here.
    assert len(buffer.edge) == pytest.approx(2 / np.pi * 2 * np.pi * rim, rel=0.15)
    assert radius.max() < rim + 1
    # Towards the rim the normal turns by more than 8 degrees within a pixel.
    assert radius.min() > rim - 4


def test_donors_are_close_and_alike():
    box = cornell(64)
    buffer = build(box)
    pixel = np.repeat(buffer.edge, 4)
    assert np.abs(buffer.donor % 64 - pixel % 64).max() <= 1
    assert np.abs(buffer.donor // 64 - pixel // 64).max() <= 1
    hit = buffer.sub.model >= 0
    assert hit.sum() > 800
    donor = buffer.centre.take(buffer.donor)
    assert (donor.model[hit] >= 0).all()
    # The donor shares the surface: at most a few, at tips thinner than a pixel, find none.
    same = (donor.object == buffer.sub.object) & (
        np.einsum("ij,ij->i", donor.normal, buffer.sub.normal) > 0.99
    )
    assert same[hit].mean() > 0.98
    plain = buffer.centre.take(pixel)
    without = np.einsum("ij,ij->i", plain.normal, buffer.sub.normal) > 0.99
    assert (without & (plain.object == buffer.sub.object))[hit].mean() < 0.8


def test_a_camera_that_sees_nothing():
    buffer = build(with_camera(wall(8), target=(0.5, 0.3, 5)))
    assert (buffer.centre.model == -1).all()
    assert len(buffer.edge) == 0
    assert not buffer.centre.position.any()


def test_textures_are_averaged_within_a_pixel_and_only_there():
    """Of materials without textures the parameters of a pixel are those of its material."""
    box = cornell(32)
    buffer = build(box)
    hit = buffer.centre.model >= 0
    row = box.material_table.row[buffer.centre.material[hit]]
    np.testing.assert_allclose(buffer.centre.row[hit], row, rtol=1e-6)


def test_a_crack_speaks_for_nobody() -> None:
    """Two boards a millimetre apart before a wall: centres that see through the gap."""
    boards = [rectangle(f"board {side}", [2, 1], [0, side * 0.5005, 0]) for side in (-1, 1)]
    cracked = scene(
        camera=camera(33, position=[0, 0, 3], fov_y_degrees=20),
        objects=[*boards, rectangle("wall", [4, 4], [0, 0, -1])],
    )
    wall = cracked.object_names.index("wall")
    middle = slice(16 * 33, 17 * 33)
    through = cracked.camera.directions(np.arange(33) + 0.5, np.full(33, 16.5))
    assert (look_at(cracked, through).object == wall).all()
    centre = build(cracked).centre
    assert (centre.object != wall).all()
    assert (centre.position[middle, 2] == 0).all()
    # The rays stay those through the centres: lamps and the ends of shadows are found with them.
    np.testing.assert_array_equal(centre.view[middle], -through)
