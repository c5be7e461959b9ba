"""Built-in scenes and real files."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.scene.open import open_scene, scenes
from engine.scene.scene import Scene


@pytest.fixture(scope="module")
def cornell() -> Scene:
    return open_scene("cornell-box")


def test_every_built_in_scene_opens_without_complaint() -> None:
    assert list(scenes()) == ["cornell-box", "knot", "ring", "room", "teatray", "vase"]
    for name, summary in scenes().items():
        scene = open_scene(name)
        assert scene.name == name
        assert scene.diagnoses == ()
        assert scene.lights or scene.environment
        assert len(summary) > 20


def test_the_same_scene_twice_is_the_same_bytes() -> None:
    for name in scenes():
        assert open_scene(name).transport_digest == open_scene(name).transport_digest


def of(scene: Scene, name: str) -> np.ndarray:
    """Corners (t, 3, 3) of an object's triangles."""
    mine = scene.geometry.object == scene.object_names.index(name)
    return scene.geometry.positions[scene.geometry.triangles[mine]].astype(float)


def test_cornell_box_has_its_published_measurements(cornell: Scene) -> None:
    size = np.ptp(np.concatenate([of(cornell, n) for n in cornell.object_names]), axis=(0, 1))
    assert np.allclose(size, [0.556, 0.5488, 0.5592], atol=1e-6)
    floor = of(cornell, "floor")
    area = np.linalg.norm(np.cross(floor[:, 1] - floor[:, 0], floor[:, 2] - floor[:, 0]), axis=1)
    # A trapezium of 552.8 and 549.6 by 559.2 millimetres.
    assert area.sum() / 2 == pytest.approx((0.5528 + 0.5496) / 2 * 0.5592, rel=1e-6)
    assert np.ptp(of(cornell, "short block")[..., 1]) == pytest.approx(0.165)
    assert np.ptp(of(cornell, "tall block")[..., 1]) == pytest.approx(0.330)
    # Tops are about 160 mm square, as measured to the millimetre.
    top = of(cornell, "short block")[:2]
    edge = np.linalg.norm(top[0, 1] - top[0, 0])
    assert edge == pytest.approx(np.hypot(0.048, 0.160), rel=1e-5)


def test_cornell_box_faces_inwards_and_its_blocks_outwards(cornell: Scene) -> None:
    middle = np.array([0.278, 0.274, 0.28])
    for name in cornell.object_names:
        corners = of(cornell, name)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        if "block" in name:
            inner = corners.mean(axis=(0, 1))
            inner[1] = np.ptp(corners[..., 1]) / 2
            assert np.all(np.sum((corners.mean(axis=1) - inner) * normal, axis=1) > 0)
        else:
            assert np.all(np.sum((middle - corners.mean(axis=1)) * normal, axis=1) > 0)


def test_cornell_box_camera_sees_what_was_photographed(
    cornell: Scene, look: Callable[..., Any]
) -> None:
    camera = cornell.camera
    assert (camera.width, camera.height) == (512, 512)
    # Red on the left, green on the right, and the back wall between the blocks and the ceiling.
    sights = {(20, 200): "left wall", (492, 200): "right wall", (256, 180): "back wall"}
    sights |= {(256, 500): "floor", (256, 20): "ceiling", (180, 300): "tall block"}
    for (x, y), name in sights.items():
        ray = camera.directions(np.array([x + 0.5]), np.array([y + 0.5]))[0]
        seen = look(cornell, camera.position, ray)
        assert seen.object == name
    back = look(cornell, camera.position, (0, 0.15, 1))
    assert back.object == "back wall"
    assert back.distance == pytest.approx(0.5592 + 0.8, abs=1e-4)


def test_cornell_box_lamp_hangs_under_the_ceiling_and_shines_down(cornell: Scene) -> None:
    lamp = cornell.lights[0].row()
    assert lamp[1] == pytest.approx(0.5488, abs=1e-3)
    assert lamp[1] < 0.5488
    assert np.allclose(lamp[3:6], [0, -1, 0], atol=1e-6)
    assert lamp[15:17] == pytest.approx([0.065, 0.0525])
    assert np.abs(lamp[9:12]) == pytest.approx([1, 0, 0], abs=1e-6)


