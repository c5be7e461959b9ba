"""Sums and products of pictures, (n, 3) float32 buffers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import Device

ONE = (1.0, 1.0, 1.0)


def add(device: Device, total: Any, term: Any, n: int, factor: tuple[float, ...] = ONE) -> None:
    """total += factor * term, factor a colour."""
    buffers = {"b_sum": total, "b_term": term}
    device.program("passes/add.glsl").run(n, buffers, u_count=n, u_factor=factor)


def reflect(device: Device, light: Any, reflected: Any, n: int, gain: float) -> None:
    """light *= gain * reflected."""
    buffers = {"b_light": light, "b_reflected": reflected}
    device.program("passes/reflect.glsl").run(n, buffers, u_count=n, u_gain=gain)


def show(
    device: Device,
    total: Any,
    pixel: NDArray[np.intp],
    cover: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """total[pixel] = total[pixel] * (1 - cover) + radiance, at m pixels."""
    shown = np.concatenate([radiance, cover], axis=1).astype(np.float32)
    buffers = {
        "b_sum": total,
        "b_pixels": device.upload(pixel.astype(np.int32)),
        "b_shown": device.upload(shown),
    }
    device.program("passes/show.glsl").run(len(pixel), buffers, u_count=len(pixel))
