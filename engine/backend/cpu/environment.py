"""Light that arrives at points straight from the environment, with shadows by rays."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdfs
from engine.light import environment
from engine.light.environment import EnvironmentTable
from engine.numerics.frames import tangents, to_local, to_world
from engine.numerics.parallel import for_ranges
from engine.numerics.sampling import balance, uniform
from engine.numerics.vec import add, dot, scale, vec
from engine.scene.rays import RayTracer

evaluate, sample_brdf, pdf_brdf = brdfs.evaluate, brdfs.sample, brdfs.pdf
radiance_of, sample_map, pdf_map = environment.radiance, environment.sample, environment.pdf

CHUNK = 32768


def environment_on_points(
    rays: RayTracer,
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    geometric: NDArray[np.float32],
    view: NDArray[np.float32],
    model: NDArray[np.int32],
    row: NDArray[np.float32],
    table: EnvironmentTable,
    samples: int,
    seed: int,
) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32, an estimate from `samples` rays from the map and as many
    from the BRDF, weighed by the balance heuristic; shapes as for `shading.light_points`.
    """
    n = len(model)
    out = np.zeros((n, 3), np.float32)
    if not table.present:
        return out

    def part(start: int, stop: int) -> None:
        m = stop - start
        origin, direction = np.zeros((m, 3), np.float32), np.zeros((m, 3), np.float32)
        value, index = np.zeros((m, 3), np.float32), np.zeros(m, np.int32)
        for s in range(2 * samples):
            count = _candidates(
                start, stop, position, normal, geometric, view, model, row, table, s, samples,
                seed, rays.epsilon, origin, direction, value, index,
            )  # fmt: skip
            free = ~rays.occluded(origin[:count], direction[:count])
            out[index[:count][free]] += value[:count][free]

    for_ranges(part, n, grain=CHUNK)
    return out


@njit(cache=True, nogil=True)
def _candidates(
    start, stop, position, normal, geometric, view, model, row, table, s, samples, seed, epsilon,
    origin, direction, value, index,
):  # fmt: skip
    count = 0
    for i in range(start, stop):
        if model[i] < 0:
            continue
        n, g = vec(normal, i), vec(geometric, i)
        t1, t2 = tangents(n)
        wo = to_local(vec(view, i), t1, t2, n)
        # The first coordinate is stratified over the samples, all are shifted per point.
        u1 = (s // 2 + uniform(seed, i, 2 * s)) / samples
        u2, u3 = uniform(seed, i, 2 * s + 1), uniform(seed + 1, i, s)
        if s % 2 == 0:
            w = sample_map(table, u1, u2)
            wi = to_local(w, t1, t2, n)
        else:
            wi = sample_brdf(model[i], row[i], wo, (u2, u1, u3))
            w = to_world(wi, t1, t2, n)
        if wi[2] <= 0.0 or dot(w, g) <= 0.0:
            continue
        f = evaluate(model[i], row[i], wi, wo)
        by_map, by_brdf = pdf_map(table, w), pdf_brdf(model[i], row[i], wi, wo)
        taken, other = (by_map, by_brdf) if s % 2 == 0 else (by_brdf, by_map)
        if taken <= 0.0 or f[0] + f[1] + f[2] <= 0.0:
            continue
        weight = wi[2] * balance(taken, other) / (taken * samples)
        e = radiance_of(table, w)
        o = add(vec(position, i), scale(g, epsilon))
        for k in range(3):
            origin[count, k] = o[k]
            direction[count, k] = w[k]
            value[count, k] = f[k] * e[k] * weight
        index[count] = i
        count += 1
    return count
