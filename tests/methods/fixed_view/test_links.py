"""Form factors of the links against closed forms and against the light that rays find."""

from __future__ import annotations

import numpy as np
import pytest
from methods.fixed_view.gather_matrix import dense_rows, links_of, square
from methods.scenes import cornell

from engine.methods.fixed_view.cloud import build_cloud
from engine.methods.fixed_view.gather import Job, gather_chunk
from engine.methods.fixed_view.view import View
from engine.numerics.haar import forward


def parallel(a: float, b: float, c: float) -> float:
    """Form factor of a differential area to a parallel rectangle a x b at distance c, one of whose
    corners is straight above it."""
    x, y = a / c, b / c
    return (
        x / np.sqrt(1 + x * x) * np.arctan(y / np.sqrt(1 + x * x))
        + y / np.sqrt(1 + y * y) * np.arctan(x / np.sqrt(1 + y * y))
    ) / (2 * np.pi)


def perpendicular(a: float, b: float, c: float) -> float:
    """Form factor of a differential area to a rectangle at a right angle to it.

    The rectangle stands on the plane of the area, b wide and a high, c away, one of its lower
    corners straight before the area.
    """
    return (np.arctan(b / c) - c / np.hypot(a, c) * np.arctan(b / np.hypot(a, c))) / (2 * np.pi)


@pytest.mark.parametrize("distance", [0.3, 1.0, 4.0])
def test_point_under_a_parallel_square(distance: float):
    """A unit square above the origin, of which a quarter has its corner there."""
    samples = square(32, (0, 0, distance), (0.5, 0, 0), (0, 0.5, 0), (0, 0, -1))
    room, count = links_of([[0, 0, 0]], [[0, 0, 1]], samples)
    rows = dense_rows(room, np.zeros(count, bool), samples)
    assert rows.sum() / np.pi == pytest.approx(4 * parallel(0.5, 0.5, distance), rel=0.02)


@pytest.mark.parametrize("distance", [0.3, 1.0, 4.0])
def test_point_before_a_perpendicular_square(distance: float):
    samples = square(32, (distance, 0, 0.5), (0, 0.5, 0), (0, 0, 0.5), (-1, 0, 0))
    room, count = links_of([[0, 0, 0]], [[0, 0, 1]], samples)
    rows = dense_rows(room, np.zeros(count, bool), samples)
    expected = 2 * perpendicular(1, 0.5, distance)
    # From afar the whole square is one patch, whose lower half counts as much as its upper one.
    assert rows.sum() / np.pi == pytest.approx(expected, rel=0.05 if distance > 2 else 0.02)


@pytest.mark.parametrize("facing", ["below the horizon", "turned away"])
def test_what_cannot_be_seen_has_no_links(facing: str):
    turned = 1 if facing == "turned away" else -1
    height = -1 if facing == "below the horizon" else 1
    samples = square(16, (0, 0, height), (0.5, 0, 0), (0, 0.5, 0), (0, 0, turned * height))
    room, count = links_of([[0, 0, 0]], [[0, 0, 1]], samples)
    assert count == 0
    assert room.first.tolist() == [0, 0]


def test_a_square_around_the_point_stays_below_pi():
    """The disk in the formula bounds a form factor however near the sample is."""
    samples = square(16, (0, 0, 1e-5), (0.5, 0, 0), (0, 0.5, 0), (0, 0, -1))
    points = samples.position * np.float32([1, 1, 0])
    room, count = links_of(points[:64], np.tile([0, 0, 1], (64, 1)), samples)
    rows = dense_rows(room, np.zeros(count, bool), samples)
    assert np.isfinite(rows).all()
    assert rows.max() <= np.pi * (1 + 1e-5)
    np.testing.assert_allclose(rows.max(axis=1), np.pi, rtol=1e-3)


def test_a_point_among_the_samples_is_finite():
    samples = square(16, (0, 0, 0), (0.5, 0, 0), (0, 0.5, 0), (0, 0, 1))
    room, count = links_of(samples.position[:64], samples.normal[:64], samples)
    assert np.isfinite(room.weight).all()
    # A flat piece of surface sends itself no light.
    assert dense_rows(room, np.zeros(count, bool), samples).sum() == pytest.approx(0, abs=1e-3)


