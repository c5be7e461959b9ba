"""The area light of an environment: its energy wherever it stands, sampling, what it refuses."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from light.lights import illuminate
from light.test_environment import _solid_angles, _sphere, pdf, radiance, sample
from numpy.typing import NDArray

from engine.errors import EditError
from engine.light.cube_disk import covered
from engine.light.cube_light import CubeLight
from engine.light.environment import Environment, EnvironmentDescription
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.light.far_disk import FarDisk, disk_of
from engine.light.lamps import suns
from engine.numerics.cube_map import directions, solid_angles
from engine.scene.edits import edited_environment

PLACES = {
    "pole": (0, 1, 0),
    "other pole": (0, -1, 0),
    "face": (0, 0, -1),
    "edge": (1, 0, 1),
    "corner": (1, 1, 1),
    "anywhere": (0.3, -0.8, 0.1),
    "beside a pole": (1e-6, 1, 0),
}
at_every_place = pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)


def towards(place: tuple[float, float, float], **fields: Any) -> FarDisk:
    return FarDisk(direction=tuple(-c for c in place), **fields)  # type: ignore[arg-type]


def made(light: FarDisk, image: NDArray | None = None, **fields: Any) -> Environment:
    image = np.zeros((1, 1, 3)) if image is None else image
    return Environment(EnvironmentDescription(area_light=light, **fields), np.float32(image))


def unit(v: Any) -> NDArray[np.float64]:
    return np.asarray(v, float) / np.linalg.norm(v)


def solid_angle(radius_degrees: float) -> float:
    return 2 * math.pi * (1 - math.cos(math.radians(radius_degrees)))


@at_every_place
@pytest.mark.parametrize("n", [8, 64])
@pytest.mark.parametrize("radius", [0.25, 1, 10, 45])
def test_a_cube_map_has_all_of_it(place: Any, n: int, radius: float) -> None:
    """Its solid angle to far below 0.1 %, about its own middle, no texel more than full."""
    part = covered(disk_of(towards(place, radius_degrees=radius), 0, 1), n)
    weight = part * solid_angles(n)
    assert weight.sum() == pytest.approx(solid_angle(radius), rel=1e-5)
    assert part.min() >= 0
    assert part.max() < 1.03
    middle = weight @ directions(n)
    assert middle @ unit(place) > np.cos(np.radians(0.8 * 90 / n)) * np.linalg.norm(middle)


@at_every_place
def test_irradiance_by_a_cube_map(place: Any) -> None:
    """π L sin²ρ cos θ, above the horizon."""
    light = towards(place, radius_degrees=12, radiance=(1, 2, 3))
    texels = CubeLight(64).radiance(made(light, intensity=2))
    normal = unit(unit(place) + 0.4 * unit((0.2, 0.1, -0.9)))
    cosine = np.maximum(directions(64) @ normal, 0) * solid_angles(64)
    expected = math.pi * math.sin(math.radians(12)) ** 2 * (unit(place) @ normal)
    np.testing.assert_allclose(cosine @ texels, expected * 2 * np.array([1, 2, 3]), rtol=1e-3)


def test_it_moves_smoothly_over_a_cube_map() -> None:
    """A step of a hundredth of a texel moves no more than about that part of a small disk."""
    light = CubeLight(16)
    frames = []
    for k in range(40):
        angle = math.radians(0.01 * 90 / 16 * k)
        place = (math.sin(angle), 0.3, -math.cos(angle))
        frames.append(light.radiance(made(towards(place, radius_degrees=3)))[:, 0])
    weight = solid_angles(16)
    changes = np.abs(np.diff(frames, axis=0)) @ weight / 2 / solid_angle(3) / 10
    assert changes.max() < 0.03


def test_light_adds_to_the_map_and_is_linear() -> None:
    image = np.random.default_rng(1).uniform(0, 1, (16, 32, 3))
    light = CubeLight(16)
    light_of = {
        name: light.radiance(made(towards((1, 1, 0), radiance=radiance), image, **fields))
        for name, radiance, fields in (
            ("one", (1, 1, 1), {}),
            ("three", (3, 3, 3), {}),
            ("bright", (1, 1, 1), {"intensity": 2}),
            ("none", (0, 0, 0), {}),
        )
    }
    disk = light_of["one"] - light_of["none"]
    np.testing.assert_allclose(light_of["three"] - light_of["none"], 3 * disk, atol=1e-5)
    np.testing.assert_allclose(light_of["bright"], 2 * light_of["one"], rtol=1e-5)


def test_a_turn_takes_it_along() -> None:
    """By 90 degrees, counter-clockwise from above, from -z to -x: as the map, and as its sun."""
    light = towards((0, 0, -1), radius_degrees=20)
    where = made(light, rotation_degrees=90)
    np.testing.assert_allclose(where.disk.axis, (-1, 0, 0), atol=1e-12)
    assert radiance(where.table, (-1, 0, 0))[0, 0] == 10
    assert seen_radiance(where, places_on_map(np.array([[-1.0, 0, 0]])))[0, 0] == 10
    assert CubeLight(16).radiance(where)[directions(16)[:, 0] < -0.99].min() == 10
    (sun,) = suns(where, [])
    np.testing.assert_allclose(sun.direction, (1, 0, 0), atol=1e-12)
    shone = illuminate(sun, (0, 0, 0), np.full((1, 2), 0.5))[0, 4:7]
    np.testing.assert_allclose(shone, 10 * solid_angle(20), rtol=1e-6)


@pytest.mark.parametrize("radius", [0.25, 8, 45])
@pytest.mark.parametrize("dark", [False, True])
def test_density_and_samples(radius: float, dark: bool) -> None:
    """The density integrates to one, samples have it, and estimate all of the light."""
    image = np.zeros((8, 16, 3)) if dark else np.random.default_rng(2).uniform(0, 1, (8, 16, 3))
    table = made(towards((0.3, 0.5, -1), radius_degrees=radius), image, rotation_degrees=40).table
    fine = 1500
    total = pdf(table, _sphere(fine)) @ _solid_angles(fine)
    assert total == pytest.approx(1, rel=0.08 if radius < 1 else 2e-3)
    d = sample(table, np.random.default_rng(3).random((100_000, 2)))
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=1e-12)
    inside = 2 * np.arcsin(np.linalg.norm(d - table.disk.axis, axis=1) / 2) < np.radians(radius)
    # What falls there by the map alone comes on top.
    by_map = solid_angle(radius) / (4 * np.pi) * (1 - table.disk.share)
    assert inside.mean() == pytest.approx(table.disk.share + by_map, abs=0.03)
    estimate = (radiance(table, d) / pdf(table, d)[:, None]).mean(axis=0)
    edges = np.cos(np.linspace(0, np.pi, 9))
    of_map = (image * ((edges[:-1] - edges[1:]) * 2 * np.pi / 16)[:, None, None]).sum(axis=(0, 1))
    np.testing.assert_allclose(estimate, of_map + 10 * solid_angle(radius), rtol=0.02)


def test_what_is_seen_is_what_the_reference_sees_but_for_a_smooth_rim() -> None:
    image = np.random.default_rng(2).uniform(0, 1, (8, 16, 3))
    for place in PLACES.values():
        where = made(towards(place, radius_degrees=20), image, rotation_degrees=25)
        d = _sphere(200)
        away = 2 * np.arcsin(np.linalg.norm(d - where.disk.axis, axis=1) / 2)
        clear = np.abs(away - np.radians(20)) > np.radians(0.1)
        found, expected = seen_radiance(where, places_on_map(d)), radiance(where.table, d)
        alike = np.isclose(found, expected, rtol=1e-5).all(axis=1)
        assert alike[clear].mean() > 0.999
        assert (found[:, 0] > 9).sum() > 100


def test_without_background_the_camera_sees_black_and_the_light_stays() -> None:
    image = np.random.default_rng(2).uniform(0.1, 1, (8, 16, 3))
    shown, hidden = (
        made(towards((1, 1, 0)), image, background=background) for background in (True, False)
    )
    d = _sphere(40)
    assert seen_radiance(shown, places_on_map(d)).min() > 0
    assert not seen_radiance(hidden, places_on_map(d)).any()
    np.testing.assert_array_equal(radiance(hidden.table, d), radiance(shown.table, d))
    light = CubeLight(8)
    np.testing.assert_array_equal(light.radiance(hidden), light.radiance(shown))


@pytest.mark.parametrize(
    ("fields", "field"),
    [
        ({"direction": [0, 0, 0]}, ""),
        ({"direction": [0, 1]}, ".direction"),
        ({"direction": [0, 1, 0], "radius_degrees": 0}, ".radius_degrees"),
        ({"direction": [0, 1, 0], "radius_degrees": 46}, ".radius_degrees"),
        ({"direction": [0, 1, 0], "radiance": [1, -1, 1]}, ".radiance.1"),
        ({"direction": [0, 1, 0], "colour": [1, 1, 1]}, ".colour"),
        ({"radius_degrees": 5}, ".direction"),
    ],
)
def test_what_it_refuses(fields: dict[str, Any], field: str) -> None:
    with pytest.raises(EditError) as error:
        edited_environment(None, {"area_light": fields}, Path())
    assert error.value.field == f"environment.area_light{field}"


def test_edits_change_some_of_it_or_take_it_away() -> None:
    before = made(towards((0, 1, 0), radius_degrees=7))
    moved = edited_environment(before, {"area_light": {"direction": [1, 0, 0]}}, Path())
    assert moved is not None
    assert moved.radiance is before.radiance
    assert moved.description.area_light == FarDisk(direction=(1, 0, 0), radius_degrees=7)
    gone = edited_environment(moved, {"area_light": None, "background": False}, Path())
    assert gone is not None
    assert gone.description.area_light is None
    assert not gone.description.background
