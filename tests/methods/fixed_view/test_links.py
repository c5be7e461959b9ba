"""Form factors of the links against closed forms and against the light that rays find."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from methods.fixed_view.gather_matrix import dense_rows, links_of, square, unpacked
from methods.scenes import camera, cornell, rectangle, scene, white_room

from engine.methods.fixed_view.cloud import GatherCloud, build_cloud
from engine.methods.fixed_view.gather import HEMISPHERE, SURE, Job, cosine_lobes, gather_chunk
from engine.methods.fixed_view.hierarchy import level_start
from engine.methods.fixed_view.links import closure, hide
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.view import View
from engine.numerics.haar import forward
from engine.scene.scene import Scene


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
    a = samples.clusters.area[-1]
    plain = offset[..., 2] ** 2 / d2 * a / (d2 + a / np.pi)
    np.testing.assert_allclose(rows.sum(axis=1), plain.sum(axis=1), rtol=0.02)
    error = np.linalg.norm(rows - plain) / np.linalg.norm(plain)
    assert error < 0.1


def test_rows_of_the_cornell_box_sum_to_what_rays_hit():
    """F times a furnace of radiance 1, over π, is the share of cosine-weighted rays that hit."""
    box = cornell(32)
    view = View(box)
    cloud = build_cloud(box, view.buffer.centre, 4096, 6.0, "uniform", 1)
    points = view.buffer.centre
    # Away from corners: whoever has a wall at right angles within 10 cm is left out.
    rng = np.random.default_rng(5)
    open_space = away_from_corners(box, points, 0.1)
    chosen = rng.permutation(np.flatnonzero(open_space))[:64]
    found = row_sums(box, points.position[chosen], points.geometric[chosen], cloud)
    expected, error = hit_share(box, points.take(chosen), 4096)
    assert error.max() < 0.01
    off = found - expected
    # What is off by less than SURE is left so, and what it is put right by is as uncertain.
    assert np.abs(off).max() < 0.075
    assert np.sqrt(np.mean(off**2)) < 0.024
    assert abs(off.mean()) < 0.012


def row_sums(
    where: Scene, position: np.ndarray, normal: np.ndarray, cloud: GatherCloud, count: int = 0
) -> np.ndarray:
    """(64,) share of its hemisphere that each of 64 points gathers from, as rows are stored."""
    n = len(cloud)
    position, normal = (np.ascontiguousarray(a, np.float32) for a in (position, normal))
    job = Job(
        positions=where.geometry.positions,
        triangles=where.geometry.triangles,
        tiles=np.arange(64, dtype=np.int32)[None],
        position=position,
        normal=normal,
        geometric=normal,
        leaf_position=cloud.points.position,
        leaf_geometric=cloud.points.geometric,
        clusters=cloud.clusters,
        importance=np.ones(n, np.float32),
        lobes=cosine_lobes(normal),
        count=count,
        link_size=0.05,
        patch_size=0.5,
        coefficients=n,
        environment_coefficients=n,
        seed=1,
        rays=where.rays,
    )
    made = gather_chunk(job, 0)
    # The Haar coefficients of a constant are its scaling alone.
    scaling = forward(np.ones((n, 1), np.float32))[0, 0]
    rows = unpacked(PackedRows(*(made[name] for name in PackedRows._fields)), n)
    return rows[:, 0] * scaling / np.pi


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


# The sums of rows


class Rows(NamedTuple):
    """The first arguments of `closure`, by hand: see `hand_made`."""

    first: np.ndarray
    cluster: np.ndarray
    weight: np.ndarray


DEPTH = 3


def hand_made(*totals: float) -> Rows:
    """Rows over 64 samples that sum to π times `totals`.

    Each has a patch of 16 samples, a hidden one, and one of a single sample.
    """
    of = [np.array([t / 2 / 16, 0, t / 2]) * np.pi for t in totals]
    n = len(totals)
    return Rows(
        first=np.arange(n + 1, dtype=np.int32) * 3,
        cluster=np.tile([level_start(1) + 2, level_start(1) + 1, level_start(3) + 17], n),
        weight=np.concatenate(of).astype(np.float32),
    )


@pytest.mark.parametrize(
    ("closed", "before", "after"),
    [
        # Off by less than the rays can tell: left as it is.
        (0.5, 0.48, 0.48),
        (0.5, 0.52, 0.52),
        (1.0, 0.98, 0.98),
        # Off by more: put right up to what the rays cannot tell.
        (0.5, 0.3, 0.47),
        (0.5, 0.9, 0.53),
        (0.0, 0.4, 0.03),
        (1.0, 1.4, 1.03),
        # Where every ray hits there is no doubt that the hemisphere is closed.
        (1.0, 0.6, 1.0),
        # What is hardly sampled at all is not blown up without end.
        (0.9, 0.1, 0.4),
        (1.0, 0.0, 0.0),
    ],
)
def test_a_row_is_put_right_as_far_as_rays_tell(closed: float, before: float, after: float):
    rows = hand_made(0.7, before, 0.7)
    weight = rows.weight.copy()
    closure(*rows, DEPTH, np.array([0.7, closed, 0.7]), 0.03)
    found = weight_sums(rows)
    np.testing.assert_allclose(found, [0.7, after, 0.7], rtol=1e-6)
    # Its neighbours keep their bytes, and within it every patch its share.
    np.testing.assert_array_equal(rows.weight[[0, 1, 2, 6, 7, 8]], weight[[0, 1, 2, 6, 7, 8]])
    factor = after / before if before else 1
    np.testing.assert_allclose(rows.weight[3:6], factor * weight[3:6], rtol=1e-6)
    if after == before:
        np.testing.assert_array_equal(rows.weight, weight)


def test_a_blocked_ray_hides_the_patches_of_its_link():
    weight = np.arange(1, 8, dtype=np.float32)
    link = np.array([0, 0, 1, 2, 2, 2, 9], np.int32)
    hide(np.array([0, 3, 6], np.int32), link, weight, np.array([True, False, True]))
    # The last lies beyond what the rows own.
    assert weight.tolist() == [0, 0, 3, 0, 0, 0, 7]


def weight_sums(rows: Rows) -> np.ndarray:
    """(b,) share of its hemisphere that each row of `hand_made` gathers from."""
    return rows.weight.reshape(-1, 3).astype(float) @ [16, 0, 1] / np.pi


STEP = 0.51 * (1 + SURE) / 127  # a row's sum is stored in 127 steps of the greatest of a tile


BOTH_WAYS = pytest.mark.parametrize("count", [0, 64], ids=["links", "rays"])


@BOTH_WAYS
@pytest.mark.parametrize("samples", [256, 4096])
def test_every_row_of_a_closed_room_sums_to_one(samples: int, count: int):
    """With 256 samples three of four rows by links are put right, one by 0.65; rays need not be."""
    room = white_room(0.5, [], 8)
    points = View(room).buffer.centre
    cloud = build_cloud(room, points, samples, 6.0, "uniform", 1)
    sums = row_sums(room, points.position, points.geometric, cloud, count)
    assert np.abs(sums - 1).max() < (STEP if count else SURE + STEP)


@BOTH_WAYS
def test_every_row_in_a_narrow_slot_sums_to_one(count: int):
    """Under a block that hovers 5 cm above the floor samples are sparse and half hidden."""
    block = {
        "name": "block",
        "mesh": {"shape": "box", "size": [0.8, 0.5, 0.8]},
        "transform": {"translate": [0, -0.7, 0]},
    }
    room = scene(
        camera=camera(8, position=[0.07, 0.04, 0.9], target=[-0.03, 0.01, 0]),
        objects=[{"name": "room", "mesh": {"shape": "box", "size": [2, 2, 2]}}, block],
    )
    cloud = build_cloud(room, View(room).buffer.centre, 4096, 6.0, "uniform", 1)
    rng = np.random.default_rng(1)
    x, z = rng.uniform(-0.3, 0.3, (2, 64))
    floor = np.column_stack([x, 0 * x - 1, z])
    found = row_sums(room, floor, np.tile([0, 1, 0], (64, 1)), cloud, count)
    assert np.abs(found - 1).max() < SURE + STEP
    # Most gather too little by themselves, and are put right to the last.
    assert np.mean(np.abs(found - 1) < STEP) > 0.7


def test_a_point_that_looks_half_out_of_an_open_box_keeps_half():
    """In the plane of the opening, seen along it, just half of a hemisphere is closed."""
    walls = [
        rectangle("back", [2, 2], [0, 0, -2]),
        rectangle("left", [2, 2], [-1, 0, -1], [0, 90, 0]),
        rectangle("right", [2, 2], [1, 0, -1], [0, -90, 0]),
        rectangle("floor", [2, 2], [0, -1, -1], [-90, 0, 0]),
        rectangle("ceiling", [2, 2], [0, 1, -1], [90, 0, 0]),
    ]
    box = scene(camera=camera(16, position=[0, 0, 3]), objects=walls)
    angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    sideways = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    position = sideways * np.linspace(-0.9, 0.5, 64)[:, None]
    # A cloud so small that by itself it gives one point 0.37.
    cloud = build_cloud(box, View(box).buffer.centre, 64, 6.0, "uniform", 1)
    found = row_sums(box, position, sideways, cloud)
    # Two of 64 rays more or less than half may hit.
    assert np.abs(found - 0.5).max() < SURE + 2 / HEMISPHERE
    assert found.mean() == pytest.approx(0.5, abs=SURE)
