"""What every local light must obey, and each against its closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from light.lights import EXAMPLES, WIDE, emitted, illuminate, pdf, stratified
from pydantic import TypeAdapter, ValidationError

from engine.light.area import AreaLight
from engine.light.base import ROW, Light, across
from engine.light.disk import DiskLight
from engine.light.distant import DistantLight
from engine.light.point import PointLight
from engine.light.sphere import SphereLight
from engine.light.spot import SpotLight
from engine.light.sun import SunLight
from engine.light.table import LIGHTS, AnyLight, light_table

FALL_OFF = ("point", "spot", "area", "disk", "sphere", "uberlight")

every_light = pytest.mark.parametrize("light", EXAMPLES, ids=lambda light: light.id)
wide_light = pytest.mark.parametrize("light", WIDE, ids=lambda light: light.id)


def test_every_type_has_an_example() -> None:
    assert {type(light) for light in EXAMPLES} == set(LIGHTS)
    assert {light.has_extent for light in EXAMPLES} == {True, False}


@every_light
def test_finite_everywhere(light: Light) -> None:
    """From x on the light, beside it, behind it and far away."""
    rng = np.random.default_rng(1)
    centre = np.array(getattr(light, "position", (0.0, 0.0, 0.0)))
    near = [centre + s * v for s in (0, 1e-30, 1e-12, 1e-6, 0.3) for v in rng.normal(size=(20, 3))]
    lit = 1e-3 * rng.normal(size=(20, 3))
    x = np.concatenate([near, 1e6 * rng.normal(size=(20, 3)), np.float32(near), lit])
    if light.has_extent:  # on the lamp itself, in its plane, at its rim
        normal = light.row()[3:6] if light.row()[3:6].any() else (0, 0, 1)
        s, t = across(tuple(normal), (0.3, 0.1, 0.9))
        a, b = rng.uniform(-2, 2, (2, 200, 1))
        radius, w = getattr(light, "radius", 1.0), rng.normal(size=(100, 3))
        w /= np.linalg.norm(w, axis=1, keepdims=True)
        rim = centre + radius * np.outer(np.cos(a), s) + radius * np.outer(np.sin(a), t)
        x = np.concatenate([x, centre + a * s + b * t, rim, centre + radius * w])
    u = np.array([[0.0, 0.0], [0.5, 0.5], [1 - 2.0**-24, 0.0], [0.0, 1 - 2.0**-24]])
    x, u = np.repeat(x, len(u), axis=0), np.tile(u, (len(x), 1))
    values = illuminate(light, x, u)
    assert np.isfinite(values).all()
    assert (values[:, 3:] >= 0).all()
    lit = values[:, 4] > 0
    assert lit.any()
    np.testing.assert_allclose(np.linalg.norm(values[lit, :3], axis=1), 1, atol=1e-6)
    w = rng.normal(size=x.shape)
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    for directions in (w, values[:, :3]):
        assert np.isfinite(pdf(light, x, directions)).all()
        assert np.isfinite(emitted(light, x, directions)).all()


@every_light
def test_linear_in_intensity(light: Light) -> None:
    """Twice the intensity, twice the light, in each channel by itself."""
    x, u = (0.0, 0.0, 0.0), (0.3, 0.6)
    twice = light.model_copy(update={"intensity": tuple(2 * v for v in light.intensity)})
    once = illuminate(light, x, u)[0]
    np.testing.assert_allclose(illuminate(twice, x, u)[0, 4:], 2 * once[4:], rtol=1e-6)
    np.testing.assert_allclose(once[4:] / once[6], (3, 2, 1), rtol=1e-6)


@pytest.mark.parametrize("light", [x for x in EXAMPLES if not x.has_extent], ids=lambda x: x.id)
def test_no_ray_hits_a_light_without_extent(light: Light) -> None:
    w = illuminate(light, (0, 0, 0), (0.5, 0.5))[:, :3]
    assert (pdf(light, (0, 0, 0), w) == 0).all()
    assert (emitted(light, (0, 0, 0), w)[:, 0] < 0).all()


@pytest.mark.parametrize(
    "light", [x for x in EXAMPLES if x.id in FALL_OFF], ids=lambda light: light.id
)
def test_inverse_square(light: Light) -> None:
    """On the axis, a hundred times as far, a ten-thousandth of the light."""
    position = np.array(light.position)  # type: ignore[attr-defined]
    axis = np.array(getattr(light, "target", (0, 0, 0))) - position
    axis /= np.linalg.norm(axis)
    near, far = (
        illuminate(light, position + 100 * s * axis, (0.5, 0.5))[0, 4] for s in (1.0, 100.0)
    )
    assert near / far == pytest.approx(1e4, rel=1e-3)
    radius = getattr(light, "radius", math.pi**-0.5)
    area = math.pi * radius**2
    if isinstance(light, AreaLight):
        area *= light.width * light.height
    assert far == pytest.approx(light.intensity[0] * area / 1e8, rel=1e-3)


@wide_light
def test_density_integrates_to_one(light: Light) -> None:
    """The density times the lamp's solid angle is 1, whatever way the solid angle is found."""
    x, axis, half, solid = _cone_around(light)
    w = _cone(axis, half, 1000)
    inside = emitted(light, x, w)[:, 0] > 0
    assert inside.mean() > 0.2
    cone = 4 * math.pi * math.sin(half / 2) ** 2
    assert inside.mean() * cone == pytest.approx(solid, rel=5e-3)
    assert pdf(light, x, w).mean() * cone == pytest.approx(1, rel=5e-3)