def test_room_is_closed_around_its_camera() -> None:
    scene = open_scene("room")
    u = np.random.default_rng(0).normal(size=(20_000, 3)).astype(np.float32)
    for place in (scene.camera.position, *(light.row()[:3] for light in scene.lights)):
        hit = scene.rays.intersect(np.tile(np.array(place, np.float32), (len(u), 1)), u)
        assert (hit.triangle >= 0).all()


def test_most_of_the_room_is_lit_by_bounce() -> None:
    # Points in view that neither the lamp nor the light of the next room reaches.
    scene = open_scene("room")
    camera = scene.camera
    y, x = np.mgrid[0 : camera.height : 8, 0 : camera.width : 8].reshape(2, -1)
    rays = camera.directions(x + 0.5, y + 0.5)
    eye = np.tile(np.array(camera.position, np.float32), (len(rays), 1))
    hit = scene.rays.intersect(eye, rays)
    points = eye + (hit.distance[:, None] - 1e-3) * rays
    dark = np.ones(len(points), bool)
    for light in scene.lights:
        row = light.row()
        to = (row[:3] - points).astype(np.float32)
        unit = to / np.linalg.norm(to, axis=1, keepdims=True)
        within = -unit @ row[3:6] > (1 - row[9] if light.id != "hall" else 0)
        dark &= ~(within & ~scene.rays.occluded(points.astype(np.float32), to, 0.999))
    assert dark.mean() > 0.65


@pytest.mark.data
def test_living_room(shared_data: Path, look: Callable[..., Any]) -> None:
    path = shared_data / "scenes" / "living_room" / "living_room.obj"
    start = time.perf_counter()
    scene = open_scene(path)
    seconds = time.perf_counter() - start
    assert len(scene.geometry.triangles) == 28_650
    assert len(scene.material_names) == 40
    assert "missing_file" not in [d.code for d in scene.diagnoses]
    # 16 of the materials name one of the 17 images, each of which is kept once.
    assert (scene.material_table.maps[:, 0] >= 0).sum() == 16
    assert len(scene.material_table.texture) == 16
    carpet = scene.material_names.index("Carpet")
    assert scene.material_table.maps[carpet, 0] >= 0
    # The camera stands in the room, between floor and ceiling, with air around it.
    u = np.random.default_rng(0).normal(size=(2000, 3)).astype(np.float32)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    hit = scene.rays.intersect(np.tile(np.array(scene.camera.position, np.float32), (2000, 1)), u)
    assert (hit.triangle >= 0).mean() > 0.9
    assert hit.distance.min() > 0.2
    names = {
        scene.material_names[m] for m in scene.geometry.material[hit.triangle[hit.triangle >= 0]]
    }
    assert {"Floor", "SofaLeather", "Walls"} <= names
    assert seconds < 20, "opening takes about 2 s; this guards against a slow path only"


@pytest.mark.data
def test_duck_is_yellow_and_has_an_orange_beak(shared_data: Path, look: Callable[..., Any]) -> None:
    scene = open_scene(shared_data / "meshes" / "duck.glb")
    assert len(scene.geometry.triangles) == 4212
    low, high = scene.geometry.positions.min(axis=0), scene.geometry.positions.max(axis=0)
    middle = (low + high) / 2
    yellow = look(scene, (middle[0], high[1] + 1, middle[2]), (0, -1, 0)).row[:3]
    assert yellow[0] > 0.5
    assert yellow[1] > 0.4
    assert yellow[2] < 0.2
    # The beak points along +x.
    beak = scene.geometry.positions[np.argmax(scene.geometry.positions[:, 0])]
    orange = look(scene, beak + np.array([1, 0.01, 0], np.float32), (-1, 0, 0)).row[:3]
    assert orange[0] > 0.5
    assert 0.1 < orange[1] < 0.7 * orange[0]


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "triangles"),
    [("stanford-bunny.ply", 69_451), ("dragon-100k.obj", 100_000), ("spot.obj", 5856)],
)
def test_real_meshes_keep_their_triangles(shared_data: Path, name: str, triangles: int) -> None:
    scene = open_scene(shared_data / "meshes" / name)
    assert len(scene.geometry.triangles) == triangles
    assert np.allclose(np.linalg.norm(scene.geometry.normals, axis=1), 1, atol=1e-5)
    assert [d.code for d in scene.diagnoses] == ["normals_made", "default_lights"]
