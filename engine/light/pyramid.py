"""Images in lights: read once, kept at every size, looked up between pixels."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.errors import SceneError
from engine.images import read_image

MAX_SIDE = 1024  # pixels; longer images are made smaller
STEP = 64  # a pyramid's texels are a multiple of this, so that float32 can count them
KEPT_FILES = 16


@dataclass(frozen=True, eq=False)
class Pyramid:
    """An image and its halves, quarters, ... down to one pixel (Williams 1983).

    texels         (k, 3) float32  linear RGB, the levels one after another, rows from the top
    width, height  int             of the first level; the next is half of it, rounded down
    """

    texels: NDArray[np.float32]
    width: int
    height: int


def pyramid(image: NDArray[np.float32]) -> Pyramid:
    """The pyramid of an image (h, w, 3); every level is made by averaging areas."""
    side = max(image.shape[:2])
    if side > MAX_SIDE:
        h, w = (max(1, round(n * MAX_SIDE / side)) for n in image.shape[:2])
        image = _resized(image, w, h)
    height, width = image.shape[:2]
    levels = [image]
    while max(levels[-1].shape[:2]) > 1:
        h, w = levels[-1].shape[:2]
        levels.append(_resized(levels[-1], max(1, w // 2), max(1, h // 2)))
    texels = np.concatenate([level.reshape(-1, 3) for level in levels])
    padding = np.zeros((-len(texels) % STEP, 3), np.float32)
    return Pyramid(np.concatenate([texels, padding]).astype(np.float32), width, height)


def load_image(name: str, folder: Path) -> Pyramid:
    """A built-in image, or that of a file in `folder` or below.

    Raises SceneError, naming the file, where it is missing, elsewhere, damaged, or has values that
    are no numbers. Negative ones become 0.
    """
    if name in BUILT_IN:
        return _built_in(name)
    path = Path(os.path.abspath(folder / name))
    if not path.is_relative_to(os.path.abspath(folder)):
        raise SceneError("the file must lie in the folder of the scene", file=name)
    if not path.is_file():
        known = ", ".join(BUILT_IN)
        raise SceneError(f"there is no such file, and built-in images are: {known}", file=name)
    status = path.stat()
    return _from_file(path, name, status.st_mtime_ns, status.st_size)


@lru_cache(KEPT_FILES)
def _from_file(path: Path, name: str, changed: int, size: int) -> Pyramid:
    try:
        image = read_image(path)
    except SceneError as error:
        raise SceneError(error.message, file=name) from None
    if not np.isfinite(image).all():
        raise SceneError("some of its pixels are NaN or infinite", file=name)
    return pyramid(np.maximum(image, 0))


@lru_cache
def _built_in(name: str) -> Pyramid:
    return pyramid(BUILT_IN[name]())


def _resized(image: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    down, along = (_shares(n, m) for n, m in zip(image.shape, (height, width), strict=False))
    # One axis at a time; Pillow's box filter takes whole pixels alone, which changes the mean.
    return np.einsum("yj,jic,xi->yxc", down, image, along, optimize=True).astype(np.float32)


def _shares(pixels: int, fewer: int) -> NDArray[np.float64]:
    """(fewer, pixels): what part of each new pixel is covered by each old one."""
    edge = np.arange(fewer + 1)[:, None] * (pixels / fewer)
    old = np.arange(pixels)
    covered = np.minimum(edge[1:], old + 1) - np.maximum(edge[:-1], old)
    return np.maximum(covered, 0) * (fewer / pixels)


def window() -> NDArray[np.float32]:
    """Two by three panes with soft-edged bars between them, (192, 128, 3)."""
    x, y = (np.arange(128) + 0.5) / 128, (np.arange(192) + 0.5) / 192
    across, down = (_panes(v, n, bar) for v, n, bar in ((x, 2, 0.12), (y, 3, 0.12)))
    return np.repeat((down[:, None] * across)[:, :, None], 3, axis=2).astype(np.float32)


def _panes(v: NDArray[np.float64], count: int, bar: float) -> NDArray[np.float64]:
    """1 on the panes and 0 on the bars, which are that much of a pane wide, at the rim too."""
    to_bar = np.abs((v * count + 0.5) % 1 - 0.5) - bar / 2
    return np.clip(to_bar * 64 / count + 0.5, 0, 1)


def leaves() -> NDArray[np.float32]:
    """Patches of light through foliage, warm on green, (256, 256, 3)."""
    side = 256
    rng = np.random.default_rng(5)
    k = np.fft.fftfreq(side) * side
    band = np.exp(-((np.hypot(k[:, None], k[None]) / 9) ** 2))
    noise = np.fft.ifft2(np.fft.fft2(rng.normal(size=(side, side))) * band).real
    open_sky = 1 / (1 + np.exp(-9 * (noise / noise.std() - 0.1)))
    colour = np.array([1.0, 0.93, 0.75]) * open_sky[:, :, None]
    return (colour + np.array([0.02, 0.06, 0.01]) * (1 - open_sky)[:, :, None]).astype(np.float32)


def chart() -> NDArray[np.float32]:
    """Red, green, blue and white quarters from the upper left, clockwise, with dark squares."""
    image = np.zeros((128, 128, 3), np.float32)
    image[:64, :64, 0] = image[:64, 64:, 1] = image[64:, 64:, 2] = 1
    image[64:, :64] = 1
    dark = np.add.outer(np.arange(128) // 16, np.arange(128) // 16) % 2 == 1
    image[dark] *= 0.2
    return image


BUILT_IN: dict[str, Callable[[], NDArray[np.float32]]] = {
    "window": window,
    "leaves": leaves,
    "chart": chart,
}


@njit
def look_up(texels, first, width, height, u, v, lod):
    """Colour at (u, v) in [0, 1]², v from the top, between pixels; trilinear from level `lod`.

    first, width, height are what `light_table` writes into a row: the place of the first texel, in
    steps of STEP, and the size of the first level. Past the border its own pixels go on.
    """
    start, w, h = int(first) * STEP, int(width), int(height)
    lod = max(0.0, lod)
    while lod >= 1.0 and (w > 1 or h > 1):
        start += w * h
        w, h, lod = max(1, w // 2), max(1, h // 2), lod - 1.0
    fine = _bilinear(texels, start, w, h, u, v)
    if lod == 0.0 or (w == 1 and h == 1):
        return fine
    start += w * h
    coarse = _bilinear(texels, start, max(1, w // 2), max(1, h // 2), u, v)
    a = 1.0 - lod
    return (
        a * fine[0] + lod * coarse[0],
        a * fine[1] + lod * coarse[1],
        a * fine[2] + lod * coarse[2],
    )


@njit
def _bilinear(texels, start, w, h, u, v):
    x, y = u * w - 0.5, v * h - 0.5
    i, j = math.floor(x), math.floor(y)
    a, b = x - i, y - j
    i0, i1 = max(0, min(w - 1, i)), max(0, min(w - 1, i + 1))
    j0, j1 = start + max(0, min(h - 1, j)) * w, start + max(0, min(h - 1, j + 1)) * w
    return (
        _mix(texels, i0, i1, j0, j1, a, b, 0),
        _mix(texels, i0, i1, j0, j1, a, b, 1),
        _mix(texels, i0, i1, j0, j1, a, b, 2),
    )


@njit
def _mix(texels, i0, i1, j0, j1, a, b, c):
    top = (1.0 - a) * texels[j0 + i0, c] + a * texels[j0 + i1, c]
    bottom = (1.0 - a) * texels[j1 + i0, c] + a * texels[j1 + i1, c]
    return (1.0 - b) * top + b * bottom
