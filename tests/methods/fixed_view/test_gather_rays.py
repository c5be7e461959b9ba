"""Rows by rays: where they land, what they weigh, and that they tell form factors."""

from __future__ import annotations

import numpy as np
import pytest
from methods.fixed_view.gather_matrix import Cloud, job, square, unpacked
from methods.fixed_view.test_links import parallel
from methods.scenes import camera, rectangle, scene
from numba import njit

from engine.brdf import albedo, evaluate
from engine.brdf.ggx import Ggx
from engine.brdf.table import INDEX
from engine.methods.fixed_view.cloud import Spread, build_cloud
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.gather import (
    HEMISPHERE,
    SURE,
    Lobes,
    _Rays,
    cosine_lobes,
    gather_chunk,
)
from engine.methods.fixed_view.gather_rays import aim, settle
from engine.methods.fixed_view.hierarchy import level_start
from engine.methods.fixed_view.nearest import Grid, build_grid, nearest
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.sides import cosine_rays, evenly_chosen, sides_met
from engine.methods.fixed_view.surface_points import describe
from engine.methods.fixed_view.view import View
from engine.numerics.haar import inverse
from engine.numerics.vec import vec
from engine.scene.scene import Scene


@njit
def nearest_of(grid, places, normals, out):
    for i in range(len(out)):
        out[i] = nearest(grid, vec(places, i), vec(normals, i))


def found_in(grid: Grid, places: np.ndarray, normals: np.ndarray) -> np.ndarray:
    out = np.zeros(len(places), np.int64)
    nearest_of(grid, places, normals, out)
    return out


def unit(rng: np.random.Generator, n: int) -> np.ndarray:
    v = rng.normal(size=(n, 3))
    return (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)


def shoot(points: np.ndarray, normals: np.ndarray, lobes: Lobes, count: int) -> tuple:
    """(origin, direction, first, weight) of `aim` from points (b, 3)."""
    n = len(points)
    origin, direction = np.zeros((2, n * count, 3), np.float32)
    first, weight = np.zeros(n + 1, np.int32), np.zeros(n * count, np.float32)
    norm = np.zeros(n)
    rays = aim(
        np.arange(n, dtype=np.int32), points, normals, normals, *lobes, 1e-4, 1, count, origin,
        direction, first, weight, norm,
    )  # fmt: skip
    assert rays == first[-1]
    return origin[:rays], direction[:rays], first, weight[:rays]


@pytest.mark.parametrize("flat", [False, True], ids=["ball", "wall"])
def test_the_nearest_is_the_nearest_of_all(flat: bool):
    """By brute force, for places among the samples and far outside of their box."""
    rng = np.random.default_rng(3)
    normal = unit(rng, 1024)
    position = normal + 0.0
    if flat:
        position = rng.uniform(-1, 1, (1024, 3)).astype(np.float32)
        position[:, 2] = 0
        normal = np.tile(np.float32([0, 0, 1]), (1024, 1))
    spacing = rng.uniform(0.05, 0.2, 1024).astype(np.float32)
    grid = build_grid(position, normal, spacing**2)
    places = rng.uniform(-1, 1, (500, 3)).astype(np.float32)
    places[400:] *= 20
    facing = unit(rng, 500)
    found = found_in(grid, places, facing)
    away = ((position[None] - places[:, None]) ** 2).sum(axis=2, dtype=float)
    away += spacing**2 * ((normal[None] - facing[:, None]) ** 2).sum(axis=2, dtype=float)
    mine = np.take_along_axis(away, found[:, None], axis=1)[:, 0]
    np.testing.assert_allclose(mine, away.min(axis=1), rtol=1e-5)


def test_each_side_of_a_sheet_finds_its_own_samples():
    rng = np.random.default_rng(4)
    position = rng.uniform(-1, 1, (2048, 3)).astype(np.float32)
    position[:, 2] = 0
    normal = np.zeros((2048, 3), np.float32)
    normal[:, 2] = np.where(np.arange(2048) < 1024, 1, -1)
    grid = build_grid(position, normal, np.full(2048, 4 / 1024, np.float32))
    places = rng.uniform(-0.9, 0.9, (300, 3)).astype(np.float32)
    places[:, 2] = 0
    for side in (1, -1):
        facing = np.tile(np.float32([0, 0, side]), (300, 1))
        assert (normal[found_in(grid, places, facing), 2] == side).all()


