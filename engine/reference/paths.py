"""The path tracer's kernels: a wave of paths, one bounce at a time.

The estimator is Kajiya's (1986) with Veach's multiple importance sampling (1997, §9.2). At every
vertex all lights are sampled; among their unshadowed contributions, each weighed by the balance
heuristic, one is drawn in proportion to its brightness and divided by its probability, and only
this one pays for a shadow ray. The expectation is the sum over all lights, so the weights need no
term for the draw, one bright light near a corner is not lost among a thousand dim ones, and a
vertex costs one shadow ray however many lights there are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdf
from engine.brdf.base import ROW
from engine.numerics.borrow import borrow
from engine.numerics.frames import to_local, to_world
from engine.numerics.vec import add, mul, scale, vec
from engine.reference.vertex import (
    LIGHT,
    SCATTER,
    SURVIVE,
    frame_at,
    light_sample,
    number,
    reflect_towards,
    seen,
    weigh,
)
from engine.scene.surface import parameters, position

FIRST_ROULETTE = 3  # reflections after which a path may be ended by chance
MOST_SURVIVAL = 0.95  # so that paths end even among perfect reflectors


class Paths(NamedTuple):
    """Rays on their way; all arrays of one length.

    origin      (n, 3) float32
    direction   (n, 3) float32   unit
    throughput  (n, 3) float32   what radiance at the ray's end counts for in its sample
    scattered   (n,) float32     density with which BRDF sampling took it; -1 from the camera
    slot        (n,) int32       which sample of the wave it belongs to
    """

    origin: NDArray[np.float32]
    direction: NDArray[np.float32]
    throughput: NDArray[np.float32]
    scattered: NDArray[np.float32]
    slot: NDArray[np.int32]


class Shadows(NamedTuple):
    """Shadow rays and what each brings if nothing is in its way.

    origin, direction  (n, 3) float32
    limit              (n,) float32
    radiance           (n, 3) float32   to add to the sample
    slot               (n,) int32
    """

    origin: NDArray[np.float32]
    direction: NDArray[np.float32]
    limit: NDArray[np.float32]
    radiance: NDArray[np.float32]
    slot: NDArray[np.int32]


def paths(n: int) -> Paths:
    """Room for n rays."""
    return Paths(
        np.zeros((n, 3), np.float32),
        np.zeros((n, 3), np.float32),
        np.ones((n, 3), np.float32),
        np.full(n, -1, np.float32),
        np.arange(n, dtype=np.int32),
    )


def shadows(n: int) -> Shadows:
    """Room for n shadow rays."""
    return Shadows(
        np.zeros((n, 3), np.float32),
        np.zeros((n, 3), np.float32),
        np.zeros(n, np.float32),
        np.zeros((n, 3), np.float32),
        np.zeros(n, np.int32),
    )


@njit(cache=True, nogil=True)
def pixel_jitter(seed, index, width, pixels, out):
    """Fill out (2, n) with pixel coordinates, uniform within each pixel; index (n,) int64."""
    for k in range(index.shape[0]):
        pixel = index[k] % pixels
        out[0, k] = pixel % width + number(seed, index[k], 0, 0)
        out[1, k] = pixel // width + number(seed, index[k], 0, 1)


@njit
def _put(a, k, v):
    a[k, 0], a[k, 1], a[k, 2] = v


@njit
def _accumulate(radiance, slot, bounce, value):
    first = 0 if bounce <= 1 else 3
    for c in range(3):
        radiance[slot, first + c] += value[c]


@njit(inline="always")
def _choose_light(world, model, p, frame, x, wo, seed, index, bounce):
    """(w, limit, reflected radiance) of one light, drawn by brightness; see the module."""
    total = 0.0
    chosen, chosen_limit, chosen_light, chosen_size = (0.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0), 1.0
    for light in range(world.lights.kind.shape[0] + 2):
        w, limit, incident, density = light_sample(world, light, x, seed, index, bounce)
        if incident[0] + incident[1] + incident[2] <= 0.0:
            continue
        f, scattering = reflect_towards(model, p, frame, wo, w)
        if density > 0.0:
            f = scale(f, weigh(density, scattering))
        value = mul(f, incident)
        size = value[0] + value[1] + value[2]
        if size <= 0.0:
            continue
        # Replace the choice with probability size / total: a reservoir of one.
        total += size
        if number(seed, index, bounce, LIGHT + 4 * light + 3) * total < size:
            chosen, chosen_limit, chosen_light, chosen_size = w, limit, value, size
    return chosen, chosen_limit, scale(chosen_light, total / chosen_size)


@njit(cache=True, nogil=True)
def bounce_paths(world, seed, bounce, last, now, n, hits, index, radiance, shadow, following):
    """Take n rays that have been reflected `bounce` times through what they hit.

    Adds the light they see to radiance (samples, 6), direct in the first three columns, indirect
    in the last; fills `shadow` and `following` from the start and returns how many of each.
    `last` is the number of reflections after which a path ends; index (samples,) int64 are the
    samples' numbers.
    """
    world, now, hits, index = borrow(world), borrow(now), borrow(hits), borrow(index)
    radiance, shadow, following = borrow(radiance), borrow(shadow), borrow(following)
    shadow_count = following_count = 0
    p = np.zeros(ROW, np.float32)
    for k in range(n):
        slot, triangle = now.slot[k], hits.triangle[k]
        o, d, throughput = vec(now.origin, k), vec(now.direction, k), vec(now.throughput, k)

        # Add what shines where the ray ends.
        light = seen(
            world, o, d, np.float64(hits.distance[k]), triangle, np.float64(now.scattered[k])
        )
        _accumulate(radiance, slot, bounce, mul(throughput, light))
        if triangle < 0 or bounce >= last:
            continue

        # Stand on the surface.
        b1, b2 = np.float64(hits.b1[k]), np.float64(hits.b2[k])
        back = scale(d, -1.0)
        frame = frame_at(world.geometry, world.materials, triangle, b1, b2, back)
        g, s, t, normal = frame
        wo = to_local(back, s, t, normal)
        x = add(position(world.geometry, triangle, b1, b2), scale(g, world.epsilon))
        model = parameters(world.geometry, world.materials, triangle, b1, b2, normal, p)
        vertex = bounce + 1

        # Ask one light for its share, if nothing is in the way.
        w, limit, value = _choose_light(world, model, p, frame, x, wo, seed, index[slot], vertex)
        value = mul(throughput, value)
        if value[0] + value[1] + value[2] > 0.0:
            if limit > 0.0:
                _put(shadow.origin, shadow_count, x)
                _put(shadow.direction, shadow_count, w)
                shadow.limit[shadow_count] = limit
                _put(shadow.radiance, shadow_count, value)
                shadow.slot[shadow_count] = slot
                shadow_count += 1
            else:
                _accumulate(radiance, slot, vertex, value)

        # Let the BRDF choose where the path goes on.
        u = (
            number(seed, index[slot], vertex, SCATTER),
            number(seed, index[slot], vertex, SCATTER + 1),
            number(seed, index[slot], vertex, SCATTER + 2),
        )
        wi = brdf.sample(model, p, wo, u)
        if wi[2] <= 0.0:
            continue
        w = to_world(wi, s, t, normal)
        f, density = reflect_towards(model, p, frame, wo, w)
        if density <= 0.0:
            continue
        throughput = scale(mul(throughput, f), 1.0 / density)
        largest = max(throughput[0], max(throughput[1], throughput[2]))
        if largest <= 0.0:
            continue

        # End paths that carry little, by chance, and let the others carry their light.
        if vertex >= FIRST_ROULETTE:
            survival = min(MOST_SURVIVAL, largest)
            if number(seed, index[slot], vertex, SURVIVE) >= survival:
                continue
            throughput = scale(throughput, 1.0 / survival)
        _put(following.origin, following_count, x)
        _put(following.direction, following_count, w)
        _put(following.throughput, following_count, throughput)
        following.scattered[following_count] = density
        following.slot[following_count] = slot
        following_count += 1
    return shadow_count, following_count


@njit(cache=True, nogil=True)
def add_unshadowed(shadow, n, hidden, bounce, radiance):
    """Add n shadow rays' light where hidden (n,) is False."""
    for k in range(n):
        if not hidden[k]:
            _accumulate(radiance, shadow.slot[k], bounce, vec(shadow.radiance, k))
