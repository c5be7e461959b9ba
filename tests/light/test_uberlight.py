"""Barzel's light, one control at a time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from light.lights import illuminate
from pydantic import ValidationError

from engine.light.spot import SpotLight
from engine.light.uberlight import UberLight


def uber(**fields: object) -> UberLight:
    """It shines along -z from the origin, its height along y, sharp unless said otherwise."""
    document = {
        "id": "u",
        "position": (0, 0, 0),
        "target": (0, 0, -1),
        "edge": 0,
        "intensity": (2, 2, 2),
        **fields,
    }
    return UberLight.model_validate(document)


def at(light: UberLight, x: object, y: object, z: object) -> np.ndarray:
    """Irradiance / intensity towards the light at x right, y up, z along the axis."""
    place = np.stack(np.broadcast_arrays(*(np.asarray(v, float) for v in (x, y, z))), axis=-1)
    return illuminate(light, place.reshape(-1, 3) * (1, 1, -1), (0.5, 0.5))[:, 4] / 2


def grid(n: int, reach: float) -> tuple[np.ndarray, np.ndarray]:
    side = (np.arange(n) + 0.5) / n * 2 * reach - reach
    x, y = np.meshgrid(side, side)
    return x.ravel(), y.ravel()


@pytest.mark.parametrize("roundness", [0.05, 0.5, 1.0])
def test_flux_of_a_sharp_beam(roundness: float) -> None:
    """Parallel rays: intensity times the superellipse's area 4ab Γ(1 + 1/m)² / Γ(1 + 2/m)."""
    light = uber(
        parallel=True, width=2, height=1, roundness=roundness, falloff_exponent=0, target=(0, 0, -1)
    )
    m = 2 / roundness
    area = 2 * math.gamma(1 + 1 / m) ** 2 / math.gamma(1 + 2 / m)
    flux = at(light, *grid(1200, 1.1), 5.0).mean() * 2.2**2
    assert flux == pytest.approx(area, rel=2e-3)
    assert roundness < 1 or area == pytest.approx(math.pi / 2)


def test_flux_of_a_soft_rectangle() -> None:
    """Each soft edge adds half its width: (width + edge) (height + edge)."""
    light = uber(parallel=True, width=2, height=1, roundness=0, edge=0.3, falloff_exponent=0)
    flux = at(light, *grid(900, 1.5), 0.2).mean() * 9
    assert flux == pytest.approx(2.3 * 1.3, rel=1e-3)


def test_rays_that_part_keep_their_shape_and_parallel_ones_their_size() -> None:
    for z in (0.1, 1.0, 30.0):
        cone = uber(width=0.6, height=0.4)
        assert at(cone, 0.299 * z, 0, z) > 0
        assert at(cone, 0.301 * z, 0, z) == 0
        assert at(cone, 0, -0.199 * z, z) > 0
        assert at(cone, 0, -0.201 * z, z) == 0
        beam = uber(width=0.6, height=0.4, parallel=True)
        assert (at(beam, [0.299, 0.301, 0, 0], [0, 0, 0.199, 0.201], z) > 0).tolist() == [
            1,
            0,
            1,
            0,
        ]
    way = illuminate(uber(parallel=True), (0.1, 0.2, -4), (0, 0))[0]
    np.testing.assert_allclose(way[:4], (0, 0, 1, 4), atol=1e-6)


def test_round_and_sharp_it_is_a_spot() -> None:
    """Of intensity I d², in its cone: another light's code, the same light."""
    spot = SpotLight(
        id="s", position=(1, 2, 3), target=(0, 0, 0), cone_degrees=25, penumbra_degrees=0,
        intensity=(18, 18, 18),
    )  # fmt: skip
    width = 2 * math.tan(math.radians(25))
    ours = uber(
        position=(1, 2, 3), target=(0, 0, 0), width=width, height=width, reference_distance=3
    )
    x = np.random.default_rng(1).normal(size=(2000, 3))
    a, b = illuminate(spot, x, (0, 0)), illuminate(ours, x, (0, 0))
    assert 300 < (a[:, 4] > 0).sum() < 1700
    np.testing.assert_allclose(b[a[:, 4] > 0], a[a[:, 4] > 0], rtol=1e-5, atol=1e-7)
    assert (b[a[:, 4] == 0, 4] == 0).all()


def test_up_turns_the_beam() -> None:
    wide = uber(width=1, height=0.2)
    tall = uber(width=1, height=0.2, up=(1, 0, 0))
    assert at(wide, 0.4, 0, 1) > 0 == at(wide, 0, 0.4, 1)
    assert at(tall, 0, 0.4, 1) > 0 == at(tall, 0.4, 0, 1)


