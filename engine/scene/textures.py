"""Read images into linear texels."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import EpsImagePlugin
from PIL import Image as Pillow

from engine.errors import SceneError

Image = NDArray[np.float32]
"""(height, width, 3) float32, linear, rows from the bottom up."""

MAX_SIDE = 2048
MAX_PIXELS = 1 << 27  # of a file

# Nobody's picture is a program to be run by another one.
EpsImagePlugin.gs_binary = False


def read_image(source: Path | Pillow.Image, name: str, *, srgb: bool) -> tuple[Image, int]:
    """The image in linear light and the longer side of the file, in pixels.

    An image longer than MAX_SIDE is made smaller by averaging areas. `srgb` is for colours; plain
    numbers such as roughness are not decoded. Raises SceneError for a file that is no image.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            opened = source if isinstance(source, Pillow.Image) else Pillow.open(source)
            if opened.width * opened.height > MAX_PIXELS:
                raise ValueError(f"{opened.width} x {opened.height} pixels are too many")
            values = _values(opened, srgb)
    except Exception as error:  # Pillow raises whatever its decoders raise
        reason = str(error).replace(str(source), name)
        raise SceneError(f"cannot be read as an image: {reason}", file=name) from None
    side = max(values.shape[:2])
    if side > MAX_SIDE:
        values = resized(
            values,
            max(1, round(values.shape[1] * MAX_SIDE / side)),
            max(1, round(values.shape[0] * MAX_SIDE / side)),
        )
    return np.ascontiguousarray(values[::-1], np.float32), side


def _values(image: Pillow.Image, srgb: bool) -> Image:
    """(height, width, 3) float32 in 0 to 1, rows from the top down, decoded where it is sRGB."""
    if image.mode.startswith("I"):
        grey = np.asarray(image, np.float32) / np.float32(65535)
        grey = linear(grey) if srgb else grey
        return np.repeat(grey[:, :, None], 3, axis=2)
    if image.mode == "P" and "transparency" in image.info:
        image = image.convert("RGBA")
    levels = np.arange(256, dtype=np.float32) / np.float32(255)
    return (linear(levels) if srgb else levels)[np.asarray(image.convert("RGB"))]


def linear(srgb: Image) -> Image:
    """Decode IEC 61966-2-1 sRGB."""
    low = srgb / np.float32(12.92)
    high = ((srgb + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)
    return np.where(srgb <= 0.04045, low, high).astype(np.float32)


def steeper(normals: Image, strength: float) -> Image:
    """A normal map whose x and y are so many times as large."""
    if strength == 1:
        return normals
    # Its numbers are (n + 1) / 2; what leaves 0 to 1 is none the worse as no bytes hold it.
    factor = np.array([strength, strength, 1], np.float32)
    return np.float32(0.5) + (normals - np.float32(0.5)) * factor


def resized(values: Image, width: int, height: int) -> Image:
    """Another size, by averaging areas where it shrinks."""
    channels = [
        np.asarray(
            Pillow.fromarray(np.ascontiguousarray(values[:, :, k])).resize(
                (width, height), Pillow.Resampling.BOX
            )
        )
        for k in range(values.shape[2])
    ]
    return np.stack(channels, axis=2).astype(np.float32)
