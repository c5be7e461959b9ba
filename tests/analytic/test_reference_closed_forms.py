"""The path tracer against answers that can be written down."""

from __future__ import annotations

import math

import numpy as np
import pytest
from closed_form import assert_mean, floor, scene

from engine.brdf.albedo import albedo
from engine.brdf.published import SKIN
from engine.reference import render, render_direct
from engine.scene.camera import Camera

INSIDE = {"position": [0.1, 0.2, 0.3], "target": [0.5, -0.4, -1], "width": 16, "height": 16}
EMISSION = np.array([1.0, 2.0, 3.0])


def furnace(reflectance: float, **camera: object):
    return scene(
        camera={**INSIDE, "fov_y_degrees": 90, **camera},
        materials={
            "wall": {"type": "diffuse", "diffuse": [reflectance] * 3, "emission": list(EMISSION)}
        },
        objects=[{"name": "box", "mesh": {"shape": "box", "size": [2, 2, 2]}, "material": "wall"}],
    )


@pytest.mark.parametrize("reflectance", [0.5, 0.8])
def test_closed_furnace(reflectance):
    """Walls that shine and reflect evenly: L = E + ρL, so L = E / (1 - ρ) everywhere."""
    result = render(furnace(reflectance), samples=1024)
    assert_mean(result, EMISSION / (1 - reflectance), precision=1.5e-3)
    first = EMISSION * (1 + reflectance)
    np.testing.assert_allclose(result.direct + result.indirect, result.image, rtol=1e-6)
    np.testing.assert_allclose(result.direct.mean(axis=(0, 1)), first, rtol=0.01)


@pytest.mark.parametrize("bounces", [0, 1, 2, 5])
def test_furnace_cut_off(bounces):
    """After k reflections the geometric series ends: E (1 - ρ^(k+1)) / (1 - ρ)."""
    result = render(furnace(0.8), samples=256, max_bounces=bounces, seed=5)
    assert_mean(result, EMISSION * (1 - 0.8 ** (bounces + 1)) / 0.2, precision=2.5e-3)


def test_sphere_of_known_radiance():
    """A black ball that shines fills its disk with its radiance and leaves the rest black."""
    n, distance, radius = 33, 4.0, 1.0
    result = render(
        scene(
            camera={
                "position": [0, 0, distance],
                "target": [0, 0, 0],
                "fov_y_degrees": 40,
                "width": n,
                "height": n,
            },
            materials={"ball": {"type": "diffuse", "diffuse": [0, 0, 0], "emission": [3, 2, 1]}},
            objects=[
                {
                    "name": "ball",
                    "mesh": {"shape": "sphere", "radius": radius, "rings": 128},
                    "material": "ball",
                }
            ],
        ),
        samples=64,
    )
    x = (2 * (np.arange(n) + 0.5) / n - 1) * math.tan(math.radians(20))
    off_axis = np.arctan(np.hypot(*np.meshgrid(x, x)))
    pixel = 2 * math.tan(math.radians(20)) / n
    rim = math.asin(radius / distance)
    inside, outside = off_axis < rim - pixel, off_axis > rim + pixel
    assert inside.sum() > 100
    assert np.all(result.image[inside] == np.float32([3, 2, 1]))
    assert np.all(result.variance[inside] == 0)
    assert np.all(result.image[outside] == 0)
    covered = result.image[..., 0].sum() / 3 * pixel**2
    assert covered == pytest.approx(math.pi * math.tan(rim) ** 2, rel=0.01)


DOWN = {
    "position": [0.5, 3, 2],
    "target": [0, 0, 0],
    "fov_y_degrees": 40,
    "width": 12,
    "height": 12,
}


def floor_points(camera: dict, sub: int = 16) -> np.ndarray:
    """(h, w, sub², 3): where a lattice of rays through each pixel meets the plane y = 0."""
    n = camera["width"]
    s = (np.arange(n * sub) + 0.5) / sub
    x, y = (a.ravel() for a in np.meshgrid(s, s))
    d = Camera(**camera).directions(x, y).astype(np.float64)
    o = np.array(camera["position"], np.float64)
    hit = o - d * (o[1] / d[:, 1])[:, None]
    grid = hit.reshape(n, sub, n, sub, 3).swapaxes(1, 2)
    return grid.reshape(n, n, sub * sub, 3)


def test_point_light_over_plane():
    """ρ / π · I cos θ / r², with cos θ = h / r."""
    light, intensity, rho = np.array([0.4, 1.5, -0.3]), np.array([4, 5, 6.0]), 0.6
    made = floor(
        {"type": "diffuse", "diffuse": [rho] * 3},
        DOWN,
        lights=[
            {"id": "p", "type": "point", "position": list(light), "intensity": list(intensity)}
        ],
    )
    r = np.linalg.norm(light - floor_points(DOWN), axis=-1)
    expected = rho / math.pi * (light[1] / r**3).mean(axis=-1)[..., None] * intensity
    assert_mean(render(made, samples=256), expected, precision=5e-4)
    assert_mean(render_direct(made, samples=256), expected, precision=5e-4)