def test_rays_of_a_hemisphere_tell_its_closed_share_to_what_is_said():
    """A plane through the point leaves (1 + cos t) / 2 of the cosine-weighted hemisphere."""
    rng = np.random.default_rng(7)
    n = 512
    normal, beyond = unit(rng, n), unit(rng, n)
    position = rng.uniform(-1, 1, (n, 3)).astype(np.float32)
    origin, direction, first, weight = shoot(position, normal, cosine_lobes(normal), HEMISPHERE)
    assert (np.diff(first) == HEMISPHERE).all()
    np.testing.assert_allclose(weight, np.pi / HEMISPHERE, rtol=1e-6)
    rays = direction.reshape(n, HEMISPHERE, 3).astype(float)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=2), 1, atol=1e-5)
    assert (np.einsum("nkc,nc->nk", rays, normal) > 0).all()
    np.testing.assert_allclose(
        origin.reshape(n, HEMISPHERE, 3)[:, 5], position + 1e-4 * normal, atol=1e-6
    )
    found = (np.einsum("nkc,nc->nk", rays, beyond) > 0).mean(axis=1)
    off = found - (1 + np.einsum("nc,nc->n", normal, beyond)) / 2
    error = np.sqrt(np.mean(off**2))
    assert error <= SURE
    # It is not far less either: the allowance of the links would be too wide then.
    assert error > SURE / 3
    assert abs(off.mean()) < 4 * SURE / np.sqrt(n)


@pytest.mark.parametrize("distance", [0.1, 0.5, 2.0])
def test_point_under_a_square(distance: float):
    """What rays with their weights see of a square of side 2, against its form factor."""
    box: Scene = scene(
        camera=camera(8), objects=[rectangle("square", [2, 2], [0, 0, distance], [0, 180, 0])]
    )
    points = np.zeros((16, 3), np.float32)
    up = np.tile(np.float32([0, 0, 1]), (16, 1))
    origin, direction, first, weight = shoot(points, up, cosine_lobes(up), 377)
    hit = box.rays.occluded(origin, direction)
    seen = np.add.reduceat(weight * hit, first[:-1]) / np.pi
    # Four quarters of the square, each with a corner over the point.
    assert seen.mean() == pytest.approx(4 * parallel(1, 1, distance), abs=0.003)
    assert np.abs(seen - seen.mean()).max() < 0.015


@pytest.mark.parametrize("tilt", [0.0, 60.0])
def test_rays_of_a_lobe_reflect_what_the_lobe_reflects(tilt: float):
    """Half the world is lit: rays of one row tell its reflected light to that of the BRDF."""
    n, count = 32, 377
    material = Ggx(diffuse=(0, 0, 0), specular=(0.6, 0.6, 0.6), roughness=0.5)
    up = np.tile(np.float32([0, 0, 1]), (n, 1))
    angle = np.radians(tilt)
    wo = np.tile(np.float32([np.sin(angle), 0, np.cos(angle)]), (n, 1))
    row = np.tile(material.row(), (n, 1))
    lobes = Lobes(wo, np.full(n, INDEX[Ggx], np.int32), row)
    points = np.zeros((n, 3), np.float32)
    _, direction, first, weight = shoot(points, up, lobes, count)
    np.testing.assert_allclose(np.add.reduceat(weight, first[:-1]), np.pi, rtol=1e-5)
    # By brute force over the hemisphere: what falls in from x < 0, over all.
    rng = np.random.default_rng(5)
    wi = unit(rng, 400000).astype(float)
    wi[:, 2] = np.abs(wi[:, 2])
    f = evaluate(INDEX[Ggx], material.row(), wi, wo[0].astype(float))[:, 0] * wi[:, 2] * 2 * np.pi
    assert f.mean() == pytest.approx(
        albedo(INDEX[Ggx], material.row(), wo[0].astype(float))[0, 0], rel=0.02
    )
    expected = (f * (wi[:, 0] < -0.2)).mean() / f.mean()
    seen = np.add.reduceat(weight * (direction[:, 0] < -0.2), first[:-1]) / np.pi
    assert seen.mean() == pytest.approx(expected, abs=0.01)


def test_what_is_no_point_has_no_rays():
    up = np.tile(np.float32([0, 0, 1]), (4, 1))
    origin, direction = np.zeros((2, 4 * 16, 3), np.float32)
    first, weight = np.zeros(5, np.int32), np.zeros(64, np.float32)
    rays = aim(
        np.array([0, -1, 2, -1], np.int32), up, up, up, *cosine_lobes(up), 1e-4, 1, 16, origin,
        direction, first, weight, np.zeros(4),
    )  # fmt: skip
    assert rays == 32
    assert first.tolist() == [0, 16, 16, 32, 32]


def test_a_sample_beyond_a_wall_gives_its_share_to_the_others():
    """Rays 0 to 2 belong to one point, 3 to another, 4 and 5 to a third."""
    weight = np.array([1, 1, 1, 2, 3, 1], np.float32)
    triangle = np.array([7, -1, 8, 9, -1, 5], np.int32)
    apart = np.array([True, False, False, True, False, False])
    settle(np.array([0, 3, 4, 6], np.int32), triangle, apart, weight)
    assert weight.tolist() == [0, 0, 2, 0, 0, 1]


