"""A path's meeting with a surface, and the light that one sample brings there (kernels)."""

from __future__ import annotations

import numpy as np
from numba import njit

from engine.brdf import table as brdf
from engine.light import environment, table
from engine.numerics.frames import tangents, to_local
from engine.numerics.sampling import uniform
from engine.numerics.vec import add, dot, length, scale, sub
from engine.reference.world import emission, emitter_pdf, emitter_point
from engine.scene.surface import geometric_normal, normals, position

# Places of the random numbers of one vertex, see `number`; each light has four from LIGHT on, the
# fourth for the draw among lights.
SCATTER, SURVIVE, LIGHT = 0, 3, 16
NEAR = 2.0  # epsilons by which an occluder must lie before the light that it hides


@njit
def number(seed, index, bounce, place):
    """The random number of a path (`index`) at its vertex number `bounce`, in [0, 1)."""
    return uniform(seed, index, (bounce << 20) + place)


@njit(inline="always")
def frame_at(geometry, materials, triangle, b1, b2, wo):
    """(geometric normal, s, t, shading normal): all unit, the normals on the side of wo."""
    g, n = normals(geometry, materials, triangle, b1, b2, wo)
    s, t = tangents(n)
    return g, s, t, n


@njit
def reflect_towards(model, p, frame, wo, w):
    """(f · cos θ, density of BRDF sampling) for light from the world direction w; wo is local.

    Black where w lies below the flat triangle, whatever the shading normal says: no light leaks.
    """
    g, s, t, n = frame
    wi = to_local(w, s, t, n)
    if dot(g, w) <= 0.0 or wi[2] <= 0.0:
        return (0.0, 0.0, 0.0), 0.0
    return scale(brdf.evaluate(model, p, wi, wo), wi[2]), brdf.pdf(model, p, wi, wo)


@njit(inline="always")
def light_sample(world, light, x, seed, index, bounce):
    """One sample of one light seen from x.

    The local lights come first, then the environment, then the emissive surfaces.

    Returns (w, limit, L, pdf): unit direction, the distance within which an occluder hides the
    light, incident radiance over the sample's density, and that density over solid angle (0 for a
    light without extent, which BRDF sampling cannot hit).
    """
    black = (0.0, 0.0, 0.0)
    place = LIGHT + 4 * light
    u1, u2 = number(seed, index, bounce, place), number(seed, index, bounce, place + 1)
    local = world.lights.kind.shape[0]
    if light < local:
        kind, row = world.lights.kind[light], world.lights.row[light]
        wx, wy, wz, distance, r, g, b = table.illuminate(
            kind, row, world.lights.texels, x, 0.0, u1, u2
        )
        w = (wx, wy, wz)
        density = table.pdf(kind, row, x, w) if world.lights.extent[light] else 0.0
        return w, distance - NEAR * world.epsilon, (r, g, b), density
    if light == local:
        if not world.environment.present:
            return black, 0.0, black, 0.0
        w = environment.sample(world.environment, u1, u2)
        density = environment.pdf(world.environment, w)
        if density <= 0.0:
            return black, 0.0, black, 0.0
        return w, np.inf, scale(environment.radiance(world.environment, w), 1.0 / density), density
    if world.emitters.total <= 0.0:
        return black, 0.0, black, 0.0
    u0 = number(seed, index, bounce, place + 2)
    triangle, b1, b2 = emitter_point(world.emitters, u0, u1, u2)
    to = sub(position(world.geometry, triangle, b1, b2), x)
    distance = length(to)
    if distance <= world.epsilon:
        return black, 0.0, black, 0.0
    w = scale(to, 1.0 / distance)
    cosine = abs(dot(w, geometric_normal(world.geometry, triangle)))
    light_radiance = emission(world.geometry, world.materials, triangle)
    density = emitter_pdf(world.emitters, light_radiance, distance, cosine)
    if density <= 0.0:
        return black, 0.0, black, 0.0
    limit = distance - NEAR * world.epsilon
    return w, limit, scale(light_radiance, 1.0 / density), density


@njit
def weigh(own, other):
    """Balance heuristic, own / (own + other) (Veach 1997, eq. 9.8); 1 where own is infinite."""
    return 1.0 / (1.0 + other / own) if own > 0.0 else 0.0


@njit(inline="always")
def seen(world, o, d, distance, triangle, scattered):
    """Radiance that the ray from o along d meets at its end, and of the lights before it.

    `distance` and `triangle` are the nearest hit's (infinite, -1 for none). `scattered` is the
    density with which BRDF sampling took d: what `light_sample` could also have found is weighed
    against it; negative for a ray from the camera, which sees everything in full, but for an
    environment without background. Local lights are no obstacles: a ray sees all that lie before
    its hit, so that light adds up.
    """
    total = (0.0, 0.0, 0.0)
    for light in range(world.lights.kind.shape[0]):
        if world.lights.extent[light]:
            kind, row = world.lights.kind[light], world.lights.row[light]
            far, r, g, b = table.emitted(kind, row, o, d)
            if far >= 0.0 and far - NEAR * world.epsilon <= distance:
                share = 1.0 if scattered < 0.0 else weigh(scattered, table.pdf(kind, row, o, d))
                total = add(total, scale((r, g, b), share))
    if triangle < 0:
        share = 1.0 if world.environment.seen else 0.0
        if scattered >= 0.0:
            share = weigh(scattered, environment.pdf(world.environment, d))
        return add(total, scale(environment.radiance(world.environment, d), share))
    shine = emission(world.geometry, world.materials, triangle)
    if shine[0] + shine[1] + shine[2] > 0.0:
        share = 1.0
        if scattered >= 0.0:
            cosine = abs(dot(d, geometric_normal(world.geometry, triangle)))
            share = weigh(scattered, emitter_pdf(world.emitters, shine, distance, cosine))
        total = add(total, scale(shine, share))
    return total