def test_distant_light_on_plane():
    """ρ / π · E cos θ, without any noise."""
    made = floor(
        {"type": "diffuse", "diffuse": [0.2, 0.4, 0.8]},
        DOWN,
        lights=[{"id": "sun", "type": "distant", "direction": [1, -2, 2], "intensity": [3, 3, 3]}],
    )
    result = render(made, samples=16)
    expected = np.array([0.2, 0.4, 0.8]) / math.pi * 3 * (2 / 3)
    np.testing.assert_allclose(result.image, np.broadcast_to(expected, (12, 12, 3)), rtol=2e-6)


def test_environment_over_plane():
    """White light from everywhere leaves a matt plane as albedo × radiance."""
    reflectance, radiance = np.array([0.25, 0.5, 0.75]), np.array([2.0, 1.0, 0.5])
    made = floor(
        {"type": "diffuse", "diffuse": list(reflectance)},
        DOWN,
        environment={"map": list(radiance)},
    )
    assert_mean(render(made, samples=1024), reflectance * radiance, precision=1e-3)
    assert_mean(render_direct(made, samples=4096), reflectance * radiance, precision=2e-3)


def polygon_irradiance(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Irradiance of y-up points under a polygon of radiance 1, all of it above them.

    Lambert 1760: ½ Σ Θ_k (Γ_k · n), with Θ_k the angle that edge k subtends and Γ_k the unit normal
    of the plane through the point and the edge.
    """
    total = np.zeros(points.shape[:-1])
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        va, vb = a - points, b - points
        va /= np.linalg.norm(va, axis=-1, keepdims=True)
        vb /= np.linalg.norm(vb, axis=-1, keepdims=True)
        normal = np.cross(va, vb)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        total += np.arccos(np.clip((va * vb).sum(-1), -1, 1)) * normal[..., 1]
    return np.abs(total) / 2


@pytest.mark.parametrize("kind", ["lamp", "surface"])
def test_area_light_over_plane(kind):
    """A lamp and an emissive surface of the same shape both light the plane as Lambert says."""
    height, radiance = 1.2, np.array([5.0, 4.0, 3.0])
    width, depth = 1.0, 0.6
    x, z = width / 2, depth / 2
    corners = np.array([[-x, height, -z], [x, height, -z], [x, height, z], [-x, height, z]])
    camera = {**DOWN, "position": [2.4, 0.9, 0.3], "target": [0.2, 0, 0], "fov_y_degrees": 22}
    material = {"type": "diffuse", "diffuse": [0.7] * 3}
    if kind == "lamp":
        lamp = {
            "id": "a",
            "type": "area",
            "position": [0, height, 0],
            "target": [0, 0, 0],
            "up": [0, 0, 1],
            "width": width,
            "height": depth,
            "intensity": list(radiance),
        }
        made = floor(material, camera, lights=[lamp])
    else:
        made = scene(
            camera=camera,
            materials={
                "floor": material,
                "lamp": {"type": "diffuse", "diffuse": [0, 0, 0], "emission": list(radiance)},
            },
            objects=[
                {
                    "name": "floor",
                    "material": "floor",
                    "mesh": {"shape": "rectangle", "size": [40, 40]},
                    "transform": {"rotate_degrees": [-90, 0, 0]},
                },
                {
                    "name": "lamp",
                    "material": "lamp",
                    "mesh": {"shape": "polygons", "polygons": [corners.tolist()]},
                },
            ],
        )
    irradiance = polygon_irradiance(floor_points(camera), corners).mean(axis=-1)
    expected = 0.7 / math.pi * irradiance[..., None] * radiance
    assert_mean(render(made, samples=1024, seed=1), expected, precision=2e-3)
    assert_mean(render_direct(made, samples=4096, seed=2), expected, precision=6e-3)


@pytest.mark.parametrize(
    "material",
    [
        {"type": "ggx", "diffuse": [0, 0.2, 0.5], "specular": [0.9, 0.5, 0.1], "roughness": 0.4},
        {"type": "ggx", "diffuse": [0, 0, 0], "specular": [1, 0.8, 0.6], "roughness": 0.05},
        {"type": "phong", "diffuse": [0.1, 0.2, 0.3], "specular": [0.5, 0.5, 0.4], "exponent": 60},
        {
            "type": "blinn_phong",
            "diffuse": [0.1, 0.2, 0.3],
            "specular": [0.5, 0.5, 0.4],
            "exponent": 200,
        },
        {"type": "ashikhmin_shirley", "exponent_u": 3, "exponent_v": 400},
        SKIN.model_dump(),
        {"type": "cook_torrance", "specular": [0.9, 0.5, 0.1], "roughness": 0.2},
        {"type": "half_angle_curve", "specular": [0.9, 0.5, 0.1]},
    ],
    ids=[
        "ggx rough",
        "ggx sharp",
        "phong",
        "blinn-phong",
        "ashikhmin-shirley",
        "skin",
        "cook-torrance",
        "curve",
    ],
)
def test_gloss_under_white_sky(material):
    """A plane in a white furnace shows its albedo, as the engine's own quadrature has it."""
    camera = {
        "position": [0, 5, 7],
        "target": [0, 0, 0],
        "fov_y_degrees": 0.2,
        "width": 6,
        "height": 6,
    }
    made = floor(material, camera, environment={"map": [1, 1, 1]})
    wo = np.array([0, 7, 5]) / math.hypot(7, 5)
    expected = albedo(made.material_table.model[0], made.material_table.row[0], wo, 1 << 18)[0]
    assert_mean(render(made, samples=4096), expected, precision=2.5e-3)
