"""Rays through the tree agree with Embree."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from backend.gl.one_call import call

from engine.backend.gl.bvh import DEEP, LEAF, Tree, build_tree
from engine.backend.gl.context import Device
from engine.scene.open import open_scene
from engine.scene.rays import RayTracer

pytestmark = pytest.mark.gl


def depth_and_triangles(tree: Tree) -> tuple[int, list[int]]:
    """How deep the tree is, and every triangle's place as often as a leaf holds it."""
    links, found, deepest = tree.nodes.view(np.int32)[:, :2, 3], [], 0
    stack = [(0, 1)]
    while stack:
        node, depth = stack.pop()
        deepest = max(deepest, depth)
        for child in links[node]:
            if child >= 0:
                stack.append((child, depth + 1))
            else:
                first, count = divmod(-1 - int(child), 8)
                assert count <= LEAF
                found += range(first, first + count)
    return deepest, found


def sphere(rows: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed ball of radius 1 of 2 rows (rows - 1) triangles."""
    theta = np.pi * np.arange(rows + 1) / rows
    phi = 2 * np.pi * np.arange(rows) / rows
    ring = np.stack([np.cos(phi), np.zeros(rows), np.sin(phi)], axis=1)
    up = np.array([0, 1, 0])
    points = (np.sin(theta)[:, None, None] * ring + np.cos(theta)[:, None, None] * up).reshape(
        -1, 3
    )
    i, j = np.divmod(np.arange(rows * rows), rows)
    a, b, c, d = ((i + k) * rows + (j + m) % rows for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
    points[-rows:] = 0, -1, 0  # as at the north pole, to the last bit
    return points.astype(np.float32), np.concatenate([[a, b, c], [a, c, d]], axis=1).T.astype(
        np.int32
    )


def soup(n: int, seed: int = 1, size: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    """n triangles anywhere in a cube."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-1, 1, (n, 1, 3))
    corners = middle + rng.normal(scale=size, size=(n, 3, 3))
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * n, dtype=np.int32).reshape(
        -1, 3
    )


@pytest.mark.parametrize("n", [1, 2, LEAF, LEAF + 1, 100, 3000])
def test_every_triangle_is_in_one_leaf_and_in_its_boxes(n: int) -> None:
    tree = build_tree(*soup(n))
    deepest, found = depth_and_triangles(tree)
    assert sorted(found) == list(range(n))
    assert deepest < 40


def test_all_in_one_place_is_not_too_deep() -> None:
    positions, triangles = soup(1)
    tree = build_tree(positions, np.repeat(triangles, 5000, axis=0))
    deepest, found = depth_and_triangles(tree)
    assert len(found) == 5000
    assert deepest < 16


def test_an_endless_chain_of_ever_smaller_triangles_is_not_too_deep() -> None:
    """Each half as far from the origin as the last: the heuristic would cut them off one by one."""
    positions, _ = soup(1, size=0.1)
    factor = 0.5 ** np.arange(100)
    chain = (positions[None] * factor[:, None, None]).reshape(-1, 3).astype(np.float32)
    tree = build_tree(chain, np.arange(300, dtype=np.int32).reshape(-1, 3))
    assert depth_and_triangles(tree)[0] <= DEEP + 8


def uploaded(gpu: Device, tree: Tree) -> dict[str, Any]:
    return {"b_nodes": gpu.upload(tree.nodes), "b_corners": gpu.upload(tree.corners)}


def occluded(gpu: Device, tree: Tree, o: np.ndarray, d: np.ndarray, limit: float) -> np.ndarray:
    return call(
        gpu, "common/bvh.glsl", "occluded(o, d, limit) ? 1.0 : 0.0", 1, buffers=uploaded(gpu, tree),
        o=o, d=d, limit=np.array([[limit]]),
    )[:, 0] > 0.5  # fmt: skip


def nearest(gpu: Device, tree: Tree, o: np.ndarray, d: np.ndarray) -> np.ndarray:
    return call(
        gpu, "common/bvh.glsl", "float(nearest(o, d))", 1, buffers=uploaded(gpu, tree), o=o, d=d
    )[:, 0].astype(int)