@wide_light
def test_samples_carry_radiance_over_density(light: Light) -> None:
    """`illuminate` gives L / pdf at a direction in which `emitted` sees L at the same distance."""
    rng = np.random.default_rng(2)
    u = 0.001 + 0.998 * rng.random((1000, 2))
    for x in ((0.0, 0.0, 0.0), (0.4, -0.7, 0.3), (0.1, 0.2, 0.0)):
        values = illuminate(light, x, u)
        density = pdf(light, x, values[:, :3])
        seen = emitted(light, x, values[:, :3])
        assert (density > 0).all()
        radiance = light.row()[6:9]
        assert isinstance(light, SunLight) or (radiance == light.intensity).all()
        np.testing.assert_allclose(values[:, 4] * density, radiance[0], rtol=1e-5)
        np.testing.assert_allclose(seen[:, 1:], np.tile(radiance, (1000, 1)))
        np.testing.assert_allclose(seen[:, 0], values[:, 3], rtol=1e-5)


@wide_light
def test_both_strategies_agree(light: Light) -> None:
    """Irradiance of a tilted surface by sampling the lamp and by sampling directions."""
    x, axis, half, _ = _cone_around(light)
    normal = np.array([0.0, 0.8, 0.6])
    values = illuminate(light, x, stratified(300, np.random.default_rng(3)))
    by_lamp = (values[:, 4] * np.maximum(values[:, :3] @ normal, 0)).mean()
    w = _cone(axis, half, 1000)
    seen = emitted(light, x, w)[:, 1] * np.maximum(w @ normal, 0)
    by_direction = seen.mean() * 4 * math.pi * math.sin(half / 2) ** 2
    assert by_lamp == pytest.approx(by_direction, rel=5e-3)
    assert by_lamp > 0


@wide_light
def test_jacobian_is_constant(light: Light) -> None:
    """The solid angle into which a small square of (u1, u2) goes is its area / pdf."""
    u = 0.05 + 0.9 * np.random.default_rng(4).random((300, 2))
    step = 1e-5
    sides = []
    for axis in np.eye(2):
        ahead, behind = (illuminate(light, (0, 0, 0), u + s * step * axis)[:, :3] for s in (1, -1))
        sides.append((ahead - behind) / (2 * step))
    area = np.linalg.norm(np.cross(*sides), axis=1)
    w = illuminate(light, (0, 0, 0), u)[:, :3]
    np.testing.assert_allclose(area * pdf(light, (0, 0, 0), w), 1, rtol=1e-4)


def test_area_light_against_the_form_factor() -> None:
    """E = π L F on a parallel plane, F of a rectangle seen from below its corner.

    F = (A atan(B / √(1 + A²)) / √(1 + A²) + ...) / 2π with A, B the sides over the distance
    (Howell, *A Catalog of Radiation Heat Transfer Configuration Factors*, B-4).
    """

    def corner(width: float, height: float, z: float) -> float:
        a, b = width / z, height / z
        p, q = math.sqrt(1 + a * a), math.sqrt(1 + b * b)
        return (a / p * math.atan(b / p) + b / q * math.atan(a / q)) / (2 * math.pi)

    width, height = 1.2, 0.5
    light = AreaLight(
        id="lamp",
        position=(0, 2, 0),
        target=(0, 0, 0),
        width=width,
        height=height,
        intensity=(7,) * 3,
    )
    for z in (2.0, 0.2, 0.001):
        x = np.array([0.0, 2.0 - z, 0.0])
        values = illuminate(light, x, stratified(200, np.random.default_rng(5)))
        irradiance = (values[:, 4] * values[:, 1]).mean()
        expected = math.pi * 7 * 4 * corner(width / 2, height / 2, z)
        assert irradiance == pytest.approx(expected, rel=2e-3)
    # Under a corner, and not at all from behind.
    values = illuminate(light, (0.6, 1.5, 0.25), stratified(200, np.random.default_rng(6)))
    expected = math.pi * 7 * corner(width, height, 0.5)
    assert (values[:, 4] * values[:, 1]).mean() == pytest.approx(expected, rel=2e-3)
    assert illuminate(light, (0, 2.5, 0), (0.5, 0.5))[0, 4] == 0
    assert emitted(light, (0, 2.5, 0), (0, -1, 0))[0, 0] < 0


