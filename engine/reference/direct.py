"""Direct light by brute force: the obvious version beside the path tracer, to test it against.

Emission, and one reflection of every light in turn: each gets its own sample and its own shadow
ray, emissive surfaces are found by BRDF sampling alone, nothing is weighed against anything. It is
slower and noisier than `render(scene, max_bounces=1)` and has the same expectation.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdf
from engine.brdf.base import ROW
from engine.methods.base import Progress, silent
from engine.numerics.borrow import borrow
from engine.numerics.frames import to_local, to_world
from engine.numerics.vec import add, mul, scale, vec
from engine.reference.accumulate import accumulate
from engine.reference.limits import Limits
from engine.reference.paths import Paths, add_unshadowed, bounce_paths, paths, shadows
from engine.reference.result import Reference
from engine.reference.vertex import (
    SCATTER,
    frame_at,
    light_sample,
    number,
    reflect_towards,
)
from engine.reference.world import World, emission
from engine.scene.scene import Scene
from engine.scene.surface import parameters, position

SCATTERED = -1


def render_direct(
    scene: Scene,
    *,
    samples: int | None = None,
    error: float | None = None,
    max_seconds: float | None = None,
    seed: int = 0,
    progress: Progress = silent,
) -> Reference:
    """Emission and direct light of the scene; arguments as for `engine.reference.render`.

    Without any limit 256 samples are taken. `indirect` is black.
    """
    if samples is None and error is None and max_seconds is None:
        samples = 256
    limits = Limits(samples, error, max_seconds)
    return accumulate(scene, _trace, limits, seed, progress)


def _trace(
    scene: Scene, packed: World, seed: int, index: NDArray[np.int64], rays: Paths
) -> tuple[NDArray[np.float64], int]:
    n = len(index)
    radiance = np.zeros((n, 6))
    hits = scene.rays.intersect(rays.origin, rays.direction)
    shadow = shadows(n)
    # What the camera's own rays see shine: paths that end before their first reflection.
    bounce_paths(packed, seed, 0, 0, rays, n, hits, index, radiance, shadow, paths(0))
    # Local lights and the environment; the last of `light_sample` is left to BRDF sampling.
    for light in range(len(packed.lights.kind) + 1):
        _send(packed, seed, light, index, rays, hits, shadow)
        hidden = scene.rays.occluded(shadow.origin, shadow.direction, shadow.limit)
        add_unshadowed(shadow, n, hidden, 1, radiance)
    _send(packed, seed, SCATTERED, index, rays, hits, shadow)
    bounced = scene.rays.intersect(shadow.origin, shadow.direction)
    _meet(packed, bounced, shadow, radiance)
    return radiance, n * (len(packed.lights.kind) + 3)


@njit(cache=True, nogil=True)
def _send(world, seed, light, index, rays, hits, shadow):
    """Fill `shadow` with one ray from every hit, and what each brings.

    Towards a sample of one light, with the light it reflects if nothing hides it; or, where
    `light` is SCATTERED, where BRDF sampling goes, with f · cos θ / density.
    """
    world, rays, hits, shadow = borrow(world), borrow(rays), borrow(hits), borrow(shadow)
    p = np.zeros(ROW, np.float32)
    for k in range(index.shape[0]):
        shadow.slot[k], shadow.limit[k] = k, 0.0
        for c in range(3):
            shadow.origin[k, c], shadow.direction[k, c], shadow.radiance[k, c] = 0.0, 1.0, 0.0
        if hits.triangle[k] < 0:
            continue

        # Stand on the surface.
        triangle, b1, b2 = hits.triangle[k], np.float64(hits.b1[k]), np.float64(hits.b2[k])
        back = scale(vec(rays.direction, k), -1.0)
        frame = frame_at(world.geometry, world.materials, triangle, b1, b2, back)
        x = add(position(world.geometry, triangle, b1, b2), scale(frame[0], world.epsilon))
        model = parameters(world.geometry, world.materials, triangle, b1, b2, frame[3], p)
        wo = to_local(back, frame[1], frame[2], frame[3])

        # Choose where to look, and what a radiance of one or the light's own brings from there.
        if light == SCATTERED:
            u = (
                number(seed, index[k], 1, SCATTER),
                number(seed, index[k], 1, SCATTER + 1),
                number(seed, index[k], 1, SCATTER + 2),
            )
            w = to_world(brdf.sample(model, p, wo, u), frame[1], frame[2], frame[3])
            limit, incident = 0.0, (1.0, 1.0, 1.0)
        else:
            w, limit, incident, _ = light_sample(world, light, x, seed, index[k], 1)
        f, density = reflect_towards(model, p, frame, wo, w)
        if light == SCATTERED:
            f = scale(f, 1.0 / density) if density > 0.0 else (0.0, 0.0, 0.0)
        value = mul(f, incident)
        if value[0] + value[1] + value[2] > 0.0:
            shadow.limit[k] = limit
            for c in range(3):
                shadow.origin[k, c], shadow.direction[k, c] = x[c], w[c]
                shadow.radiance[k, c] = value[c]


@njit(cache=True, nogil=True)
def _meet(world, hits, shadow, radiance):
    """Add the emission of the surfaces that the scattered rays met."""
    for k in range(radiance.shape[0]):
        if hits.triangle[k] >= 0:
            light = emission(world.geometry, world.materials, hits.triangle[k])
            for c in range(3):
                radiance[k, c] += shadow.radiance[k, c] * light[c]