def test_finer_links_and_patches_change_little():
    """Patches of half their distance agree with the sum over single samples."""
    samples = square(32, (0, 0, 0.5), (0.5, 0, 0), (0, 0.5, 0), (0, 0, -1))
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.uniform(-0.5, 0.5, (64, 2)), np.zeros(64)])
    normals = np.tile([0.0, 0, 1], (64, 1))
    room, count = links_of(points, normals, samples)
    rows = dense_rows(room, np.zeros(count, bool), samples)
    offset = samples.position[None].astype(float) - points[:, None]
    d2 = (offset**2).sum(axis=2)
    a = samples.clusters.area
    plain = offset[..., 2] ** 2 / d2 * a / (d2 + a / np.pi)
    np.testing.assert_allclose(rows.sum(axis=1), plain.sum(axis=1), rtol=0.02)
    error = np.linalg.norm(rows - plain) / np.linalg.norm(plain)
    assert error < 0.1


def test_rows_of_the_cornell_box_sum_to_what_rays_hit():
    """F times a furnace of radiance 1, over π, is the share of cosine-weighted rays that hit."""
    box = cornell(32)
    view = View(box)
    cloud = build_cloud(box, view.buffer.centre, 4096, 6.0, 1)
    points = view.buffer.centre
    # Away from corners: whoever has a wall at right angles within 10 cm is left out.
    rng = np.random.default_rng(5)
    open_space = away_from_corners(box, points, 0.1)
    chosen = rng.permutation(np.flatnonzero(open_space))[:64]
    job = Job(
        positions=box.geometry.positions,
        triangles=box.geometry.triangles,
        tiles=chosen.astype(np.int32)[None],
        position=points.position,
        normal=points.normal,
        geometric=points.geometric,
        leaf_position=cloud.points.position,
        leaf_geometric=cloud.points.geometric,
        clusters=cloud.clusters,
        importance=np.ones(4096, np.float32),
        link_size=0.05,
        patch_size=0.5,
        coefficients=4096,
        seed=1,
        rays=box.rays,
    )
    made = gather_chunk(job, 0)
    # The Haar coefficients of a constant are its scaling alone.
    scaling = forward(np.ones((4096, 1), np.float32))[0, 0]
    (k,) = np.flatnonzero(made["ids"] == 0)
    found = made["steps"][k] * made["scale"][k] * scaling / np.pi
    expected, error = hit_share(box, points.take(chosen), 4096)
    assert error.max() < 0.01
    off = found - expected
    # One point has a few hundred links, each with one yes-or-no ray.
    assert np.abs(off).max() < 0.12
    assert np.sqrt(np.mean(off**2)) < 0.035
    assert abs(off.mean()) < 0.015


def away_from_corners(box, points, distance: float) -> np.ndarray:
    """(n,) bool: points whose rays to the sides meet nothing within `distance`."""
    free = points.model >= 0
    rng = np.random.default_rng(0)
    for _ in range(24):
        d = rng.normal(size=points.position.shape)
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        d *= np.sign(np.einsum("ij,ij->i", d, points.geometric))[:, None]
        start = points.position + 1e-4 * points.geometric
        free &= ~box.rays.occluded(start, np.ascontiguousarray(d, np.float32), distance)
    return free


def hit_share(box, points, rays: int) -> tuple[np.ndarray, np.ndarray]:
    """(n,) share of cosine-weighted rays that hit something, and its standard error."""
    rng = np.random.default_rng(2)
    n = len(points)
    d = rng.normal(size=(n, rays, 3))
    d /= np.linalg.norm(d, axis=2, keepdims=True)
    d = d * 0.9999 + points.geometric[:, None]
    start = np.repeat(points.position + 1e-4 * points.geometric, rays, axis=0)
    hit = box.rays.occluded(start, np.ascontiguousarray(d.reshape(-1, 3), np.float32))
    share = hit.reshape(n, rays).mean(axis=1)
    return share, np.sqrt(share * (1 - share) / rays)
