"""What a camera sees, as points to be lit: found once for a camera, its materials and levels."""

from __future__ import annotations

import numpy as np

from engine.methods.fixed_view.frame_buffer import (
    FrameBuffer,
    Points,
    describe,
    no_points,
    pixel_phase,
)
from engine.methods.free_view import Seen, look
from engine.methods.wavelet_brdf import levels
from engine.methods.wavelet_brdf.codes import Codes
from engine.methods.wavelet_brdf.settings import Settings
from engine.scene.camera import Camera
from engine.scene.scene import Scene


def buffer_of(
    scene: Scene,
    camera: Camera,
    scale: int,
    codes: Codes,
    settings: Settings,
    room: FrameBuffer | None = None,
) -> FrameBuffer:
    """What every scale-th pixel of every scale-th row shows, with levels in the rows of codes.

    It is a picture of its own, of a camera with so many pixels less. `room` is another one of the
    same size that is not needed any more: fresh memory costs as much as what is written into it.
    """
    view = look(scene, camera, scale)
    height, width = view.shape
    spread = scale * camera.spread
    centre = _points(scene, codes, view.centre, None if room is None else room.centre)
    sub = _points(scene, codes, view.sub)
    centre.size[:] = spread * view.centre.distance
    sub.size[:] = spread / 2 * view.sub.distance
    centre.phase[:] = pixel_phase(width, height)
    sub.phase[:] = np.tile(np.arange(4, dtype=np.uint8), len(view.edge))
    if settings.detail == "distance":
        factor = settings.alpha / scene.diagonal
        for points in (centre, sub):
            levels.set_by_distance(points, camera.position, factor, codes.each)
    elif settings.detail == "footprint":
        levels.set_by_footprint(centre, width, codes.each)
        levels.copy_from(centre.take(np.repeat(view.edge, 4)), sub)
    if settings.level > 0:
        for points in (centre, sub):
            levels.at_least(points, settings.level, codes.each)
    donors = np.repeat(view.edge, 4)
    return FrameBuffer(camera.reduced(scale), centre, view.edge, sub, donors, spread)


def _points(scene: Scene, codes: Codes, seen: Seen, room: Points | None = None) -> Points:
    points = no_points(len(seen.triangle), room)
    np.negative(seen.away, out=points.view)
    describe(scene.geometry, codes.table, seen.triangle, seen.b1, seen.b2, points)
    return points
