"""Sums and products of pictures, (n, 3) float32 buffers."""

from __future__ import annotations

from typing import Any

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