def test_area_light_never_weighs_more_than_a_hemisphere() -> None:
    """However near: L · 2π bounds the sample, so no fireflies."""
    light = AreaLight(id="lamp", position=(0, 1, 0), target=(0, 0, 0))
    for z in (1e-1, 1e-3, 1e-6):
        values = illuminate(light, (0.1, 1 - z, 0), stratified(50, np.random.default_rng(7)))
        assert values[:, 4].max() <= 2 * math.pi + 1e-6


def test_area_light_stands_as_described() -> None:
    """Height runs along up, width across, and along z and x for a lamp on the ceiling."""
    wall = AreaLight(id="w", position=(0, 0, 5), target=(0, 0, 0), width=4, height=1)
    assert emitted(wall, (1.9, 0.4, 0), (0, 0, 1))[0, 0] == 5
    assert emitted(wall, (0.4, 0.9, 0), (0, 0, 1))[0, 0] < 0
    ceiling = AreaLight(id="c", position=(0, 5, 0), target=(0, 0, 0), width=4, height=1)
    assert emitted(ceiling, (1.9, 0, 0.4), (0, 1, 0))[0, 0] == 5
    assert emitted(ceiling, (0.4, 0, 0.9), (0, 1, 0))[0, 0] < 0
    both = AreaLight(id="b", position=(0, 0, 5), target=(0, 0, 0), up=(0, 0, 1))
    assert emitted(both, (0.4, 0.4, 0), (0, 0, 1))[0, 0] == 5


@pytest.mark.parametrize("penumbra", [0.0, 4.0, 30.0, 50.0])
def test_spot_power(penumbra: float) -> None:
    """Over all directions it emits 2π I (1 - (cos inner + cos outer) / 2).

    A penumbra that is wider than the cone ends at the axis.
    """
    light = SpotLight(
        id="s", position=(0, 0, 0), target=(0, 0, 3), cone_degrees=30, penumbra_degrees=penumbra
    )
    cosine = 1 - (np.arange(20000) + 0.5) / 20000 * 0.2
    x = np.column_stack([np.sqrt(1 - cosine**2), np.zeros_like(cosine), cosine])
    power = 2 * math.pi * illuminate(light, x, (0, 0))[:, 4].mean() * 0.2
    inner = math.cos(math.radians(max(0, 30 - penumbra)))
    expected = 2 * math.pi * (1 - (inner + math.cos(math.radians(30))) / 2)
    assert power == pytest.approx(expected, rel=1e-3)


def test_spot_falls_off_smoothly() -> None:
    """Full inside, black outside, without a step or a kink at either rim."""
    light = SpotLight(
        id="s", position=(0, 0, 0), target=(0, 0, 3), cone_degrees=20, penumbra_degrees=5
    )
    angle = np.linspace(0, 40, 4001)
    theta = np.radians(angle)
    x = np.column_stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)])
    value = illuminate(light, x, (0, 0))[:, 4]
    np.testing.assert_allclose(value[angle < 14.99], 1, atol=1e-6)
    assert (value[angle > 20.01] == 0).all()
    assert (np.diff(value) <= 1e-9).all()
    assert np.abs(np.diff(value)).max() < 0.01
    assert np.abs(np.diff(value, 2)).max() < 1e-4
    narrow = SpotLight(
        id="n", position=(0, 0, 0), target=(1, 2, 3), cone_degrees=0.1, penumbra_degrees=0
    )
    axis = np.array([1, 2, 3]) / math.sqrt(14)
    across = np.cross(axis, [0, 1, 0])
    across /= np.linalg.norm(across)
    for degrees, lit in ((0.098, True), (0.102, False)):
        t = math.radians(degrees)
        x = 10 * (math.cos(t) * axis + math.sin(t) * across)
        assert (illuminate(narrow, x, (0, 0))[0, 4] > 0) == lit


