"""How much of a light the gather cloud catches, against how much it sends to surfaces.

A light that shines from close by, or into a narrow cone, falls between gather samples or on one of
them: indirect light is then too dark or too bright as a whole, and nothing else in a frame shows
it. So rays are shot from the light, and what they carry is compared with what the samples found.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.diagnosis import Diagnosis
from engine.light import table as lights
from engine.light.base import POSITION, Light
from engine.light.table import light_table
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.nearest import Grid, nearest
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_world
from engine.numerics.sampling import uniform_cone
from engine.numerics.vec import add, cross, dot, length, normalize, scale, sub, vec
from engine.scene.scene import Scene

RAYS = 512
FEWEST = 64  # of them that must carry light to say anything
OFF = 0.15  # of the light's own: beyond it the user is told
NEGLIGIBLE = 0.02  # of the picture
FAR, TURNED = 2.0, 0.7  # spacings and cosine to the nearest sample that still speaks for a place
KEPT = 4096
GOLDEN = 0.6180339887498949

illuminate = lights.illuminate


class LightBalance:
    """Compares lights without extent with what the cloud has of them; remembers each light."""

    def __init__(self, scene: Scene, cloud: GatherCloud, grid: Grid) -> None:
        """The cloud is that of the scene, the grid that of the cloud."""
        self._scene, self._cloud, self._grid = scene, cloud, grid
        self._known: OrderedDict[Light, tuple[float, float]] = OrderedDict()

    def __call__(
        self, on: tuple[Light, ...], caught: Callable[[Light], NDArray[np.float32]], later: float
    ) -> Diagnosis | None:
        """What to say of the worst of the lights that are on, or None.

        caught(light) is its direct radiance (n_g, 3) on the cloud; later is the part of all light
        that has bounced, which alone is off.
        """
        found: list[tuple[float, float, Light]] = []
        for light in on:
            if light.enabled and not light.has_extent and "position" in type(light).model_fields:
                found.append((*self.off(light, caught), light))
        if not found:
            return None
        off, due, light = max(found, key=lambda each: abs(each[0]) * each[1])
        size = abs(off) * later * due / max(sum(each[1] for each in found), 1e-30)
        if abs(off) <= OFF or size <= NEGLIGIBLE:
            return None
        spacing = self._cloud.spacing
        return Diagnosis(
            "light_between_samples",
            f"The gather samples, {100 * spacing:.2g} cm apart, catch {100 * abs(off):.0f} % "
            f"{'more' if off > 0 else 'less'} of the light {light.id!r} than it sends out, so its "
            "indirect light is that much too "
            f"{'bright' if off > 0 else 'dark'}; move it off the surface, widen its cone, or set "
            "gather_samples higher.",
            size,
        )

    def off(
        self, light: Light, caught: Callable[[Light], NDArray[np.float32]]
    ) -> tuple[float, float]:
        """(what the cloud reflects of a light beyond what it should, as a part of that; that).

        0 of it where too little of the light falls on sampled surfaces to tell.
        """
        if light not in self._known:
            self._known[light] = self._compare(light, caught(light))
            if len(self._known) > KEPT:
                self._known.popitem(last=False)
        self._known.move_to_end(light)
        return self._known[light]

    def _compare(self, light: Light, radiance: NDArray[np.float32]) -> tuple[float, float]:
        scene, cloud = self._scene, self._cloud
        table = light_table([light])
        row = table.row[0]
        place = np.ascontiguousarray(row[POSITION : POSITION + 3])
        direction = np.zeros((RAYS, 3), np.float32)
        solid_angle = _directions(row, getattr(light, "cone_degrees", 180.0), direction)
        hits = scene.rays.intersect(np.tile(place, (RAYS, 1)), direction)
        found = math.pi * float(cloud.area @ radiance.sum(axis=1, dtype=np.float64))
        due, unsure, carrying = _reflected(
            table.kind[0], row, table.texels, direction, hits.triangle, hits.distance,
            scene.geometry.positions, scene.geometry.triangles, self._grid,
            cloud.points.position, cloud.points.geometric, cloud.albedo,
        )  # fmt: skip
        due, unsure = due * solid_angle / RAYS, unsure * solid_angle / RAYS
        if carrying < FEWEST or due <= unsure:
            return 0.0, due
        # Places that no sample speaks for may be outside of all that is seen, or not.
        surplus = found / due - 1
        return math.copysign(max(0.0, abs(surplus) - unsure / due), surplus), due


@njit(cache=True, nogil=True)
def _directions(row, cone_degrees, out):
    """Fill out (n, 3) with even directions in a light's cone; returns its solid angle."""
    axis = (float(row[3]), float(row[4]), float(row[5]))
    if length(axis) == 0.0:
        axis = (0.0, 0.0, 1.0)
    versine = 1.0 - math.cos(math.radians(min(180.0, cone_degrees)))
    s, t = tangents(axis)
    n = out.shape[0]
    for k in range(n):
        w = uniform_cone((k + 0.5) / n, (k * GOLDEN) % 1.0, versine)
        d = to_world(w, s, t, axis)
        for c in range(3):
            out[k, c] = d[c]
    return 2.0 * math.pi * versine


@njit(cache=True, nogil=True)
def _reflected(
    kind, row, texels, direction, triangle, distance, positions, triangles, grid, leaf_position,
    leaf_normal, albedo,
):  # fmt: skip
    """(sum, part of it, count) over rays of radiant intensity times the albedo where they land.

    The part landed where no sample lies near and faces the same way; count of rays with any light.
    """
    grid, lamp = borrow(grid), borrow(row)
    place = (float(row[0]), float(row[1]), float(row[2]))
    due = unsure = 0.0
    count = 0
    for r in range(direction.shape[0]):
        if triangle[r] < 0:
            continue
        d, far = vec(direction, r), np.float64(distance[r])
        x = add(place, scale(d, far))
        _, _, _, away, red, green, blue = illuminate(kind, lamp, texels, x, 0.0, 0.5, 0.5)
        if red + green + blue <= 0.0:
            continue
        a = vec(positions, triangles[triangle[r], 0])
        g = normalize(
            cross(
                sub(vec(positions, triangles[triangle[r], 1]), a),
                sub(vec(positions, triangles[triangle[r], 2]), a),
            )
        )
        if dot(g, d) > 0.0:
            g = scale(g, -1.0)
        j = nearest(grid, x, g)
        sent = away * away * (red * albedo[j, 0] + green * albedo[j, 1] + blue * albedo[j, 2])
        near = length(sub(vec(leaf_position, j), x)) <= FAR * grid.spacing[j]
        if near and dot(vec(leaf_normal, j), g) >= TURNED:
            due += sent
        else:
            unsure += sent
        count += 1
    return due + unsure, unsure, count
