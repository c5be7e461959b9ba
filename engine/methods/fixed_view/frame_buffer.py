"""The deep frame-buffer: what the fixed camera sees, ready to be lit again and again.

`direct_to_indirect` §3.2, §3.6 (Hašan et al. 2006). Every pixel has one view sample at its centre.
A pixel whose four sub-samples do not lie on one smooth piece of surface is an *edge pixel* and has
those four as well; everywhere else the tangent plane at the centre stands for them. The view sample
of an edge pixel is the one of the five that has most in common with the others, so that a centre
that falls in a crack between triangles speaks for nobody.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.backend.cpu.penumbra import alike_neighbours
from engine.brdf.base import ROW, SPECULAR
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, sub, vec
from engine.scene import surface
from engine.scene.camera import SUBSAMPLES, Camera
from engine.scene.scene import Geometry, MaterialTable, Scene

# A finer grid, for what changes from frame to frame: edges of shadows. It keeps to the square of
# the sub-samples, beyond which nobody has looked whether the surface goes on.
FINE = np.array([[i / 4, j / 4] for j in (-1, 0, 1) for i in (-1, 0, 1)])

# Sub-samples belong together where their normals agree to about 8 degrees and they lie within
# half a pixel's footprint of the centre's tangent plane.
SAME_NORMAL = 0.99
SAME_PLANE = 0.5
TYPICAL_NORMAL = 0.9


@dataclass(frozen=True)
class Points:
    """Surface points to be lit, seen from direction `view`.

    position   (n, 3) float32  world
    normal     (n, 3) float32  unit, shading, on the side of `view`
    geometric  (n, 3) float32  unit, of the flat triangle, on the side of `view`
    view       (n, 3) float32  unit, towards the eye
    model      (n,) int32      BRDF model; -1 where nothing is hit
    row        (n, ROW) float32 BRDF parameters, textures applied
    object     (n,) int32      -1 where nothing is hit
    material   (n,) int32      -1 where nothing is hit
    phase      (n,) uint8      0 to 15, other than the neighbours': from which places on it a light
                               with extent shines here
    size       (n,) float32    metres, width of what each stands for
    """

    position: NDArray[np.float32]
    normal: NDArray[np.float32]
    geometric: NDArray[np.float32]
    view: NDArray[np.float32]
    model: NDArray[np.int32]
    row: NDArray[np.float32]
    object: NDArray[np.int32]
    material: NDArray[np.int32]
    phase: NDArray[np.uint8]
    size: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.model)

    @cached_property
    def matt(self) -> NDArray[np.bool_]:
        """(n,) bool: whether it is a surface without gloss; see `brdf.base.is_matt`."""
        gloss = self.row[:, SPECULAR : SPECULAR + 3]
        return (self.model >= 0) & (gloss[:, 0] <= 0) & (gloss[:, 1] <= 0) & (gloss[:, 2] <= 0)

    def take(self, index: NDArray[np.integer] | slice) -> Points:
        """The points of an index array or slice."""
        return Points(*(getattr(self, name)[index] for name in self.__dataclass_fields__))


def no_points(n: int, room: Points | None = None) -> Points:
    """n points that hit nothing, to be filled in; in the place of others if there are as many."""
    if room is not None and len(room) == n:
        room.__dict__.pop("matt", None)
        for name in ("model", "object", "material"):
            getattr(room, name).fill(-1)
        for name in ("position", "normal", "geometric"):
            getattr(room, name).fill(0)
        return room
    return Points(
        position=np.zeros((n, 3), np.float32),
        normal=np.zeros((n, 3), np.float32),
        geometric=np.zeros((n, 3), np.float32),
        view=np.zeros((n, 3), np.float32),
        model=np.full(n, -1, np.int32),
        row=np.zeros((n, ROW), np.float32),
        object=np.full(n, -1, np.int32),
        material=np.full(n, -1, np.int32),
        phase=np.zeros(n, np.uint8),
        size=np.zeros(n, np.float32),
    )


@dataclass(frozen=True)
class FrameBuffer:
    """View samples of one camera.

    camera   its camera; n = height x width pixels, row by row from the top
    centre   n points, one per pixel
    edge     (m,) int32  pixels that have sub-samples of their own, ascending
    sub      4m points, four per edge pixel
    donor    (4m,) int32 the pixel whose indirect light each sub-sample takes: of the 3 x 3 around
             it the most alike in position and normal (§3.6), so that nothing leaks over edges
    spread   float       width of a pixel at unit distance
    """

    camera: Camera
    centre: Points
    edge: NDArray[np.int32]
    sub: Points
    donor: NDArray[np.int32]
    spread: float

    @cached_property
    def alike(self) -> NDArray[np.uint8]:
        """(n,) uint8: which neighbours lie on one smooth surface, from `alike_neighbours`."""
        c = self.centre
        return alike_neighbours(c.position, c.normal, c.object, c.matt, self.camera.width)


def build(scene: Scene) -> FrameBuffer:
    """Cast the primary rays and find the edge pixels."""
    camera = scene.camera
    n = camera.width * camera.height
    x = np.tile(np.arange(camera.width) + 0.5, camera.height)
    y = np.repeat(np.arange(camera.height) + 0.5, camera.width)
    spread = camera.spread
    centre = look_at(scene, camera.directions(x, y))
    centre.phase[:] = pixel_phase(camera.width, camera.height)

    # Compare the sub-samples of every pixel with its centre, one of the four at a time.
    edge = np.zeros(n, np.bool_)
    prefiltered = np.zeros((n, 6), np.float64)
    for dx, dy in SUBSAMPLES:
        points = look_at(scene, camera.directions(x + dx, y + dy))
        edge |= ~_same_surface(centre, points, np.asarray(camera.position), spread)
        prefiltered += points.row[:, :6]
    # Inside a smooth piece the textures are averaged over the pixel.
    centre.row[~edge, :6] = (prefiltered / len(SUBSAMPLES))[~edge]

    pixel = np.flatnonzero(edge).astype(np.int32)
    sx = (x[pixel, None] + SUBSAMPLES[:, 0]).ravel()
    sy = (y[pixel, None] + SUBSAMPLES[:, 1]).ravel()
    sub = look_at(scene, camera.directions(sx, sy))
    sub.phase[:] = np.tile(np.arange(4, dtype=np.uint8), len(pixel))
    _make_typical(centre, pixel, sub)
    for points, width in ((centre, spread), (sub, spread / 2)):
        points.size[:] = width * np.linalg.norm(points.position - camera.position, axis=1)
    donor = np.repeat(pixel, 4)
    for_ranges(
        _find_donors,
        len(donor),
        camera.width,
        camera.height,
        centre.position,
        centre.normal,
        centre.model,
        sub.position,
        sub.normal,
        sub.model,
        scene.diagonal,
        donor,
    )
    return FrameBuffer(camera, centre, pixel, sub, donor, spread)


@lru_cache(8)
def pixel_phase(width: int, height: int) -> NDArray[np.uint8]:
    """(height x width,) uint8: the phases of pixels, 0 to 15 in every block of 4 x 4.

    The lower two bits tell the pixels of a block of 2 x 2 apart. Not to be written into.
    """
    y, x = np.divmod(np.arange(width * height), width)
    return (x % 2 + 2 * (y % 2) + 4 * (x // 2 % 2) + 8 * (y // 2 % 2)).astype(np.uint8)


def look_at(scene: Scene, directions: NDArray[np.float32]) -> Points:
    """What the camera sees along directions (n, 3) float32, unit."""
    n = len(directions)
    origins = np.tile(np.asarray(scene.camera.position, np.float32), (n, 1))
    hits = scene.rays.intersect(origins, directions)
    points = no_points(n)
    points.view[:] = -directions
    describe(scene.geometry, scene.material_table, hits.triangle, hits.b1, hits.b2, points)
    return points


def describe(
    geometry: Geometry,
    materials: MaterialTable,
    triangle: NDArray[np.int32],
    b1: NDArray[np.float32],
    b2: NDArray[np.float32],
    points: Points,
) -> None:
    """Fill in points whose `view` is known with what rays against it meet.

    triangle (n,) is -1 where that is nothing, b1 and b2 (n,) are barycentrics.
    """
    for_ranges(
        _describe_hits, len(points), geometry, materials, triangle, b1, b2, points.view,
        points.position, points.normal, points.geometric, points.model, points.row, points.object,
        points.material,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def _describe_hits(
    start, stop, geometry, materials, triangle, b1, b2, view,
    position, normal, geometric, model, row, obj, material,
):  # fmt: skip
    geometry, materials, row = borrow(geometry), borrow(materials), borrow(row)
    for i in range(start, stop):
        t = triangle[i]
        if t < 0:
            continue
        p = surface.position(geometry, t, b1[i], b2[i])
        g, s = surface.normals(geometry, materials, t, b1[i], b2[i], vec(view, i))
        model[i] = surface.parameters(geometry, materials, t, b1[i], b2[i], s, row[i])
        obj[i] = geometry.object[t]
        material[i] = geometry.material[t]
        for k in range(3):
            position[i, k] = p[k]
            normal[i, k] = s[k]
            geometric[i, k] = g[k]


def _make_typical(centre: Points, pixel: NDArray[np.int32], sub: Points) -> None:
    """Replace the view samples of edge pixels (m,) by the most typical of their five samples."""
    alike = np.zeros((len(pixel), 5, 5), np.bool_)
    five = [centre.take(pixel), *(sub.take(slice(k, None, 4)) for k in range(4))]
    for a, b in combinations(range(5), 2):
        same = (five[a].object == five[b].object) & (five[a].material == five[b].material)
        same &= np.einsum("ij,ij->i", five[a].normal, five[b].normal) >= TYPICAL_NORMAL
        alike[:, a, b] = alike[:, b, a] = same | (five[a].model < 0) & (five[b].model < 0)
    best = alike.sum(axis=2).argmax(axis=1)  # the first of the best: the centre where it is one
    for k in range(1, 5):
        here = best == k
        for name in ("position", "normal", "geometric", "model", "row", "object", "material"):
            getattr(centre, name)[pixel[here]] = getattr(five[k], name)[here]


def _same_surface(
    a: Points, b: Points, eye: NDArray[np.float64], spread: float
) -> NDArray[np.bool_]:
    """(n,) bool: whether b lies on the smooth piece of surface that a lies on."""
    distance = np.linalg.norm(a.position - eye, axis=1)
    offset = b.position - a.position
    plane = np.abs(np.einsum("ij,ij->i", offset, a.geometric))
    same_normal = np.einsum("ij,ij->i", a.normal, b.normal) > SAME_NORMAL
    hit = a.model >= 0
    close = same_normal & (plane <= SAME_PLANE * spread * distance)
    return (a.object == b.object) & (a.material == b.material) & (close | ~hit)


@njit(cache=True, nogil=True)
def _find_donors(
    start, stop, width, height, position, normal, model, sub_position, sub_normal, sub_model,
    diagonal, donor,
):  # fmt: skip
    for i in range(start, stop):
        if sub_model[i] < 0:
            continue
        px, py = donor[i] % width, donor[i] // width
        best = np.inf
        p, n = vec(sub_position, i), vec(sub_normal, i)
        for y in range(max(0, py - 1), min(height, py + 2)):
            for x in range(max(0, px - 1), min(width, px + 2)):
                j = y * width + x
                if model[j] < 0:
                    continue
                e = sub(vec(position, j), p)
                # Twenty times the weight on position, as in the clusters' distance (eq. 9).
                d = 400.0 * dot(e, e) / (diagonal * diagonal) + 2.0 * (1.0 - dot(n, vec(normal, j)))
                if d < best:
                    best = d
                    donor[i] = j
