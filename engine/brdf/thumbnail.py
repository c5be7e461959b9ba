"""A small picture of a material, to know it by: a ball in the light of two lamps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.brdf.arrays import evaluate
from engine.brdf.base import Material
from engine.brdf.table import INDEX
from engine.numerics.display import to_srgb8

SIZE = 72  # pixels
# Where lamps far away stand, seen from the ball with the eye at +z, and their irradiance.
LAMPS = (((-0.5, 0.62, 0.6), 3.0), ((0.8, 0.1, 0.35), 0.7))
EVEN = 0.06  # radiance all around, as a part of what white paper would reflect of it


def thumbnail(material: Material, size: int = SIZE) -> NDArray[np.uint8]:
    """(size, size, 3) sRGB of a ball that touches the edges; what lies beside it is black.

    A grain runs around the ball's vertical axis. Emission is left out.
    """
    row, model = material.row(), INDEX[type(material)]
    place = (np.arange(size) + 0.5) * 2 / size - 1
    x, y = np.meshgrid(place, -place)
    inside = np.hypot(x, y) < 1
    normal = np.stack([x, y, np.sqrt(np.maximum(0, 1 - x**2 - y**2))], axis=-1)[inside]

    # Frames whose x axis runs along the circles of latitude.
    along = np.stack([normal[:, 2], 0 * normal[:, 0], -normal[:, 0]], axis=-1)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    frame = np.stack([along, np.cross(normal, along), normal], axis=1)
    away = frame @ np.array([0.0, 0.0, 1.0])
    light = np.zeros_like(normal)
    for direction, irradiance in LAMPS:
        towards = frame @ (np.array(direction) / np.linalg.norm(direction))
        f = evaluate(model, row, towards, away)
        light += irradiance * np.maximum(0, towards[:, 2:]) * f
    # What the surface reflects of light from behind the eye stands for that from everywhere, but
    # for the spot of a glossy one.
    light += EVEN * np.pi * np.minimum(1 / np.pi, evaluate(model, row, away, away))

    image = np.zeros((size, size, 3), np.float32)
    image[inside] = light
    return to_srgb8(image)
