"""What a camera sees of a mesh, and its colour from the light-dependent vectors of the corners."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.base import diffuse_colour
from engine.light.environment import Environment
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.methods.glossy_prt.terms import Terms
from engine.methods.glossy_prt.vertices import Vertices, frame
from engine.numerics.borrow import borrow
from engine.numerics.frames import to_local
from engine.numerics.hemisphere_maps import disk_taps
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import add, cross, dot, mul, normalize, scale, sub, vec
from engine.scene import surface
from engine.scene.camera import Camera
from engine.scene.scene import Scene

SUBSAMPLES = np.array([[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]])
SAME_NORMAL, SAME_DEPTH = 0.9, 0.02
LOWEST = 0.02  # cosine of a view below which maps are not looked up: beyond their rim is nothing


class Seen(NamedTuple):
    """What m rays from the eye meet.

    triangle  (m,) int32       -1 where nothing
    b1, b2    (m,) float32     barycentrics of its second and third corner
    away      (m, 3) float32   unit, from the eye
    """

    triangle: NDArray[np.int32]
    b1: NDArray[np.float32]
    b2: NDArray[np.float32]
    away: NDArray[np.float32]


class View(NamedTuple):
    """A camera's pixels: one ray through the centre of each, four through those at edges.

    shape   (height, width)
    centre  height · width rays, row by row from the top
    edge    (m,) int32   pixels that have sub-samples, ascending
    sub     4 m rays
    """

    shape: tuple[int, int]
    centre: Seen
    edge: NDArray[np.int32]
    sub: Seen


class Maps(NamedTuple):
    """View maps and vectors of all materials, for kernels.

    first     (materials,) int64    row of the first vertex's first vector
    vertex    (materials,) int64    the first vertex
    terms     (materials,) int32    K
    size      (materials,) int32    texels along a view map
    texel     (materials,) int64    its first texel in `h`
    textured  (materials,) bool     see `Terms`
    h         (texels, 3) float32   view maps, of every material texel by texel, of every texel term by term
    """

    first: NDArray[np.int64]
    vertex: NDArray[np.int64]
    terms: NDArray[np.int32]
    size: NDArray[np.int32]
    texel: NDArray[np.int64]
    textured: NDArray[np.bool_]
    h: NDArray[np.float32]


def look(scene: Scene, camera: Camera, step: int = 1) -> View:
    """What the camera sees through every step-th pixel of every step-th row."""
    x, y = np.arange(0, camera.width, step) + 0.5, np.arange(0, camera.height, step) + 0.5
    shape = (len(y), len(x))
    x, y = np.tile(x, len(y)), np.repeat(y, len(x))
    centre = _see(scene, camera, x, y)
    if step > 1:
        return View(shape, centre, np.zeros(0, np.int32), _see(scene, camera, x[:0], y[:0]))
    edge = np.zeros(len(x), np.bool_)
    _find_edges(scene.geometry, centre, np.asarray(camera.position), shape[1], edge)
    pixel = np.flatnonzero(edge).astype(np.int32)
    sx, sy = ((a[pixel, None] + SUBSAMPLES[:, axis]).ravel() for axis, a in enumerate((x, y)))
    return View(shape, centre, pixel, _see(scene, camera, sx, sy))


def _see(scene: Scene, camera: Camera, x: NDArray[np.float64], y: NDArray[np.float64]) -> Seen:
    away = camera.directions(x, y)
    hits = scene.rays.intersect(np.tile(np.float32(camera.position), (len(away), 1)), away)
    return Seen(hits.triangle, hits.b1, hits.b2, away)


@njit(cache=True, nogil=True)
def _find_edges(geometry, seen, eye, width, edge):
    """Mark pixels beside which another object, material, normal or depth is seen."""
    height = edge.shape[0] // width
    e = (eye[0], eye[1], eye[2])
    for y in range(height):
        for x in range(width):
            i = y * width + x
            for j in (i + 1 if x + 1 < width else i, i + width if y + 1 < height else i):
                if j != i and _apart(geometry, seen, e, i, j):
                    edge[i] = edge[j] = True


@njit(nogil=True)
def _apart(geometry, seen, eye, i, j):
    a, b = seen.triangle[i], seen.triangle[j]
    if a == b:
        return False
    if a < 0 or b < 0 or geometry.material[a] != geometry.material[b]:
        return True
    if geometry.object[a] != geometry.object[b]:
        return True
    na, nb = surface.geometric_normal(geometry, a), surface.geometric_normal(geometry, b)
    if dot(na, nb) < SAME_NORMAL:
        return True
    p = surface.position(geometry, a, seen.b1[i], seen.b2[i])
    q = surface.position(geometry, b, seen.b1[j], seen.b2[j])
    far = sub(p, eye)
    off = min(abs(dot(sub(q, p), na)), abs(dot(sub(q, p), nb)))
    return off * off > SAME_DEPTH * SAME_DEPTH * dot(far, far)


def stack_maps(terms: list[Terms], firsts: list[int], vertices: list[int]) -> Maps:
    """`Maps` of the materials' terms; firsts and vertices as there."""
    views = [t.view.reshape(-1, 3) for t in terms]
    return Maps(
        np.array(firsts, np.int64),
        np.array(vertices, np.int64),
        np.array([t.count for t in terms], np.int32),
        np.array([t.view.shape[0] for t in terms], np.int32),
        np.concatenate([[0], np.cumsum([len(v) for v in views])[:-1]]).astype(np.int64),
        np.array([t.textured for t in terms]),
        np.concatenate(views),
    )


