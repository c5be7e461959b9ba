"""Environment samples: an environment as radiances of directions, in the order of a quad-tree.

`direct_to_indirect` §6 (Hašan et al. 2006): next to the samples on surfaces the gather cloud has
environment samples, whose radiance is a rotated look-up of the map. Here they are the equal cells
of `engine.numerics.octahedron`, so that the Haar basis is on them too. A sample is the mean of the
map over its cell, by a fine grid of places. A turn about +y moves the places along the map's rows:
what they are is found once, and a turned map costs no trigonometry.

An area light is in none of the samples: it is small and sharp, and shines as lights do
(`engine.light.lamps`).
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light.environment import Environment
from engine.light.far_disk import radius_of
from engine.numerics.octahedron import centres
from engine.numerics.parallel import for_ranges

DEPTH = 7  # 16,384 samples, 1.6 degrees wide
FINE = 9  # levels of the grid of places
SPACING = math.sqrt(4 * math.pi / 4**FINE)  # radians from one of them to the next
WIDEST = 1024  # columns; maps with more are averaged down first, which no place would notice
RIM = math.radians(0.1)  # of an area light that is seen: about a pixel, so that it is no staircase


def places_on_map(d: NDArray[np.floating]) -> NDArray[np.float32]:
    """(n, 2) float32: column and row, 0 to 1, where directions d (n, 3) lie on a map not turned."""
    u = 0.5 + np.arctan2(d[:, 0], -d[:, 2]) / (2 * np.pi)
    v = np.arccos(np.clip(d[:, 1], -1, 1)) / np.pi
    return np.stack([u, v], axis=1).astype(np.float32)


def seen_radiance(environment: Environment, places: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n, 3) float32: what the camera sees at `places_on_map`, black without background.

    The map is piecewise constant as in every renderer; the rim of an area light is smooth.
    """
    out = np.zeros((len(places), 3), np.float32)
    if not environment.description.background:
        return out
    for_ranges(_look_up, len(places), *_turned(environment, environment.radiance), places, out)
    if environment.description.area_light is not None:
        disk = environment.disk
        centre = places_on_map(np.array([disk.axis]))[0]
        for_ranges(_add_disk, len(places), centre, radius_of(disk), disk.radiance, places, out)
    return out


def environment_samples(environment: Environment) -> NDArray[np.float32]:
    """(4^DEPTH, 3) float32: mean radiance of the cells of the octahedron."""
    out = np.zeros((4**DEPTH, 3), np.float32)
    radiance, shift, factor = _turned(environment, averaged(environment.radiance))
    for_ranges(_means, len(out), radiance, shift, factor, _fine_places(), SPACING, out, grain=64)
    return out


def averaged(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    """The map (h, w, 3) at WIDEST columns or less, by the mean over solid angle of whole blocks."""
    height, width = radiance.shape[:2]
    factor = -(-width // WIDEST)
    if factor == 1 or height < factor:
        return radiance
    rows = np.arange(0, height, factor)
    edges = np.cos(np.linspace(0, np.pi, height + 1))
    solid = edges[:-1] - edges[1:]
    columns = np.arange(0, width, factor)
    count = np.diff([*columns, width])
    across = np.add.reduceat(radiance, columns, axis=1) / count[:, None]
    down = np.add.reduceat(across * solid[:, None, None], rows, axis=0)
    return (down / np.add.reduceat(solid, rows)[:, None, None]).astype(np.float32)


def _turned(
    environment: Environment, radiance: NDArray[np.float32]
) -> tuple[NDArray[np.float32], float, np.float32]:
    """(map, part of a whole turn, factor on the map)."""
    description = environment.description
    return radiance, description.rotation_degrees / 360 % 1.0, np.float32(description.intensity)


@cache
def _fine_places() -> NDArray[np.float32]:
    """(4^FINE, 3): places on the map, and how much wider along the row each of them is there."""
    places = places_on_map(centres(FINE))
    return np.column_stack([places, 1 / np.sin(np.pi * places[:, 1])]).astype(np.float32)


@njit(cache=True, nogil=True)
def _look_up(start, stop, radiance, shift, factor, places, out):
    height, width = radiance.shape[:2]
    for i in range(start, stop):
        row = min(height - 1, int(places[i, 1] * height))
        column = min(width - 1, int((places[i, 0] + shift) % 1.0 * width))
        for c in range(3):
            out[i, c] = factor * radiance[row, column, c]


@njit(cache=True, nogil=True)
def _add_disk(start, stop, centre, radius, radiance, places, out):
    """Add a disk of a radius, radians, about a place on the map."""
    height = math.pi * centre[1]
    c, s = math.cos(height), math.sin(height)
    for i in range(start, stop):
        v = math.pi * places[i, 1]
        # Most places are nowhere near it.
        if abs(v - height) > radius + RIM:
            continue
        across = 2.0 * math.pi * (places[i, 0] - centre[0])
        cosine = c * math.cos(v) + s * math.sin(v) * math.cos(across)
        away = radius - math.acos(max(-1.0, min(1.0, cosine)))
        cover = max(0.0, min(1.0, 0.5 + away / RIM))
        for k in range(3):
            out[i, k] += cover * radiance[k]


@njit(cache=True, nogil=True)
def _means(start, stop, radiance, shift, factor, places, spacing, out):
    height, width = radiance.shape[:2]
    share = places.shape[0] // out.shape[0]
    down, across = 0.5 * spacing * height / math.pi, 0.25 * spacing * width / math.pi
    for i in range(start, stop):
        red = green = blue = 0.0
        for s in range(i * share, (i + 1) * share):
            # Average over what the place stands for; along a row that is wider near the poles.
            u = places[s, 0] + shift
            x0, x1, tx = _overlap((u - (u >= 1.0)) * width, across * places[s, 2])
            y0, y1, ty = _overlap(np.float64(places[s, 1]) * height, down)
            y0, y1 = max(0, y0), min(height - 1, y1)
            x0, x1 = (x0 + width) % width, x1 % width
            for y, part in ((y0, 1.0 - ty), (y1, ty)):
                if part > 0.0:
                    left, right = part * (1.0 - tx), part * tx
                    red += left * radiance[y, x0, 0] + right * radiance[y, x1, 0]
                    green += left * radiance[y, x0, 1] + right * radiance[y, x1, 1]
                    blue += left * radiance[y, x0, 2] + right * radiance[y, x1, 2]
        out[i, 0], out[i, 1], out[i, 2] = (
            factor * red / share, factor * green / share, factor * blue / share,
        )  # fmt: skip


@njit
def _overlap(x, half):
    """Pixels (i, j) that x ± half overlaps, half at most 1/2, and the part that lies in j."""
    half = min(half, 0.5)
    i = math.floor(x)
    f = x - i
    if f < half:
        return i - 1, i, (f + half) / (2.0 * half)
    if f > 1.0 - half:
        return i, i + 1, (f + half - 1.0) / (2.0 * half)
    return i, i, 0.0