def test_distant_light() -> None:
    """The same irradiance everywhere, from infinity, against the way it travels."""
    light = DistantLight(id="sun", direction=(0, -5, 0), intensity=(4, 4, 4))
    for x in ((0, 0, 0), (1e5, -3, 2)):
        value = illuminate(light, x, (0, 0))[0]
        np.testing.assert_allclose(value, (0, 1, 0, 1e30, 4, 4, 4))


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ({"type": "spot", "position": [1, 2, 3], "target": [1, 2, 3]}, "the same point"),
        ({"type": "area", "position": [1, 2, 3], "target": [1, 2, 3]}, "the same point"),
        (
            {"type": "area", "position": [0, 0, 0], "target": [1, 0, 0], "width": 0},
            "greater than or equal to 0.0001",
        ),
        (
            {"type": "area", "position": [0, 0, 0], "target": [1, 0, 0], "up": [0, 0, 0]},
            "up is zero",
        ),
        ({"type": "distant", "direction": [0, 0, 0]}, "direction is zero"),
        ({"type": "point", "position": [0, math.nan, 0]}, "finite number"),
        ({"type": "point", "position": [0, 0, 0], "intensity": [-1, 0, 0]}, "or equal to 0"),
        (
            {"type": "disk", "position": [1, 2, 3], "target": [1, 2, 3]},
            "the same point",
        ),
        ({"type": "sun", "direction": [0, 0, 0]}, "direction is zero"),
        ({"type": "sun", "direction": [0, -1, 0], "diameter_degrees": 0}, "0.01"),
        ({"type": "disk", "position": [0, 0, 0], "target": [1, 0, 0], "radius": 0}, "0.0001"),
        ({"type": "sphere", "position": [0, 0, 0], "radius": -1}, "0.0001"),
        ({"type": "laser"}, "'point', 'spot', 'area', 'disk', 'sphere', 'distant', 'sun'"),
    ],
)
def test_bad_light_says_what(document: dict[str, object], words: str) -> None:
    with pytest.raises(ValidationError) as error:
        TypeAdapter(AnyLight).validate_python({"id": "a", **document})
    assert words in str(error.value)


@every_light
def test_described_and_read_back(light: Light) -> None:
    read = TypeAdapter(AnyLight).validate_json(light.model_dump_json())
    assert type(read) is type(light)
    assert read == light


def test_table_holds_what_is_on() -> None:
    """Lights that are off are left out; a thousand are no trouble; none at all is fine."""
    lights: list[Light] = [
        PointLight(id=str(i), position=(i, 0, 0), enabled=i % 2 == 0) for i in range(2000)
    ]
    packed = light_table(lights)
    assert packed.row.shape == (1000, ROW)
    np.testing.assert_array_equal(packed.row[:, 0], np.arange(0, 2000, 2))
    assert not packed.extent.any()
    assert light_table(EXAMPLES).extent.sum() == len(WIDE)
    assert light_table([]).row.shape == (0, ROW)


def _cone_around(light: Light) -> tuple[np.ndarray, np.ndarray, float, float]:
    """A point that the lamp lights, the axis and half angle of a cone of directions that holds the
    lamp, and the lamp's solid angle by summing over its area."""
    row = light.row().astype(float)
    x = np.array([0.1, 0.2, 0.0])
    if isinstance(light, SphereLight):
        d = np.array([row[:3] - x])
        sine = light.radius / np.linalg.norm(d)
        solid = 4 * math.pi * math.sin(math.asin(sine) / 2) ** 2
        return x, d[0] / np.linalg.norm(d), 1.01 * math.asin(sine), solid
    if isinstance(light, SunLight):
        half = math.radians(light.diameter_degrees) / 2
        return x, -row[3:6], 1.01 * half, 4 * math.pi * math.sin(half / 2) ** 2
    s, t = np.meshgrid(*[(np.arange(800) + 0.5) / 400 - 1] * 2)
    if isinstance(light, AreaLight):
        a, b = s.reshape(-1, 1) * row[15], t.reshape(-1, 1) * row[16]
        d = row[:3] + a * row[9:12] + b * row[12:15] - x
        area = light.width * light.height
    else:
        assert isinstance(light, DiskLight)
        e, f = across(tuple(row[3:6]), (0.3, 0.1, 0.9))
        r, phi = np.sqrt((s.reshape(-1, 1) + 1) / 2), math.pi * t.reshape(-1, 1)
        d = row[:3] + light.radius * r * (np.cos(phi) * e + np.sin(phi) * f) - x
        area = math.pi * light.radius**2
    r = np.linalg.norm(d, axis=1)
    solid = (-(d @ row[3:6]) / r**3).mean() * area
    axis = d.mean(axis=0) / np.linalg.norm(d.mean(axis=0))
    half = 1.01 * np.arccos(np.clip((d / r[:, None]) @ axis, -1, 1)).max()
    return x, axis, float(half), float(solid)


def _cone(axis: np.ndarray, half: float, side: int) -> np.ndarray:
    """(side², 3) directions evenly over a cone."""
    u = stratified(side, np.random.default_rng(8))
    versine = u[:, 0] * 2 * math.sin(half / 2) ** 2
    r, phi = np.sqrt(versine * (2 - versine)), 2 * np.pi * u[:, 1]
    s = np.cross(axis, [0.3, 0.1, 0.9])
    s /= np.linalg.norm(s)
    t = np.cross(axis, s)
    return (
        (r * np.cos(phi))[:, None] * s
        + (r * np.sin(phi))[:, None] * t
        + (1 - versine)[:, None] * axis
    )
