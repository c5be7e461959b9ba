"""The cluster tree: balanced, compact, deterministic, whatever the points."""

from __future__ import annotations

import numpy as np
import pytest

from engine.methods.fixed_view.hierarchy import build_order, describe_clusters, level_start

K = 20.0


def box_points(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Points on the six faces of a unit cube, with normals inwards."""
    rng = np.random.default_rng(seed)
    position = rng.uniform(0, 1, (n, 3))
    face = rng.integers(0, 6, n)
    axis, side = face % 3, face // 3
    position[np.arange(n), axis] = side
    normal = np.zeros((n, 3))
    normal[np.arange(n), axis] = 1 - 2 * side
    return position.astype(np.float32), normal.astype(np.float32)


def scatter_within(position, normal, diagonal: float, order, size: int) -> float:
    """Mean distance (eq. 9) of samples to the centroids of their clusters of `size`."""
    features = np.concatenate([K * position, diagonal * normal], axis=1)[order]
    groups = features.reshape(-1, size, 6).astype(np.float64)
    return float(((groups - groups.mean(axis=1, keepdims=True)) ** 2).sum(axis=2).mean())


def order_of(position, normal) -> np.ndarray:
    return build_order(position, normal, np.sqrt(3.0), K)


@pytest.mark.parametrize("n", [1, 4, 16, 64, 1024, 4096])
def test_is_a_permutation(n: int) -> None:
    np.testing.assert_array_equal(np.sort(order_of(*box_points(n))), np.arange(n))


def test_is_deterministic_whatever_the_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    points = box_points(1024)
    orders = []
    for threads in ("1", "2", "2"):
        monkeypatch.setenv("RELIGHT_THREADS", threads)
        orders.append(order_of(*points))
    np.testing.assert_array_equal(orders[0], orders[1])
    np.testing.assert_array_equal(orders[0], orders[2])


@pytest.mark.parametrize("size", [4, 16, 64, 256])
def test_clusters_are_compact(size: int) -> None:
    """Far below clusters of points at random; at the lower levels by orders of magnitude."""
    position, normal = box_points(4096)
    built = scatter_within(position, normal, 3**0.5, order_of(position, normal), size)
    shuffled = np.random.default_rng(9).permutation(4096)
    at_random = scatter_within(position, normal, 3**0.5, shuffled, size)
    # A patch of 6 / (4096 / size) m² scatters by a sixth of its area about its centre.
    patch = K**2 * (6 * size / 4096) / 6
    assert built < 0.3 * at_random
    assert built < 1.6 * patch


def test_walls_are_told_apart() -> None:
    """With one sixteenth of the samples in a cluster hardly any holds two opposite walls."""
    position, normal = box_points(4096)
    groups = normal[order_of(position, normal)].reshape(16, 256, 3)
    opposite = (groups.min(axis=1) < -0.5) & (groups.max(axis=1) > 0.5)
    assert not opposite.any()


@pytest.mark.parametrize("by", ["position", "normal"])
def test_two_groups_part_at_the_first_split(by: str) -> None:
    rng = np.random.default_rng(3)
    n = 256
    group = rng.permutation(np.arange(n) % 2)
    position = rng.uniform(0, 0.1, (n, 3)).astype(np.float32)
    normal = np.tile(np.float32([0, 0, 1]), (n, 1))
    if by == "position":
        position[:, 1] += 5 * group
    else:
        normal[group == 1] = (0, 0, -1)
    halves = group[build_order(position, normal, 5.0, K)].reshape(2, -1)
    assert (halves == halves[:, :1]).all()
    assert halves[0, 0] != halves[1, 0]


@pytest.mark.parametrize("n", [4, 64, 1024])
@pytest.mark.parametrize("shape", ["one point", "a line", "a thousand copies", "far and near"])
def test_degenerate_points(shape: str, n: int) -> None:
    position = np.zeros((n, 3), np.float32)
    normal = np.tile(np.float32([0, 1, 0]), (n, 1))
    if shape == "a line":
        position[:, 0] = np.random.default_rng(1).permutation(n)
    elif shape == "a thousand copies":
        position[n // 2 :] = 1
    elif shape == "far and near":
        position[:, 0] = 10.0 ** np.linspace(-6, 6, n)
    order = build_order(position, normal, 1.0, K)
    np.testing.assert_array_equal(np.sort(order), np.arange(n))
    if shape == "a line":
        # A line is cut into intervals.
        groups = np.sort(position[order, 0].reshape(4, -1), axis=1)
        assert (groups[:, -1] - groups[:, 0] == n // 4 - 1).all()
    clusters = describe_clusters(position[order], normal[order], np.full(n, 0.1, np.float32))
    assert all(np.isfinite(field).all() for field in clusters)


def test_clusters_say_what_they_hold() -> None:
    position, normal = box_points(256)
    order = order_of(position, normal)
    position, normal = position[order], normal[order]
    area = np.random.default_rng(9).uniform(0.1, 1, 256).astype(np.float32)
    clusters = describe_clusters(position, normal, area)
    assert clusters.depth == 4
    assert len(clusters.centre) == level_start(5) == 341
    for level in range(5):
        for j in range(4**level):
            c, run = level_start(level) + j, slice(j * 256 // 4**level, (j + 1) * 256 // 4**level)
            p, n = position[run].astype(np.float64), normal[run].astype(np.float64)
            np.testing.assert_allclose(clusters.centre[c], p.mean(axis=0), atol=1e-6)
            extent = np.linalg.norm(np.ptp(p, axis=0)) / 2
            assert clusters.radius[c] == pytest.approx(extent, abs=1e-6)
            assert np.linalg.norm(clusters.axis[c]) == pytest.approx(1, abs=1e-5)
            assert clusters.spread[c] == pytest.approx((n @ clusters.axis[c]).min(), abs=1e-5)
            assert clusters.area[c] == pytest.approx(area[run].sum(), rel=1e-5)
            assert clusters.uneven[c] == pytest.approx(area[run].max() / area[run].mean())


def test_opposite_normals_still_have_an_axis() -> None:
    normal = np.float32([[0, 0, 1], [0, 0, -1], [0, 0, 1], [0, 0, -1]])
    clusters = describe_clusters(np.zeros((4, 3), np.float32), normal, np.ones(4, np.float32))
    np.testing.assert_allclose(np.linalg.norm(clusters.axis, axis=1), 1)
    assert clusters.spread[0] == -1