def test_rows_know_which_side_of_a_wall_they_look_at():
    """A wall of no thickness between two rooms: no weight on samples of the other room."""
    rooms = scene(
        camera=camera(24, position=[-1.9, 0.1, 0.05], target=[0, 0, 0]),
        objects=[
            {"name": "rooms", "mesh": {"shape": "box", "size": [4, 2, 2]}},
            rectangle("wall", [2, 2], [0, 0, 0], [0, 90, 0]),
        ],
    )
    ceiling = square(32, (0, 1, 0), (2, 0, 0), (0, 0, 1), (0, -1, 0))
    rng = np.random.default_rng(6)
    floor = np.full((64, 3), -1, np.float32)
    floor[:, 0], floor[:, 2] = rng.uniform(-1, -0.02, 64), rng.uniform(-1, 1, 64)
    up = np.tile(np.float32([0, 1, 0]), (64, 1))
    fields = {"positions": rooms.geometry.positions, "triangles": rooms.geometry.triangles}
    made = gather_chunk(job(ceiling, floor, up, rooms.rays, count=377, **fields), 0)
    rows = unpacked(PackedRows(*(made[f] for f in PackedRows._fields)), 1024)
    sees = inverse(np.ascontiguousarray(rows.T, np.float32)).T
    beyond = ceiling.position[:, 0] > 0
    np.testing.assert_allclose(sees.sum(axis=1), np.pi, rtol=0.01)
    # Coefficients are stored in 127 steps, so a little of either sign is left.
    assert np.abs(sees[:, beyond].sum(axis=1)).max() < 0.01 * np.pi


def louvred_room(lit_by: str) -> Scene:
    """A room with deep fins along the back wall, under a glowing panel or a point light.

    The fins stand as far apart as 1,024 gather samples lie, the panel hangs 3 cm under the ceiling.
    """
    panel = {**rectangle("panel", [0.6, 0.6], [0, 0.97, 0.3], [90, 0, 0]), "material": "panel"}
    fin = {"shape": "box", "size": [0.02, 1.6, 0.3]}
    point = {"id": "point", "type": "point", "position": [0.3, 0.5, 0.3], "intensity": [1, 1, 1]}
    return scene(
        camera=camera(24, position=[0.3, -0.2, 0.95], target=[-0.2, -0.8, -0.5], fov_y_degrees=60),
        lights=[point] if lit_by == "point" else [],
        materials={
            "wall": {"type": "diffuse", "diffuse": [0.6] * 3},
            "panel": {"type": "diffuse", "diffuse": [0] * 3, "emission": [4] * 3},
        },
        objects=[
            {"name": "box", "mesh": {"shape": "box", "size": [2, 2, 2]}, "material": "wall"},
            *(
                {
                    "name": f"fin {k}",
                    "mesh": fin,
                    "material": "wall",
                    "transform": {"translate": [-0.9 + 0.14 * k, 0, -0.84]},
                }
                for k in range(14)
            ),
            *([panel] if lit_by == "panel" else []),
        ],
    )


@pytest.mark.parametrize("spread", ["uniform", "importance"])
@pytest.mark.parametrize(("lit_by", "count"), [("panel", 4096), ("point", 1024), ("point", 4096)])
def test_a_ray_finds_the_light_of_where_it_lands(lit_by: str, spread: Spread, count: int):
    """Light of one reflection after that, or of a panel, gathered from a cloud without culling.

    With the nearest sample alone, in sight or not, the panel was 16 % too dark in such a room, for
    samples of the ceiling behind spoke for it, and the point light 6 % too bright: rays into the
    gaps between fins found none in sight, and the light of the open room stood in for theirs.
    """
    room = louvred_room(lit_by)
    view = View(room).buffer.centre
    cloud = build_cloud(room, view, count, 6.0, spread, 1)
    g = cloud.emission.copy()
    for light in room.lights:
        g += light_on_points(room.rays, cloud.points, light)
    samples = Cloud(cloud.points.position, cloud.points.geometric, cloud.clusters)
    work = job(
        samples, view.position, view.normal, room.rays, positions=room.geometry.positions,
        triangles=room.geometry.triangles, count=987,
    )  # fmt: skip
    gather = _Rays(work)
    arriving = 0.0
    for index in work.tiles:
        rows, _, _ = gather(index)
        n = rows.first[-1]
        leaf = rows.cluster[:n] - level_start(cloud.clusters.depth)
        arriving += float(rows.weight[:n] @ g[np.maximum(leaf, 0)].mean(axis=1))
    # The same light without a cloud: what shines on the very places that rays from there hit.
    gathered, true = arriving / np.pi / len(view), light_arriving(room, view)
    assert gathered == pytest.approx(true, rel=0.025)


def light_arriving(room: Scene, view: Points) -> float:
    """Mean over view points and their cosine of the radiance of what they see, by 2^18 rays."""
    points = evenly_chosen(view, 1 << 18)
    origin, direction = np.zeros((2, len(points), 3), np.float32)
    cosine_rays(
        0, len(points), points.position, points.geometric, room.rays.epsilon, 5, origin, direction
    )
    hits = room.rays.intersect(origin, direction)
    back = sides_met(room, hits, direction)[0].astype(np.bool_)
    met = describe(room, hits.triangle, back, np.stack([hits.b1, hits.b2], axis=1))
    radiance = room.material_table.emission[met.material]
    for light in room.lights:
        radiance = radiance + light_on_points(room.rays, met, light)
    return float(radiance.mean())
