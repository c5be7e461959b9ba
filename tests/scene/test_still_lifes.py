"""The built-in scenes in which to edit materials: what stands where, and what the camera sees."""

from __future__ import annotations

import numpy as np
import pytest

from engine.scene.bezier import spline
from engine.scene.builtin import ring, teatray, vase
from engine.scene.open import open_scene
from engine.scene.scene import Scene

MATERIALS = {
    "teatray": ("teapot", "handles", "tray"),
    "vase": ("flowers", "stems", "table", "vase"),
    "ring": ("ring", "plane"),
}
SIZES = {"teatray": (320, 240), "vase": (512, 512), "ring": (400, 400)}


@pytest.fixture(scope="module")
def scenes() -> dict[str, Scene]:
    return {name: open_scene(name) for name in MATERIALS}


def corners(scene: Scene, name: str) -> np.ndarray:
    """Corners (n, 3) of an object."""
    mine = scene.geometry.object == scene.object_names.index(name)
    return scene.geometry.positions[np.unique(scene.geometry.triangles[mine])].astype(float)


@pytest.mark.parametrize("name", MATERIALS)
def test_camera_sees_every_material_from_its_front(name: str, scenes: dict[str, Scene]) -> None:
    scene = scenes[name]
    camera, geometry = scene.camera, scene.geometry
    assert (camera.width, camera.height) == SIZES[name]
    assert scene.material_names == MATERIALS[name]
    y, x = np.mgrid[0 : camera.height : 2, 0 : camera.width : 2].reshape(2, -1)
    rays = camera.directions(x + 0.5, y + 0.5)
    eye = np.tile(np.array(camera.position, np.float32), (len(rays), 1))
    hit = scene.rays.intersect(eye, rays)
    met = hit.triangle >= 0
    share = np.bincount(geometry.material[hit.triangle[met]], minlength=len(MATERIALS[name]))
    assert (share / len(rays)).min() > 0.01
    a, b, c = (geometry.positions[geometry.triangles[hit.triangle[met], k]] for k in range(3))
    front = np.sum(np.cross(b - a, c - a) * rays[met], axis=1) < 0
    # All but what one sees through the gap round the teapot's lid and the tip of its spout.
    assert front.mean() > (0.98 if name == "teatray" else 0.9999)


def test_teapot_stands_in_the_tray(scenes: dict[str, Scene]) -> None:
    scene = scenes["teatray"]
    tray, pot = corners(scene, "tray"), corners(scene, "teapot")
    floor = tray[np.hypot(tray[:, 0], tray[:, 2]) < 0.2, 1].max()
    assert floor == pytest.approx(teatray.FLOOR)
    assert pot[:, 1].min() == pytest.approx(floor, abs=1e-7)
    for name in ("teapot", "handles"):
        things = corners(scene, name)
        assert np.hypot(things[:, 0], things[:, 2]).max() < 0.2
    # The knob sits on the lid, the handle at the body.
    assert corners(scene, "handles")[:, 1].max() > pot[:, 1].max()
    assert corners(scene, "handles")[:, 0].min() < pot[:, 0].min()


def test_flowers_stand_in_the_vase_and_the_vase_on_the_table(scenes: dict[str, Scene]) -> None:
    scene = scenes["vase"]
    assert corners(scene, "vase")[:, 1].min() == 0
    assert corners(scene, "table")[:, 1].max() == 0
    # The inside of the vase, from its bottom up.
    lip = max(range(len(vase.PROFILE)), key=lambda k: vase.PROFILE[k][1]) + 1
    inside = np.array(vase.PROFILE[lip:][::-1])
    wall = spline(inside, np.linspace(0, len(inside) // 3, 999))
    for name in scene.object_names:
        if name in ("vase", "table"):
            continue
        piece = corners(scene, name)
        low = piece[piece[:, 1] < wall[-1, 1]]
        assert (np.hypot(low[:, 0], low[:, 2]) < np.interp(low[:, 1], wall[:, 1], wall[:, 0])).all()
        if "petal" in name:
            assert len(low) == 0
        else:
            assert low[:, 1].min() > 0.02


def test_grain_of_the_vase_runs_round_it(scenes: dict[str, Scene]) -> None:
    geometry, names = scenes["vase"].geometry, scenes["vase"].object_names
    mine = np.unique(geometry.triangles[geometry.object == names.index("vase")])
    mine = mine[np.hypot(geometry.positions[mine, 0], geometry.positions[mine, 2]) > 1e-3]
    tangents, outward = geometry.tangents[mine], geometry.positions[mine] * [1, 0, 1]
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    # The triangles at the texture's seam and at edges lie to one side of their vertices.
    assert np.abs(tangents[:, 1]).max() < 0.05
    assert np.abs(np.sum(tangents * outward, axis=1)).max() < 0.05


def test_ring_gathers_the_sun_at_half_its_radius(scenes: dict[str, Scene]) -> None:
    scene = scenes["ring"]
    assert corners(scene, "ring")[:, 1].min() == pytest.approx(0, abs=1e-9)
    ahead = np.array(scene.lights[0].row()[3:6], float)
    level = ahead * [1, 0, 1] / np.hypot(ahead[0], ahead[2])
    # Mirror a sheet of sunlight at what it meets of the inner wall, down to the plane.
    side = np.cross(level, [0, 1, 0])
    across, up = np.mgrid[-0.95:0.95:201j, 0.02:0.98:99j].reshape(2, -1)
    aim = across[:, None] * ring.INSIDE * side + up[:, None] * ring.HEIGHT * [0, 1, 0]
    aim += np.sqrt(1 - across**2)[:, None] * ring.INSIDE * level
    eye = (aim - 0.5 * ahead).astype(np.float32)
    hit = scene.rays.intersect(eye, np.tile(ahead, (len(eye), 1)).astype(np.float32))
    there = np.abs(hit.distance - 0.5) < 2e-4  # not kept off by the near wall
    assert there.mean() > 0.5
    place, n = aim[there], -aim[there] * [1, 0, 1] / ring.INSIDE
    mirrored = ahead - 2 * (n @ ahead)[:, None] * n
    floor = place - mirrored * (place[:, 1] / mirrored[:, 1])[:, None]
    inside = np.hypot(floor[:, 0], floor[:, 2]) < ring.INSIDE
    assert inside.mean() > 0.8
    # As bright as it would be if all of it were spread evenly, times:
    cusp = np.linalg.norm(floor - 0.5 * ring.INSIDE * level, axis=1) < 0.1 * ring.INSIDE
    assert cusp.sum() / (0.01 * len(floor)) > 5
