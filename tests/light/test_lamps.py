"""Suns taken out of maps: map and lights give together what the map gave, wherever it is turned."""

from __future__ import annotations

import math

import numpy as np
import pytest
from light.lights import illuminate

from engine.light.environment import Environment, EnvironmentDescription
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.light.lamps import MOST, split, suns
from engine.light.maps import studio
from engine.light.sky import Sky, sky

HEIGHT = 128


def solid() -> np.ndarray:
    """(h, 1, 1) solid angles of the pixels of a map of twice HEIGHT columns."""
    edges = np.cos(np.linspace(0, np.pi, HEIGHT + 1))
    return ((edges[:-1] - edges[1:]) * np.pi / HEIGHT)[:, None, None]


def with_sun(rows: slice, columns: slice, radiance: float = 3000.0) -> np.ndarray:
    image = np.full((HEIGHT, 2 * HEIGHT, 3), 0.2, np.float32)
    image[rows, columns] = np.float32([1, 0.9, 0.7]) * radiance
    return image


@pytest.mark.parametrize("columns", [slice(60, 63), slice(0, 2), slice(254, 256)])
def test_nothing_is_lost(columns: slice) -> None:
    """Flux of every colour; also for a sun at the seam of the map."""
    image = with_sun(slice(30, 33), columns)
    rest, lamps = split(image)
    assert len(lamps) == 1
    np.testing.assert_allclose(rest, 0.2, rtol=1e-3)
    taken = ((image - rest) * solid()).sum(axis=(0, 1))
    np.testing.assert_allclose(lamps[0].irradiance, taken, rtol=1e-5)
    assert image[31, columns.start, 0] == 3000, "the map itself is left as it was"


@pytest.mark.parametrize("turn", [0.0, 35.0, 270.0, -90.0])
def test_the_light_stands_where_the_map_shows_the_sun(turn: float) -> None:
    image = with_sun(slice(30, 33), slice(60, 63))
    environment = Environment(EnvironmentDescription(rotation_degrees=turn, intensity=2.0), image)
    _, lamps = split(image)
    (sun,) = suns(environment, lamps)
    towards = -sun.row()[3:6].astype(np.float64)
    seen = seen_radiance(environment, places_on_map(towards[None]))[0]
    np.testing.assert_allclose(seen, 2 * image[31, 61], rtol=1e-6)
    # Three pixels of 1.4 degrees wide, squeezed along the row.
    assert 2.5 < sun.diameter_degrees < 5.5
    facing = illuminate(sun, (0, 0, 0), np.full((1, 2), 0.5))
    np.testing.assert_allclose(facing[0, 4:7], 2 * lamps[0].irradiance, rtol=0.01)


def test_maps_without_suns_are_left_alone() -> None:
    maps = {
        "studio": studio(),
        "sky": sky(Sky(sun_direction=(1, -1, 0))),
        "even": np.ones((HEIGHT, 2 * HEIGHT, 3), np.float32),
        "black": np.zeros((HEIGHT, 2 * HEIGHT, 3), np.float32),
        "one pixel": np.ones((1, 1, 3), np.float32),
    }
    for name, image in maps.items():
        rest, lamps = split(image)
        assert lamps == [], name
        assert rest is image


def test_only_the_brightest_are_taken() -> None:
    image = with_sun(slice(30, 32), slice(60, 62), 4000)
    for k in range(1, 7):
        image[40:42, 60 + 25 * k : 62 + 25 * k] = 2000
    rest, lamps = split(image)
    assert len(lamps) == MOST
    strengths = [float(lamp.irradiance.mean()) for lamp in lamps]
    assert strengths == sorted(strengths, reverse=True)
    assert rest.max() == 2000
    first = lamps[0].direction
    assert math.acos(first[1]) == pytest.approx(31 * np.pi / HEIGHT, abs=0.01)
