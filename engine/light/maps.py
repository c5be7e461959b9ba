"""Where environments come from: files, maps made in code, a constant, a clear sky."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.errors import SceneError
from engine.images import read_image
from engine.light.cube_file import cube_faces, unfolded
from engine.light.environment import Environment, EnvironmentDescription
from engine.light.sky import Sky, sky
from engine.numerics.description import Radiance

KEPT_MAPS = 4
FACES = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")


def load_environment(description: EnvironmentDescription, folder: Path) -> Environment:
    """The environment of a description; file names are relative to `folder`.

    The maps used last are kept, since a hand that turns one asks for it at every step. Raises
    SceneError, naming the file, where the map is missing or cannot be used; see `read_map`.
    """
    if isinstance(description.map, Sky):
        return Environment(description, _sky(description.map))
    if not isinstance(description.map, str):
        return Environment(description, _constant(description.map))
    if description.map in BUILT_IN:
        return Environment(description, _built_in(description.map))
    path = folder / description.map
    if not path.is_file():
        raise SceneError(
            f"there is no such file, and built-in maps are: {', '.join(BUILT_IN)}",
            field="environment.map",
            file=description.map,
        )
    return Environment(description, _file(path, path.stat().st_mtime_ns))


@lru_cache(KEPT_MAPS)
def _sky(description: Sky) -> NDArray[np.float32]:
    return sky(description)


@lru_cache(KEPT_MAPS)
def _constant(radiance: Radiance) -> NDArray[np.float32]:
    return np.full((1, 1, 3), radiance, np.float32)


@lru_cache(KEPT_MAPS)
def _built_in(name: str) -> NDArray[np.float32]:
    return BUILT_IN[name]()


@lru_cache(KEPT_MAPS)
def _file(path: Path, modified: int) -> NDArray[np.float32]:
    """`modified` makes a file that has changed another one."""
    return read_map(path)


def read_map(path: Path) -> NDArray[np.float32]:
    """(h, w, 3) float32 of an image file: a latitude-longitude map, or a cube map made into one.

    Raises SceneError, naming the file, where it is damaged, of another shape (`cube_file` has those
    of cube maps), or holds NaN or infinity. Negative values, which lossy EXR compression leaves
    near sharp lamps, become 0.
    """
    image = read_image(path)
    height, width = image.shape[:2]
    faces = cube_faces(image)
    if faces is None and abs(width - 2 * height) > 0.1 * width:
        raise SceneError(
            "a latitude-longitude map is twice as wide as high, a cube map is a cross of 4 to 3 or "
            f"3 to 4 or a strip of 6 to 1 or 1 to 6; this is {width} x {height}",
            field="environment.map",
            file=str(path),
        )
    pixels = image if faces is None else faces
    bad = ~np.isfinite(pixels).all(axis=-1)
    if bad.any():
        row, column = np.argwhere(bad)[0][-2:]
        face = "" if faces is None else f"face {FACES[np.argwhere(bad)[0][0]]}, "
        raise SceneError(
            f"{bad.sum()} pixels are NaN or infinite, the first at {face}row {row}, "
            f"column {column}",
            field="environment.map",
            file=str(path),
        )
    light = np.maximum(pixels, 0)
    return light if faces is None else unfolded(light)


# Soft boxes of the studio: azimuth from -z towards +x, elevation, half width and half height in
# degrees, radiance.
_BOXES = (
    (-55.0, 40.0, 24.0, 18.0, (9.0, 8.6, 8.0)),  # key, warm, from the left
    (70.0, 20.0, 14.0, 32.0, (3.0, 3.3, 3.8)),  # fill, cool, from the right
    (165.0, 48.0, 36.0, 7.0, (7.0, 7.0, 7.0)),  # strip behind, for rims
)
_EDGE_DEGREES = 3.0


def studio() -> NDArray[np.float32]:
    """Three soft boxes in a dark grey room, (128, 256, 3) float32."""
    height, width = 128, 256
    elevation = (90 - (np.arange(height) + 0.5) * 180 / height)[:, None]
    azimuth = ((np.arange(width) + 0.5) * 360 / width - 180)[None, :]
    # A floor a little darker than the ceiling tells up from down in reflections.
    image = np.zeros((height, width, 3), np.float32)
    image += (0.08 + 0.04 * np.sin(np.radians(elevation)))[:, :, None]
    for along, above, half_width, half_height, radiance in _BOXES:
        across = (azimuth - along + 180) % 360 - 180
        # Columns crowd towards the poles; boxes keep their width.
        dx = np.abs(across) * math.cos(math.radians(above)) - half_width
        dy = np.abs(elevation - above) - half_height
        inside = np.clip(0.5 - np.maximum(dx, dy) / _EDGE_DEGREES, 0, 1)
        inside = inside * inside * (3 - 2 * inside)
        image += inside[:, :, None] * np.asarray(radiance, np.float32)
    return image


BUILT_IN: dict[str, Callable[[], NDArray[np.float32]]] = {"studio": studio}
