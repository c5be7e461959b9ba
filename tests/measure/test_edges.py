"""Edges are where surfaces meet, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.measure.edges import edge_mask, lamps_seen, scene_edges, seen_objects
from engine.scene.open import open_scene
from engine.scene.scene import Scene

EYE = (0.0, 0.0, 0.0)
Buffers = tuple[NDArray, NDArray, NDArray]


def plane(normal: tuple[float, float, float], height: int = 32, width: int = 48) -> Buffers:
    """What a camera at the origin that looks along -z sees of a plane five metres off."""
    y, x = np.mgrid[1 : -1 : height * 1j, -1 : 1 : width * 1j]
    rays = np.stack([x, y, -np.ones_like(x)], axis=-1) * [0.3, 0.3, 1]
    n = np.array(normal) / np.linalg.norm(normal)
    t = (n @ np.array([0, 0, -5.0])) / (rays @ n)
    return rays * t[..., None], np.broadcast_to(n, rays.shape), np.zeros(x.shape, np.int64)


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 1, 0.5), (1, 0, 0.32), (1, 2, 1)])
def test_a_plane_has_no_edge_however_steep(normal: tuple[float, float, float]) -> None:
    assert not edge_mask(*plane(normal), EYE).any()


def test_two_surfaces_meet_along_two_columns() -> None:
    position, normal, surface = plane((0, 0, 1))
    surface[:, 20:] = 1
    edges = edge_mask(position, normal, surface, EYE)
    assert edges[:, 19:21].all()
    assert edges.sum() == 2 * len(edges)


def test_a_lone_pixel_marks_its_eight_neighbours() -> None:
    position, normal, surface = plane((0, 0, 1))
    surface[10, 12] = 7
    edges = edge_mask(position, normal, surface, EYE)
    assert edges[9:12, 11:14].all()
    assert edges.sum() == 9


def test_a_step_in_depth_and_a_fold() -> None:
    position, normal, surface = plane((0, 0, 1))
    step = position.copy()
    step[16:] *= 1.2
    assert edge_mask(step, normal, surface, EYE)[15:17].all()
    assert edge_mask(step, normal, surface, EYE).sum() == 2 * position.shape[1]
    folded = normal.copy()
    folded[:, 30:] = [0.0, 0.6, 0.8]
    assert edge_mask(position, folded, surface, EYE)[:, 29:31].all()


def test_what_a_pixel_shows() -> None:
    """Objects by their index, above them what is beyond."""
    scene = open_scene("knot")
    small = {"width": 50, "height": 40}
    seen = seen_objects(scene.with_camera(scene.camera.model_copy(update=small)))
    assert seen.shape == (40, 50)
    assert set(np.unique(seen)) == {-1, 0, 1}
    assert seen[-1, 0] == 1
    assert seen[0, 0] == -1


def test_the_background_is_a_surface_of_its_own() -> None:
    position, normal, surface = plane((0, 0, 1))
    surface[:5], position[:5], normal = -1, 0.0, normal.copy()
    normal[:5] = 0.0
    edges = edge_mask(position, normal, surface, EYE)
    assert edges[4:6].all()
    assert edges.sum() == 2 * position.shape[1]
    assert not edge_mask(0 * position, 0 * normal, np.full_like(surface, -1), EYE).any()


def pixel_of(scene: Scene, point: tuple[float, float, float]) -> tuple[int, int]:
    """Row and column that a world point falls on, by trial of the camera's own directions."""
    camera = scene.camera
    y, x = np.mgrid[0 : camera.height, 0 : camera.width].reshape(2, -1) + 0.5
    towards = np.subtract(point, camera.position)
    best = int(np.argmax(camera.directions(x, y) @ (towards / np.linalg.norm(towards))))
    return divmod(best, camera.width)


def test_edges_of_the_cornell_box() -> None:
    scene = open_scene("cornell-box")
    scene = scene.with_camera(scene.camera.model_copy(update={"width": 160, "height": 160}))
    edges = scene_edges(scene)
    assert edges.shape == (160, 160)
    assert 0.03 < edges.mean() < 0.2
    # Floor meets back wall, right wall meets back wall; the middles of both walls are smooth.
    assert edges[pixel_of(scene, (0.52, 0.0, 0.559))]
    assert edges[pixel_of(scene, (0.0, 0.4, 0.559))]
    assert not edges[pixel_of(scene, (0.2, 0.4, 0.559))]
    assert not edges[pixel_of(scene, (0.0, 0.35, 0.3))]


def test_lamps_are_seen_while_they_are_on_and_in_front() -> None:
    scene = open_scene("cornell-box")
    scene = scene.with_camera(scene.camera.model_copy(update={"width": 64, "height": 64}))
    seen = lamps_seen(scene)
    y, x = np.nonzero(seen)
    assert 20 < len(x) < 100
    assert seen[y.min() : y.max() + 1, x.min() + 2 : x.max() - 1].all()
    assert 4 < y.min() < y.max() < 16
    assert 20 < x.min() < x.max() < 44
    for change in ({"enabled": False}, {"position": (0.278, 3.0, 0.28)}):
        lights = tuple(light.model_copy(update=change) for light in scene.lights)
        assert not lamps_seen(scene.with_lights(lights)).any()