@pytest.mark.parametrize("n", [1, 7, 300, 5000])
def test_soup(gpu: Device, n: int) -> None:
    positions, triangles = soup(n)
    rng = np.random.default_rng(2)
    o = rng.uniform(-1.5, 1.5, (20000, 3)).astype(np.float32)
    d = rng.uniform(-1.5, 1.5, (20000, 3)).astype(np.float32) - o
    # Rays along the axes too, whose inverses are infinite.
    d[:3000] = (np.eye(3, dtype=np.float32) * 2)[rng.integers(0, 3, 3000)]
    expected = RayTracer(positions, triangles).occluded(o, d, 1.0)
    found = occluded(gpu, build_tree(positions, triangles), o, d, 1.0)
    assert expected.any()
    assert (found != expected).mean() < 1e-4


@pytest.mark.parametrize("n", [1, 7, 300, 5000])
def test_what_rays_meet_first(gpu: Device, n: int) -> None:
    positions, triangles = soup(n)
    rng = np.random.default_rng(7)
    o = rng.uniform(-1.5, 1.5, (20000, 3)).astype(np.float32)
    d = rng.normal(size=(20000, 3)).astype(np.float32)
    d[:3000] = (np.eye(3, dtype=np.float32) * -2)[rng.integers(0, 3, 3000)]
    expected = RayTracer(positions, triangles).intersect(o, d).triangle
    found = nearest(gpu, build_tree(positions, triangles), o, d)
    assert (expected >= 0).any()
    assert (found != expected).mean() < 1e-4


def to_edges(positions: np.ndarray, triangles: np.ndarray, o: np.ndarray, seed: int) -> np.ndarray:
    """Directions (n, 3) from o (n, 3) exactly at edges and corners of triangles."""
    rng = np.random.default_rng(seed)
    t = triangles[rng.integers(0, len(triangles), len(o))]
    a, b = positions[t[:, 0]], positions[t[:, 1]]
    s = rng.choice([0, 0.25, 0.5, 0.7, 1], (len(o), 1))
    return ((1 - s) * a + s * b - o).astype(np.float32)


def test_no_ray_slips_out_between_triangles(gpu: Device) -> None:
    positions, triangles = sphere(24)
    o = np.random.default_rng(3).uniform(-0.3, 0.3, (50000, 3)).astype(np.float32)
    d = to_edges(positions, triangles, o, 4)
    for limit in (1.01, 1e30):
        assert occluded(gpu, build_tree(positions, triangles), o, d, limit).all()


def test_rays_that_graze_edges(gpu: Device) -> None:
    """The hardest there are: at the outlines of blocks rounding alone decides."""
    scene = open_scene("cornell-box")
    positions, triangles = scene.geometry.positions, scene.geometry.triangles
    low, high = positions.min(axis=0), positions.max(axis=0)
    o = np.random.default_rng(3).uniform(low, high, (50000, 3)).astype(np.float32)
    d = to_edges(positions, triangles, o, 5)
    expected = scene.rays.occluded(o, d, 2.0)
    found = occluded(gpu, build_tree(positions, triangles), o, d, 2.0)
    assert 0 < expected.mean() < 1
    assert (found != expected).mean() < 2e-3


@pytest.mark.data
def test_a_real_room(gpu: Device, shared_data: Path) -> None:
    scene = open_scene(str(shared_data / "scenes" / "living_room" / "living_room.obj"))
    positions, triangles = scene.geometry.positions, scene.geometry.triangles
    rng = np.random.default_rng(6)
    low, high = positions.min(axis=0), positions.max(axis=0)
    o, end = rng.uniform(low, high, (2, 100000, 3)).astype(np.float32)
    expected = scene.rays.occluded(o, end - o, 1.0)
    found = occluded(gpu, build_tree(positions, triangles), o, end - o, 1.0)
    assert 0.1 < expected.mean() < 0.9
    assert (found != expected).mean() < 1e-4
