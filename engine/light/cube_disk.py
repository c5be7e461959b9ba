"""How much of every texel of a cube map an environment's area light covers.

Texels are inside, outside, or at the rim, and those at the rim are looked at by fine places. What
these find is scaled so that all texels together cover the disk's own solid angle: the light has its
whole energy wherever it stands, poles, edges and corners of the cube included.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light.far_disk import Disk, radius_of
from engine.numerics import cube_map

FINE = 1024  # places along a face


def covered(disk: Disk, n: int) -> NDArray[np.float32]:
    """(6 n²,) float32: the part of the texels' solid angles that lies in the disk."""
    out = np.zeros(cube_map.FACES * n * n, np.float32)
    x, y = cube_map.coordinates(n)
    _cover(
        np.array(disk.axis), radius_of(disk), 2 * math.pi * disk.versine, cube_map.directions(n),
        cube_map.solid_angles(n), x, y, max(1, FINE // n), out,
    )  # fmt: skip
    return out


AHEAD, RIGHT, DOWN = cube_map.AHEAD, cube_map.RIGHT, cube_map.DOWN


@njit(cache=True, nogil=True)
def _cover(axis, radius, whole, directions, solid, x, y, side, out):
    per_face = x.shape[0]
    n = int(math.sqrt(per_face))
    reach = math.sqrt(2.0) / n  # no texel is wider
    inner, outer = math.cos(max(0.0, radius - reach)), math.cos(min(math.pi, radius + reach))
    rim, inside, found = math.cos(radius), 0.0, 0.0
    for t in range(out.shape[0]):
        d = directions[t]
        cosine = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]
        if cosine < outer:
            continue
        if radius > reach and cosine > inner:
            out[t] = 1.0
            inside += solid[t]
            continue
        face, k = t // per_face, t % per_face
        part = _part(axis, rim, face, x[k], y[k], n, side)
        out[t] = -part
        found += part * solid[t]
    # Those at the rim share what is left of the disk.
    share = (whole - inside) / found if found > 0.0 else 0.0
    for t in range(out.shape[0]):
        if out[t] < 0.0:
            out[t] *= -share


@njit
def _part(axis, rim, face, x, y, n, side):
    """Part of a texel's solid angle within the rim, by side² places."""
    within = every = 0.0
    for j in range(side):
        b = 2.0 * (y + (j + 0.5) / side) / n - 1.0
        for i in range(side):
            a = 2.0 * (x + (i + 0.5) / side) / n - 1.0
            length2 = 1.0 + a * a + b * b
            weight = 1.0 / (length2 * math.sqrt(length2))
            every += weight
            cosine = 0.0
            for c in range(3):
                cosine += axis[c] * (AHEAD[face, c] + a * RIGHT[face, c] + b * DOWN[face, c])
            if cosine * cosine >= rim * rim * length2 and cosine > 0.0:
                within += weight
    return within / every
