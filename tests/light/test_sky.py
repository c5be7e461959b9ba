"""The clear sky: symmetry, where it is bright, its colours, its light, and its description."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from engine.errors import EditError, SceneError
from engine.light.environment import Environment, EnvironmentDescription
from engine.light.maps import load_environment
from engine.light.sky import HEIGHT, Sky, sky
from engine.light.sun import SunLight
from engine.scene.edits import edited_environment
from engine.scene.open import describe

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def direction(zenith_degrees: float, azimuth_degrees: float = 0.0) -> tuple[float, float, float]:
    """Where the light of a sun at an angle from the zenith travels; azimuth 0 stands at -z."""
    t, p = math.radians(zenith_degrees), math.radians(azimuth_degrees)
    return (-math.sin(t) * math.sin(p), -math.cos(t), math.sin(t) * math.cos(p))


def directions() -> np.ndarray:
    """(h, w, 3) of the map's pixels."""
    t = (np.arange(HEIGHT)[:, None] + 0.5) * np.pi / HEIGHT
    p = (np.arange(2 * HEIGHT)[None] + 0.5) * np.pi / HEIGHT - np.pi
    return np.stack([np.sin(t) * np.sin(p), np.cos(t) + 0 * p, -np.sin(t) * np.cos(p)], axis=-1)


