"""Suns of an environment map: small bright lamps, taken out of it as lights of their own.

A sun fills a hundred-thousandth of the sphere and may give two thirds of the light. Rays that do
not know of it seldom find it, and what they find is no shadow; a light of type `sun` in its place
casts one. What is taken is the excess of a spot over its surroundings, so that map and lights give
together what the map gave.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.light.environment import Environment
from engine.light.sun import SunLight

MOST = 3
SHARE = 0.05  # of the map's light that a spot must give to count as a lamp
REACH_DEGREES, AROUND_DEGREES = 4.0, 6.0  # how far a lamp reaches, and where its surroundings end
SMALLEST_DEGREES = 0.25


class Lamp(NamedTuple):
    """A lamp of a map that is not turned.

    direction   (3,) unit, towards it
    irradiance  (3,) of a surface that faces it, before the environment's intensity
    diameter    degrees
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    diameter: float


def split(radiance: NDArray[np.float32]) -> tuple[NDArray[np.float32], list[Lamp]]:
    """A map (h, w, 3) without its lamps, and those, at most MOST, the brightest first."""
    height, width = radiance.shape[:2]
    if height < 16:
        return radiance, []
    # Directions and solid angles of the pixels, laid out as `engine.light.environment` says.
    theta = (np.arange(height)[:, None] + 0.5) * np.pi / height
    phi = (np.arange(width)[None] + 0.5) * 2 * np.pi / width - np.pi
    away = np.stack(
        np.broadcast_arrays(
            np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)
        ),
        axis=-1,
    )
    edges = np.cos(np.linspace(0, np.pi, height + 1))
    solid = np.repeat(((edges[:-1] - edges[1:]) * 2 * np.pi / width)[:, None], width, axis=1)
    rest, lamps = radiance.copy(), []
    total = float((rest.mean(axis=2, dtype=np.float64) * solid).sum())
    for _ in range(MOST):
        peak = np.unravel_index(rest.mean(axis=2).argmax(), solid.shape)
        cosine = away @ away[peak]
        near = cosine > math.cos(math.radians(REACH_DEGREES))
        around = ~near & (cosine > math.cos(math.radians(AROUND_DEGREES)))
        excess = np.maximum(rest[near] - np.median(rest[around], axis=0), 0)
        flux = excess * solid[near][:, None]
        if total == 0 or flux.mean(axis=1).sum() < SHARE * total:
            break
        rest[near] -= excess
        lamps.append(_lamp(away[near], flux))
    return (rest if lamps else radiance), lamps


def _lamp(away: NDArray[np.float64], flux: NDArray[np.float64]) -> Lamp:
    """The disk that has the middle and the spread of pixels in directions (n, 3), flux (n, 3)."""
    weight = flux.mean(axis=1)
    middle = weight @ away
    middle /= np.linalg.norm(middle)
    # The mean square of the angle to the middle of a disk is half that of its radius.
    square = weight @ np.arccos(np.clip(away @ middle, -1, 1)) ** 2 / weight.sum()
    diameter = math.degrees(2 * math.sqrt(2 * square))
    return Lamp(middle, flux.sum(axis=0, dtype=np.float64), max(diameter, SMALLEST_DEGREES))


def suns(environment: Environment, lamps: list[Lamp]) -> tuple[SunLight, ...]:
    """The lights that stand for lamps of an environment as it is turned, and for its area light."""
    angle = math.radians(environment.description.rotation_degrees % 360.0)
    c, s = math.cos(angle), math.sin(angle)
    factor = environment.description.intensity
    found = []
    for k, (d, irradiance, diameter) in enumerate(lamps):
        x, y, z = (float(v) for v in d)
        red, green, blue = (factor * float(e) for e in irradiance)
        found.append(
            SunLight(
                id=f"environment {k + 1}",
                direction=(-(c * x + s * z), -y, -(c * z - s * x)),
                diameter_degrees=diameter,
                intensity=(red, green, blue),
            )
        )
    light, disk = environment.description.area_light, environment.disk
    if light is not None and any(disk.radiance):
        facing = math.pi * disk.versine * (2 - disk.versine)
        x, y, z = disk.axis
        red, green, blue = disk.radiance
        found.append(
            SunLight(
                id="environment area light",
                direction=(-x, -y, -z),
                diameter_degrees=2 * light.radius_degrees,
                intensity=(facing * red, facing * green, facing * blue),
            )
        )
    return tuple(found)