def shade(
    scene: Scene,
    vertices: Vertices,
    maps: Maps,
    lit: NDArray[np.float32],
    seen: Seen,
    environment: Environment | None,
) -> NDArray[np.float32]:
    """(m, 3) float32: radiance that comes along the rays.

    lit (rows, 3) float32 holds the light-dependent vectors, term by term of every vertex.
    """
    out = np.zeros((len(seen.triangle), 3), np.float32)
    for_ranges(
        _shade, len(out), scene.geometry, scene.material_table, vertices, maps, lit, seen, out,
        grain=2048,
    )  # fmt: skip
    if environment is not None:
        beyond = np.flatnonzero(seen.triangle < 0)
        out[beyond] = seen_radiance(environment, places_on_map(seen.away[beyond]))
    return out


@njit(cache=True, nogil=True)
def _shade(start, stop, geometry, materials, vertices, maps, lit, seen, out):
    geometry, materials, maps = borrow(geometry), borrow(materials), borrow(maps)
    vertices, seen = borrow(vertices), borrow(seen)
    row = np.zeros(materials.row.shape[1], np.float32)
    for i in range(start, stop):
        t = seen.triangle[i]
        if t < 0:
            continue
        m, w = geometry.material[t], scale(vec(seen.away, i), -1.0)
        colour = (0.0, 0.0, 0.0)
        if dot(surface.geometric_normal(geometry, t), w) > 0.0:
            tint = (1.0, 1.0, 1.0)
            if maps.textured[m]:
                surface.parameters(
                    geometry, materials, t, seen.b1[i], seen.b2[i], vec(seen.away, i), row
                )
                tint = diffuse_colour(row)
            colour = _reflected(vertices, maps, lit, t, seen.b1[i], seen.b2[i], m, w, tint)
        for c in range(3):
            out[i, c] = max(0.0, colour[c]) + materials.emission[m, c]


@njit(nogil=True)
def _reflected(vertices, maps, lit, t, b1, b2, m, w, tint):
    """Radiance towards w from the vectors at a triangle's corners (eq. 5)."""
    k = maps.terms[m]
    first = maps.first[m] - maps.vertex[m] * k
    a, b, c = vertices.corners[t]
    rows = (first + a * k, first + b * k, first + c * k)
    weights = (1.0 - b1 - b2, np.float64(b1), np.float64(b2))
    if maps.size[m] == 1:
        g = _mixed(lit, rows, weights, 0)
        h = vec(maps.h, maps.texel[m])
        return mul(mul(g, h), tint)
    if vertices.smooth[t]:
        n = _between(vertices.normal, (a, b, c), weights)
        s = _between(vertices.tangent, (a, b, c), weights)
        s = normalize(sub(s, scale(n, dot(s, n))))
        return _sum_of_terms(maps, lit, m, k, rows, weights, (s, cross(n, s), n), w, tint)
    # Frames that turn by too much to go between: each corner in its own.
    total = (0.0, 0.0, 0.0)
    for corner in range(3):
        own = frame(vertices.normal, vertices.tangent, (a, b, c)[corner])
        one = (weights[corner], 0.0, 0.0)
        here = (rows[corner], rows[corner], rows[corner])
        total = add(total, _sum_of_terms(maps, lit, m, k, here, one, own, w, tint))
    return total


@njit(nogil=True)
def _sum_of_terms(maps, lit, m, k, rows, weights, axes, w, tint):
    """Σ_k h_k g_k with the direction w in the frame `axes`."""
    x, y, z = to_local(w, axes[0], axes[1], axes[2])
    size = maps.size[m]
    taps, (fx, fy) = disk_taps(normalize((x, y, max(z, LOWEST))), size)
    parts = ((1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy)
    total = (0.0, 0.0, 0.0)
    for term in range(k):
        h = (0.0, 0.0, 0.0)
        for corner in range(4):
            texel = maps.texel[m] + taps[corner] * k + term
            h = add(h, scale(vec(maps.h, texel), parts[corner]))
        if term == 0:
            h = mul(h, tint)
        total = add(total, mul(h, _mixed(lit, rows, weights, term)))
    return total


@njit(nogil=True)
def _mixed(lit, rows, weights, term):
    return add(
        add(
            scale(vec(lit, rows[0] + term), weights[0]), scale(vec(lit, rows[1] + term), weights[1])
        ),
        scale(vec(lit, rows[2] + term), weights[2]),
    )


@njit(nogil=True)
def _between(values, corners, weights):
    """Unit mean of three vectors."""
    return normalize(
        add(
            add(
                scale(vec(values, corners[0]), weights[0]),
                scale(vec(values, corners[1]), weights[1]),
            ),
            scale(vec(values, corners[2]), weights[2]),
        )
    )