@pytest.mark.parametrize("roundness", [0.0, 0.3, 1.0])
def test_edges_fall_off_smoothly(roundness: float) -> None:
    """From 1 to 0 along every ray from the axis, without steps or kinks, one half in the middle."""
    light = uber(
        parallel=True, width=1, height=0.6, edge=0.4, roundness=roundness, falloff_exponent=0
    )
    s = np.linspace(0, 1.5, 3001)
    for angle in np.linspace(0, 2 * np.pi, 13):
        value = at(light, s * math.cos(angle), s * math.sin(angle), 1)
        assert value[0] == 1
        assert value[-1] == 0
        assert (np.diff(value) <= 1e-9).all()
        assert np.abs(np.diff(value)).max() < 0.004
        assert np.abs(np.diff(value, 2)).max() < 1e-4
    assert at(light, 0.7, 0, 1) == pytest.approx(0.5)
    assert at(light, 0, -0.5, 1) == pytest.approx(0.5)


def test_slices() -> None:
    """Nothing before and behind, all of it in between, half of it halfway."""
    light = uber(
        cut_on=2, near_edge=1, cut_off=5, far_edge=4, falloff_exponent=0, parallel=True, width=9
    )
    found = at(light, 0, 0, [0.5, 0.999, 1.5, 2, 3.5, 5, 7, 9.001, 50])
    np.testing.assert_allclose(found, [0, 0, 0.5, 1, 1, 1, 0.5, 0, 0], atol=1e-6)
    fine = at(light, 1.0, 0, np.linspace(0, 10, 10001))
    assert np.abs(np.diff(fine)).max() < 2e-3
    sharp = uber(cut_on=2, cut_off=5)
    assert (at(sharp, 0, 0, [1.999, 2.001, 4.999, 5.001]) > 0).tolist() == [0, 1, 1, 0]


@pytest.mark.parametrize("n", [0.0, 1.0, 2.0, 3.5])
def test_falloff(n: float) -> None:
    """(d / r)^n; with a bound the same from d on, without a kink there, and never above it."""
    r = np.geomspace(1e-3, 100, 4001)
    free = uber(falloff_exponent=n, reference_distance=2)
    bound = uber(falloff_exponent=n, reference_distance=2, most=5)
    np.testing.assert_allclose(at(free, 0, 0, r), (2 / r) ** n, rtol=1e-5)
    found = at(bound, 0, 0, r)
    np.testing.assert_allclose(found[r >= 2], ((2 / r) ** n)[r >= 2], rtol=1e-5)
    if n:
        assert found.max() < 5
        assert (np.diff(found) < 0).all()
        slope = np.diff(np.log(found)) / np.diff(np.log(r))
        assert np.abs(np.diff(slope)).max() < 0.01 * n
    # Far off the axis it is the distance that counts, not the depth.
    assert at(uber(width=20, height=20, falloff_exponent=n), 3, 0, 4) == pytest.approx(5**-n)


def test_beam_exponent() -> None:
    light = uber(width=5, height=5, beam_exponent=6, falloff_exponent=0)
    assert at(light, 3 / 4 * 2, 0, 2) == pytest.approx(0.8**6)
    assert at(light, 0, 0, 2) == 1


def test_blocker() -> None:
    """A card's shadow grows with the distance behind it; before it there is none."""
    card = {"blocker_distance": 1, "blocker_offset": (0.1, 0.05), "blocker_size": (0.2, 0.1)}
    light = uber(width=2, height=2, falloff_exponent=0, **card)
    for z in (1.01, 4.0):
        assert at(light, 0.1 * z, 0.05 * z, z) == 0
        assert at(light, 0.199 * z, 0.099 * z, z) == 0
        assert at(light, 0.201 * z, 0.05 * z, z) == 1
        assert at(light, 0.1 * z, -0.001 * z, z) == 1
    assert at(light, 0.1, 0.05, 0.99) == 1
    parallel = uber(width=2, height=2, falloff_exponent=0, parallel=True, **card)
    assert at(parallel, [0.199, 0.201], 0.05, 9).tolist() == [0, 1]
    soft = uber(width=2, height=2, falloff_exponent=0, parallel=True, blocker_edge=0.2, **card)
    assert at(soft, 0.3, 0.05, 3) == pytest.approx(0.5)
    # What it takes away from a beam: its own soft rectangle.
    taken = 4 - at(soft, *grid(800, 1.0), 2.0).mean() * 4 - 4 + math.pi
    assert taken == pytest.approx(0.4 * 0.3, rel=0.02)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"cut_on": 3, "cut_off": 2}, "cut_off is nearer than cut_on"),
        ({"most": 0.5}, "most must be above 1.01"),
        ({"roundness": 1.5}, "less than or equal to 1"),
        ({"width": 0}, "greater than 0"),
        ({"target": (0, 0, 0)}, "same point"),
        ({"up": (0, 0, 0)}, "up is zero"),
        ({"blocker_size": (1,)}, "blocker_size"),
    ],
)
def test_bad_fields_say_what(fields: dict[str, object], words: str) -> None:
    with pytest.raises(ValidationError) as error:
        uber(**fields)
    assert words in str(error.value)
