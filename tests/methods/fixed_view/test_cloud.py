"""The gather cloud: evenly over all exposed area, on the right sides, whatever the triangles."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from methods.scenes import POINT, camera, cornell, hall, rectangle, scene, white_room
from scipy import stats

from engine.errors import SceneError
from engine.methods.fixed_view.cloud import (
    GatherCloud,
    Spread,
    build_cloud,
    cloud_arrays,
    cloud_from,
)
from engine.methods.fixed_view.facets import facet_at, facet_centres, facets, on_triangles
from engine.methods.fixed_view.frame_buffer import look_at
from engine.methods.fixed_view.sides import exposed_sides, smooth_pieces
from engine.methods.fixed_view.view import View
from engine.methods.fixed_view.view_importance import view_importance
from engine.reference import render
from engine.scene.scene import Scene


def cloud_of(
    scene: Scene, count: int = 1024, seed: int = 1, spread: Spread = "uniform"
) -> GatherCloud:
    return build_cloud(scene, View(scene).buffer.centre, count, 6.0, spread, seed)


def area_of(scene: Scene) -> np.ndarray:
    """(t,) areas of the triangles, m²."""
    a, b, c = np.moveaxis(scene.geometry.positions[scene.geometry.triangles].astype(float), 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def triangle_of(scene: Scene, cloud: GatherCloud) -> np.ndarray:
    """(n,) the triangle that each sample lies on, found by a ray back along its normal."""
    start = cloud.points.position + 1e-3 * cloud.points.geometric
    hits = scene.rays.intersect(start, -cloud.points.geometric)
    np.testing.assert_allclose(hits.distance, 1e-3, atol=1e-4)
    return hits.triangle


def test_samples_fall_by_area():
    """A chi-square test over the triangles; splitting the budget only makes it more even."""
    box = white_room(0.5, [POINT])
    cloud = cloud_of(box, 4096)
    area = area_of(box)
    expected = 4096 * area / area.sum()
    counted = np.bincount(triangle_of(box, cloud), minlength=len(area))
    chi = ((counted - expected) ** 2 / expected).sum()
    assert chi < stats.chi2.isf(1e-3, len(area) - 1)
    assert np.abs(counted - expected).max() < 3
    np.testing.assert_allclose(cloud.area, area.sum() / 4096, rtol=1e-5)


def test_no_samples_under_the_blocks():
    """The floor of the Cornell box goes on under its blocks, where light cannot reach."""
    box = cornell(32)
    cloud = cloud_of(box, 4096)
    floor = cloud.points.position[cloud.points.position[:, 1] < 1e-6]
    up = np.tile(np.array([[0, 1, 0]], np.float32), (len(floor), 1))
    start = np.ascontiguousarray(floor + np.float32(1e-5) * up)
    # Straight up from the open floor there is only the ceiling, at 0.55 m.
    under = box.rays.occluded(start, up, 0.4)
    assert len(floor) > 500
    assert under.mean() < 0.01


def test_samples_fall_evenly_within_a_triangle():
    """Chi-square of the samples of a floor over a grid of 8 x 8 cells."""
    floor = scene(
        camera=camera(position=[0, 2, 0.1]),
        objects=[rectangle("floor", [2, 2], [0, 0, 0], [-90, 0, 0])],
    )
    cloud = cloud_of(floor, 4096)
    counted, _, _ = np.histogram2d(
        cloud.points.position[:, 0], cloud.points.position[:, 2], 8, [[-1, 1], [-1, 1]]
    )
    assert counted.sum() == 4096
    chi = ((counted - 64) ** 2 / 64).sum()
    assert chi < stats.chi2.isf(1e-3, 63)


def test_normals_point_to_where_the_light_is():
    """Every normal of a closed room points inwards, whatever the order of corners."""
    box = cornell(32)
    cloud = cloud_of(box, 1024)
    inside = np.float32([0.278, 0.2744, 0.2796])
    wall = np.isin(
        cloud.points.object,
        [box.object_names.index(n) for n in ("floor", "ceiling", "back wall", "right wall")],
    )
    toward = np.einsum("ij,ij->i", inside - cloud.points.position, cloud.points.normal)
    assert wall.sum() > 500
    assert (toward[wall] > 0).all()
    np.testing.assert_allclose(np.linalg.norm(cloud.points.normal, axis=1), 1, atol=1e-5)


@pytest.mark.parametrize("inverted", [False, True])
def test_nothing_inside_a_closed_box(inverted: bool):
    """Also where its triangles are wound the wrong way round."""
    corners = box_corners((0.5, 0.25, 1.0))
    box = scene(
        camera=camera(position=[2, 2, 3], fov_y_degrees=40),
        objects=[
            {
                "name": "box",
                "mesh": {
                    "shape": "polygons",
                    "polygons": [c[::-1] for c in corners] if inverted else corners,
                },
            },
            {"name": "room", "mesh": {"shape": "box", "size": [8, 8, 8]}},
        ],
    )
    sides = exposed_sides(box, View(box).buffer.centre, 1)
    assert sides[:12].tolist() == [[not inverted, inverted]] * 12
    points = cloud_of(box, 4096).points
    on_box = points.object == 0
    outward = points.position[on_box] / np.float32([0.5, 0.25, 1])
    # 7 m² of box in 391.
    assert abs(on_box.sum() - 4096 * 7 / 391) < 8
    assert (np.einsum("ij,ij->i", outward, points.normal[on_box]) > 0.9).all()


def test_what_no_light_reaches_has_samples_on_its_front():
    """Of a lone convex body, which sends itself no light."""
    ball = scene(
        camera=camera(position=[0, 0, 3]),
        objects=[{"name": "ball", "mesh": {"shape": "sphere", "rings": 8}}],
    )
    points = cloud_of(ball, 256).points
    assert (np.einsum("ij,ij->i", points.position, points.normal) > 0.4).all()


def box_corners(half: tuple[float, float, float]) -> list[list[list[float]]]:
    """Six polygons, counter-clockwise seen from outside."""
    faces = []
    for axis in range(3):
        for side in (-1, 1):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            corners = np.zeros((4, 3))
            corners[:, axis] = side
            corners[:, u], corners[:, v] = (-1, 1, 1, -1), (-1, -1, 1, 1)
            faces.append((corners[::side] * half).tolist())
    return faces


def thin_sheet() -> Scene:
    """A sheet that hangs in a room and splits it nearly in two, light on both sides."""
    return scene(
        camera=camera(position=[0.9, 0, 0.9]),
        objects=[
            {"name": "room", "mesh": {"shape": "box", "size": [2, 2, 2]}},
            rectangle("sheet", [1, 1], [0, 0, 0]),
        ],
    )


def test_a_thin_sheet_has_samples_on_both_sides():
    sheet = thin_sheet()
    cloud = cloud_of(sheet, 4096)
    mine = cloud.points.object == sheet.object_names.index("sheet")
    front = mine & (cloud.points.normal[:, 2] > 0.5)
    back = mine & (cloud.points.normal[:, 2] < -0.5)
    assert (front | back).sum() == mine.sum()
    # Of 24 m² of room and 2 m² of sheet each side of the sheet gets its share.
    for side in (front, back):
        assert abs(side.sum() - 4096 / 26) < 8


def test_hardly_a_sample_in_a_narrow_slot():
    """What lies behind a picture on the wall is dark and sends nothing to the room."""
    slot = 0.015
    hung = scene(
        camera=camera(position=[0, 0, 0.9]),
        objects=[
            {"name": "room", "mesh": {"shape": "box", "size": [2, 2, 2]}},
            rectangle("picture", [1.6, 1.6], [0, 0, slot - 1]),
        ],
    )
    points = cloud_of(hung, 4096).points
    x, y, z = points.position.T
    deep = (np.abs(x) < 0.65) & (np.abs(y) < 0.65) & (z < slot / 2 - 1)
    behind = (
        (np.abs(x) < 0.65) & (np.abs(y) < 0.65) & (z < 2 * slot - 1) & (points.normal[:, 2] < -0.5)
    )
    # By area it would be 3.4 of 29 m², 480 samples.
    assert (deep | behind).sum() < 15


def test_a_million_to_one():
    """Triangles of 1 mm² and of 1 m² beside each other: the small ones get what they are worth."""
    small = 1e-3
    mixed = scene(
        camera=camera(position=[0, 2, 0.1]),
        objects=[
            rectangle("large", [1, 1], [0, 0, 0], [-90, 0, 0]),
            *(
                rectangle(f"small {k}", [small, small], [0.6 + 0.01 * k, 0.1, 0], [-90, 0, 0])
                for k in range(20)
            ),
        ],
    )
    cloud = cloud_of(mixed, 4096)
    assert np.isfinite(cloud.points.position).all()
    on_large = cloud.points.object == 0
    # The small ones together are worth a twelfth of a sample.
    assert on_large.sum() >= 4095
    np.testing.assert_allclose(cloud.area, (1 + 20 * small**2) / 4096, rtol=1e-5)


def test_one_triangle():
    lone = scene(
        camera=camera(position=[0.3, 0.3, 2], target=[0.3, 0.3, 0]),
        objects=[
            {
                "name": "triangle",
                "mesh": {"shape": "polygons", "polygons": [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]},
            }
        ],
    )
    cloud = cloud_of(lone, 256)
    p = cloud.points.position
    assert p.min() >= 0
    assert (p[:, 0] + p[:, 1]).max() <= 1 + 1e-6
    assert not p[:, 2].any()
    # Each quarter of the triangle has a quarter of the samples.
    corner = (p[:, 0] + p[:, 1] < 0.5).sum()
    assert abs(corner - 64) < 8
    np.testing.assert_allclose(cloud.area, 0.5 / 256, rtol=1e-6)


def test_a_camera_that_sees_nothing_still_has_a_cloud():
    away = scene(
        camera=camera(position=[0, 0, 3], target=[0, 0, 6]),
        objects=[{"name": "box", "mesh": {"shape": "box"}}],
    )
    cloud = cloud_of(away, 256)
    assert len(cloud) == 256
    assert np.isfinite(cloud.points.position).all()


def test_same_seed_same_cloud(monkeypatch: pytest.MonkeyPatch):
    box = cornell(32)
    monkeypatch.setenv("RELIGHT_THREADS", "1")
    one = cloud_arrays(cloud_of(box))
    monkeypatch.setenv("RELIGHT_THREADS", "2")
    two = cloud_arrays(cloud_of(box))
    other = cloud_arrays(cloud_of(box, seed=2))
    assert all(one[name].tobytes() == two[name].tobytes() for name in one)
    assert one["position"].tobytes() != other["position"].tobytes()


def test_survives_being_stored():
    cloud = cloud_of(cornell(32), 256)
    again = cloud_from(cloud_arrays(cloud))
    for a, b in zip(cloud.clusters, again.clusters, strict=True):
        np.testing.assert_array_equal(a, b)
    for name in ("position", "normal", "row", "model", "material"):
        np.testing.assert_array_equal(getattr(cloud.points, name), getattr(again.points, name))


def test_albedo_is_the_material_and_gloss_counts():
    """A diffuse sample has its colour; a glossy one reflects more than its diffuse part."""
    balls = scene(
        camera=camera(position=[0, 0, 4]),
        materials={
            "matt": {"type": "diffuse", "diffuse": [0.2, 0.4, 0.6]},
            "shiny": {
                "type": "ggx",
                "diffuse": [0.2, 0.4, 0.6],
                "specular": [0.3, 0.3, 0.3],
                "roughness": 0.4,
            },
            "glow": {"type": "diffuse", "diffuse": [0, 0, 0], "emission": [1, 2, 3]},
        },
        objects=[
            {
                "name": name,
                "mesh": {"shape": "sphere", "rings": 8},
                "material": name,
                "transform": {"translate": [x, 0, 0]},
            }
            for name, x in (("matt", -1.2), ("shiny", 0), ("glow", 1.2))
        ],
    )
    cloud = cloud_of(balls)
    of = {name: cloud.points.object == k for k, name in enumerate(balls.object_names)}
    np.testing.assert_allclose(cloud.albedo[of["matt"]], [[0.2, 0.4, 0.6]] * of["matt"].sum())
    assert (cloud.albedo[of["shiny"]] > [[0.25, 0.45, 0.6]]).all()
    assert (cloud.albedo[of["shiny"]] < 1).all()
    assert not cloud.albedo[of["glow"]].any()
    np.testing.assert_array_equal(cloud.emission[of["glow"]], [[1, 2, 3]] * of["glow"].sum())
    assert not cloud.emission[~of["glow"]].any()


def test_pieces_are_connected_meshes():
    sheet = thin_sheet()
    piece = smooth_pieces(sheet)
    # Six faces of a box that share no vertices for their normals' sake, and the sheet.
    assert len(np.unique(piece)) == 7
    assert piece[-1] == piece[-2]


def test_no_area_is_said():
    flat = cornell(16)
    geometry = flat.geometry._replace(positions=np.zeros_like(flat.geometry.positions))
    nothing = look_at(flat, flat.camera.directions(np.zeros(1), np.zeros(1)))
    with pytest.raises(SceneError, match="area"):
        build_cloud(replace(flat, geometry=geometry), nothing, 256, 6.0, "uniform", 1)


# Importance


def lamp_in_the_corner() -> dict[str, Any]:
    return {**POINT, "position": [-10.5, 2.2, -10.2]}


def test_facets_cut_triangles_into_equal_parts():
    """They fill the triangle without overlap, and every place finds its own."""
    box = cornell(16)
    sides = np.zeros((len(box.geometry.triangles), 2), np.bool_)
    sides[3, 1] = sides[5, 0] = True
    of = facets(box, sides, float(area_of(box)[[3, 5]].max()) / 40)
    assert of.cuts[3] == 7
    assert len(of.area) == of.cuts[3] ** 2 + of.cuts[5] ** 2
    for k, back in ((3, True), (5, False)):
        mine = of.triangle == k
        assert (of.back[mine] == back).all()
        assert of.area[mine].sum() == pytest.approx(area_of(box)[k])
        edges = of.corner[mine, 1:] - of.corner[mine, :1]
        np.testing.assert_allclose(np.abs(np.linalg.det(edges)), 1 / mine.sum(), rtol=1e-4)
    # Places on facets, as the triangle's coordinates and back again.
    rng = np.random.default_rng(1)
    place = np.sort(rng.uniform(0, 1, (4000, 2)), axis=1).astype(np.float32)
    place[:, 1] -= place[:, 0]
    facet = rng.integers(0, len(of.area), 4000).astype(np.int32)
    there = on_triangles(of, facet, place)
    inside = np.minimum(place.min(axis=1), 1 - place.sum(axis=1)) > 1e-4
    found = facet_at(of, of.triangle[facet], of.back[facet], there)
    np.testing.assert_array_equal(found[inside], facet[inside])
    away = np.zeros(1, np.int32)
    assert facet_at(of, away, np.zeros(1, np.bool_), there[:1]).tolist() == [-1]


def test_whole_sides_are_facets_where_nothing_is_to_be_cut():
    box = cornell(16)
    of = facets(box, np.ones((len(box.geometry.triangles), 2), np.bool_))
    np.testing.assert_allclose(of.area, np.repeat(area_of(box), 2))
    assert of.corner.tolist() == [[[0, 0], [1, 0], [0, 1]]] * len(of.area)
    middle = box.geometry.positions[box.geometry.triangles].mean(axis=1)
    np.testing.assert_allclose(facet_centres(box, of)[::2], middle, atol=1e-6)


def test_importance_is_what_a_light_there_does_to_the_picture():
    """The light of a small glowing panel: transport is the same in both directions.

    Of a room seen by few pixels, importance times area of two walls compares as the picture's light
    does when one or the other wall glows, by the path tracer.
    """
    materials = {name: {"type": "diffuse", "diffuse": [0.5] * 3} for name in ("wall", "a", "b")}
    walls = [
        ("floor", "wall", [2, 2], [0, -1, 0], [-90, 0, 0]),
        ("ceiling", "wall", [2, 2], [0, 1, 0], [90, 0, 0]),
        ("left", "a", [2, 2], [-1, 0, 0], [0, 90, 0]),
        ("right", "b", [2, 2], [1, 0, 0], [0, -90, 0]),
        ("back", "wall", [2, 2], [0, 0, -1], [0, 0, 0]),
        ("front", "wall", [2, 2], [0, 0, 1], [0, 180, 0]),
    ]

    def room(glowing: str) -> Scene:
        shine = {glowing: {**materials[glowing], "emission": [1, 1, 1]}}
        return scene(
            # A part of the floor near the left wall, and nothing of the wall.
            camera=camera(8, position=[0.3, 0.6, 0], target=[-0.5, -1, 0], fov_y_degrees=20),
            materials={**materials, **shine},
            objects=[
                {**rectangle(name, size, at, turn), "material": material}
                for name, material, size, at, turn in walls
            ],
        )

    # Four flights: light that reaches the picture after at most four reflections.
    lit = [float(render(room(wall), samples=8192, max_bounces=4).image.mean()) for wall in "ab"]
    lone = room("a")
    of = facets(lone, np.tile([True, False], (len(lone.geometry.triangles), 1)), 0.01)
    density = view_importance(lone, View(lone).buffer.centre, of, 1) * of.area
    on = lone.geometry.object[of.triangle]
    reached = [density[on == lone.object_names.index(name)].sum() for name in ("left", "right")]
    assert lit[0] > 1.7 * lit[1]
    # The noise of both is below 1 %, and 128 particles blur over some facets.
    assert reached[0] / reached[1] == pytest.approx(lit[0] / lit[1], rel=0.03)


def test_samples_follow_importance_and_stand_for_all_area():
    """Dense where the camera looks, thin at the far end of the hall, and every sum as it was."""
    seen = hall([lamp_in_the_corner()])
    even, steered = cloud_of(seen, 4096), cloud_of(seen, 4096, spread="importance")
    corner = np.float32([-11.5, 0, -11.5])

    def near(cloud: GatherCloud) -> np.ndarray:
        return np.linalg.norm(cloud.points.position - corner, axis=1) < 3

    assert near(steered).sum() > 8 * near(even).sum()
    assert steered.area.max() / steered.area.mean() < 1 / 0.2
    assert steered.area.sum() == pytest.approx(even.area.sum(), rel=0.02)
    # Object by object samples stand for its area, to the noise of their number.
    areas = {"red block": 1.85, "blue block": 1.04, "pillar 6 6": 19.2, "hall": 1716.0}
    for name, size in areas.items():
        mine = steered.points.object == seen.object_names.index(name)
        off = steered.area[mine].sum() / size - 1
        assert abs(off) < 2 / np.sqrt(mine.sum()), f"{name}: {off:.3f} of {mine.sum()} samples"
    # A function that varies over the hall keeps its integral.
    wave = [
        float(c.area @ np.cos(0.3 * c.points.position[:, 0] + c.points.position[:, 2]))
        for c in (even, steered)
    ]
    assert abs(wave[0] - wave[1]) < 0.02 * even.area.sum()


def test_importance_without_a_view_is_even():
    away = scene(
        camera=camera(position=[0, 0, 3], target=[0, 0, 6]),
        objects=[{"name": "box", "mesh": {"shape": "box"}}],
    )
    cloud = cloud_of(away, 256, spread="importance")
    np.testing.assert_allclose(cloud.area, cloud.area[0], rtol=1e-4)