def irradiance(image: np.ndarray) -> float:
    """Of a horizontal surface, in luminance."""
    t = (np.arange(HEIGHT // 2) + 0.5) * np.pi / HEIGHT
    weight = np.sin(t) * np.cos(t) * (np.pi / HEIGHT) ** 2
    return float((image[: HEIGHT // 2] @ LUMINANCE).sum(axis=1) @ weight)


@pytest.mark.parametrize("turbidity", [2.0, 3.0, 10.0])
@pytest.mark.parametrize("zenith", [0.0, 40.0, 75.0, 90.0])
def test_finite_and_brightest_near_the_sun(turbidity: float, zenith: float) -> None:
    image = sky(Sky(sun_direction=direction(zenith, 70), turbidity=turbidity))
    assert image.shape == (HEIGHT, 2 * HEIGHT, 3)
    assert image.dtype == np.float32
    assert np.isfinite(image).all()
    assert (image >= 0).all()
    bright = image[: HEIGHT // 2] @ LUMINANCE
    if 0 < zenith < 90:
        # Along every ring around the zenith the sky is brightest on the sun's side.
        to_sun = round((0.5 + 70 / 360) * 2 * HEIGHT)
        assert np.abs(bright.argmax(axis=1) - to_sun).max() <= 1
    if turbidity < 3:
        return  # in clear air the horizon is brighter
    top = np.unravel_index(bright.argmax(), bright.shape)
    angle = np.degrees(np.arccos(directions()[top] @ -np.array(direction(zenith, 70))))
    assert angle < (8 if zenith == 90 else 3)  # haze lifts a sun that sets


def test_it_turns_with_the_sun() -> None:
    """A quarter turn of the sun rolls the map by a quarter; its two halves mirror each other."""
    still, turned = (sky(Sky(sun_direction=direction(55, a))) for a in (0, 90))
    np.testing.assert_allclose(turned, np.roll(still, HEIGHT // 2, axis=1), rtol=1e-4)
    np.testing.assert_allclose(still, still[:, ::-1], rtol=1e-4)
    assert np.abs(still - turned).max() > 1
    # The same field as the light's points to the same place.
    sun = SunLight(id="sun", direction=direction(55, 90))
    d = directions()[: HEIGHT // 2]
    brightest = d.reshape(-1, 3)[(turned[: HEIGHT // 2] @ LUMINANCE).argmax()]
    assert brightest @ -sun.row()[3:6] > math.cos(math.radians(2))


@pytest.mark.parametrize("zenith", [0, 30, 45, 60, 75, 88])
def test_light_of_a_clear_day(zenith: float) -> None:
    """Illuminance of level ground: for clear air that of measured skies, in thousand lux.

    0.8 + 15.5 √sin(altitude) by the IES Lighting Handbook.
    """
    handbook = 0.8 + 15.5 * math.sqrt(math.cos(math.radians(zenith)))
    found = irradiance(sky(Sky(sun_direction=direction(zenith), turbidity=2)))
    assert found == pytest.approx(handbook, rel=0.02)
    hazy = irradiance(sky(Sky(sun_direction=direction(zenith), turbidity=6)))
    assert 1.6 < hazy / found < 2


@pytest.mark.parametrize(("turbidity", "zenith"), [(2, 60), (3, 45), (3, 75), (6, 30), (6, 60)])
def test_light_of_another_model(turbidity: float, zenith: float) -> None:
    """Hosek and Wilkie 2012, by Mitsuba's spectra: the same light on the ground within a fifth."""
    mitsuba = pytest.importorskip("mitsuba")
    before = mitsuba.variant()
    mitsuba.set_variant("scalar_spectral")
    try:
        theirs = hosek_wilkie(mitsuba, turbidity, zenith)
    finally:
        if before is not None:
            mitsuba.set_variant(before)
    ours = irradiance(sky(Sky(sun_direction=direction(zenith), turbidity=turbidity)))
    assert ours == pytest.approx(theirs, rel=0.2)


def hosek_wilkie(mitsuba: Any, turbidity: float, zenith: float) -> float:
    """Illuminance of level ground in thousand lux; z is up."""
    angle = math.radians(zenith)
    emitter = mitsuba.load_dict(
        {
            "type": "sunsky",
            "sun_scale": 0.0,
            "turbidity": float(turbidity),
            "sun_direction": [math.sin(angle), 0, math.cos(angle)],
            "albedo": {"type": "spectrum", "value": 0.1},
        }
    )
    wavelengths = np.arange(400.0, 720.0, 20.0).reshape(-1, 4)
    where, total = mitsuba.SurfaceInteraction3f(), 0.0
    for i in range(8):
        # Equal parts of cos² θ are equal parts of the light on the ground.
        cosine = math.sqrt((i + 0.5) / 8)
        for phi in (np.arange(12) + 0.5) * np.pi / 6:
            sine = math.sqrt(1 - cosine**2)
            where.wi = mitsuba.Vector3f(-sine * np.cos(phi), -sine * np.sin(phi), -cosine)
            for four in wavelengths:
                where.wavelengths = four.tolist()
                radiance = np.array(emitter.eval(where)).ravel()
                total += float((radiance * luminous(four)).sum()) * 20 * 683 / 1000
    return total * math.pi / (8 * 12)


def luminous(wavelength: np.ndarray) -> np.ndarray:
    """The eye's sensitivity over nm: the fit of Wyman, Sloan, Shirley 2013."""
    total = np.zeros_like(wavelength)
    for height, middle, below, above in ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)):
        width = np.where(wavelength < middle, below, above)
        total += height * np.exp(-0.5 * ((wavelength - middle) / width) ** 2)
    return total


def test_colours() -> None:
    """Blue overhead, whiter at the horizon and in haze, red around a sun that sets."""
    clear = sky(Sky(sun_direction=direction(50), turbidity=2.5))
    hazy = sky(Sky(sun_direction=direction(50), turbidity=8))
    dusk = sky(Sky(sun_direction=direction(88), turbidity=4))
    opposite = 0  # the column away from the sun

    def blueness(pixel: np.ndarray) -> float:
        return float(pixel[2] / pixel[0])

    assert blueness(clear[20, opposite]) > 2
    assert blueness(clear[20, opposite]) > 1.3 * blueness(clear[62, opposite])
    assert blueness(clear[20, opposite]) > 1.3 * blueness(hazy[20, opposite])
    assert blueness(dusk[62, HEIGHT]) < 0.7


def test_ground_reflects_the_sky() -> None:
    black = sky(Sky(sun_direction=direction(40), ground=(0, 0, 0)))
    grey = sky(Sky(sun_direction=direction(40), ground=(0.5, 0.5, 0.5)))
    half = HEIGHT // 2
    np.testing.assert_array_equal(black[:half], grey[:half])
    assert (black[half:] == 0).all()
    assert np.ptp(grey[half:], axis=(0, 1)).max() == 0
    assert grey[-1, 0] @ LUMINANCE * math.pi == pytest.approx(0.5 * irradiance(grey), rel=1e-4)


def test_described_in_a_scene() -> None:
    document = {
        "environment": {"map": {"sun_direction": [1, -1, 0]}, "intensity": 2},
        "objects": [{"name": "ball", "mesh": {"shape": "sphere"}}],
    }
    made = describe(document).environment
    assert made is not None
    assert EnvironmentDescription.model_validate_json(made.model_dump_json()) == made
    loaded = load_environment(made, Path())
    np.testing.assert_allclose(loaded.table.radiance, 2 * sky(Sky(sun_direction=(1, -1, 0))))
    for wrong, field, words in (
        ({"sun_direction": [0, 1, 0]}, "environment.map", "below the horizon"),
        ({"sun_direction": [0, 0, 0]}, "environment.map", "sun_direction is zero"),
        ({"sun_direction": [0, -1, 0], "turbidity": 1}, "environment.map.turbidity", "equal to 2"),
        ({"sun_direction": [0, -1, 0], "haze": 1}, "environment.map.haze", "turbidity"),
    ):
        document["environment"] = {"map": wrong}
        with pytest.raises(SceneError, match=words) as error:
            describe(document)
        assert error.value.field == field


def test_edits() -> None:
    old = Environment(EnvironmentDescription(), np.ones((1, 1, 3), np.float32))
    made = edited_environment(old, {"map": {"sun_direction": (0, -1, 0)}}, Path())
    assert made is not None
    assert made.radiance.shape == (HEIGHT, 2 * HEIGHT, 3)
    again = edited_environment(made, {"intensity": 3}, Path())
    assert again is not None
    assert again.radiance is made.radiance
    with pytest.raises(EditError, match="below the horizon"):
        edited_environment(made, {"map": {"sun_direction": (0, 2, 0)}}, Path())
    with pytest.raises(ValidationError, match="turbidity"):
        Sky(sun_direction=(0, -1, 0), turbidity=11)
