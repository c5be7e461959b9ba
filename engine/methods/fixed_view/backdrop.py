"""What no light changes of a picture: surfaces that shine, and the environment behind them."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.backend.cpu.shading import average
from engine.light.environment import Environment, is_same
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.methods.fixed_view.frame_buffer import FrameBuffer, Points
from engine.scene.scene import Scene


class Backdrop:
    """Emission and background of a deep frame-buffer, antialiased, under any environment."""

    def __init__(self, scene: Scene, buffer: FrameBuffer) -> None:
        """Finds where the environment is seen when there is one."""
        self._emitted = _emission(scene, buffer.centre)
        average(buffer.edge, _emission(scene, buffer.sub), self._emitted)
        self._buffer = buffer
        self._last: tuple[Environment | None, NDArray[np.float32]] = (None, self._emitted)

    @cached_property
    def _behind(self) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]:
        """(pixels, which part of each, places on a map)."""
        buffer = self._buffer
        whole = buffer.centre.model < 0
        whole[buffer.edge] = False
        part = np.flatnonzero(buffer.sub.model < 0)
        pixel = np.concatenate([np.flatnonzero(whole), buffer.edge[part // 4]]).astype(np.int32)
        share = np.repeat(np.array([1, 0.25], np.float32), [len(pixel) - len(part), len(part)])
        away = np.concatenate([-buffer.centre.view[whole], -buffer.sub.view[part]])
        return pixel, share, places_on_map(away)

    def picture(self, environment: Environment | None) -> NDArray[np.float32]:
        """(n, 3) float32 radiance; not to be written into. The last one is kept."""
        known, out = self._last
        if is_same(known, environment):
            return out
        out = self._emitted
        if environment is not None:
            pixel, share, places = self._behind
            out = out.copy()
            _add_shares(pixel, share, seen_radiance(environment, places), out)
        self._last = (environment, out)
        return out


def _emission(scene: Scene, points: Points) -> NDArray[np.float32]:
    out = np.zeros((len(points), 3), np.float32)
    if scene.material_table.emission.any():
        hit = points.model >= 0
        out[hit] = scene.material_table.emission[points.material[hit]]
    return out


@njit(cache=True, nogil=True)
def _add_shares(pixel, share, radiance, out):
    for i in range(pixel.shape[0]):
        for c in range(3):
            out[pixel[i], c] += share[i] * radiance[i, c]
