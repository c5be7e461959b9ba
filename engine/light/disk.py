"""A disk that shines from one side; `intensity` is its radiance, W·sr⁻¹·m⁻².

Every point of the side that the normal leaves emits the same radiance in every direction. Like the
rectangle it is no part of the geometry.

Seen from x the disk fills an elliptic cone. Its axis halves the angle between the nearest and the
farthest point of the rim, and on a plane at unit distance it cuts out an ellipse with half axes α
(towards the disk's centre) and β (Guillén et al. 2017, *Area-Preserving Parameterizations for
Spherical Ellipses*, §3). With l1, l2 the distances to those two points, R the radius, h the height
of x over the disk and a its distance from the disk's axis,

    tan 2 atan α = 2 R h / (a² + h² - R²),    β² = 4 R² / ((l1 + l2)² - 4 R²).

In polar coordinates about the cone's axis the solid angle is ∫ f(φ) dφ with f = 1 - √(k / (1 + k)),
k = cos²φ / α² + sin²φ / β². The inverse of that is an elliptic integral. Here tan φ = κ tan φ' for
an evenly drawn φ', with κ² = f(π/2) / f(0). This density agrees with f along both axes, and
everywhere for a disk that is far away or seen from its axis; a sample's weight stays near the
solid angle however near and oblique the disk is. Within φ's slice the sample is even.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.light.base import DARK, EXTRA, UNKNOWN, Light, towards
from engine.numerics.description import Point
from engine.numerics.frames import tangents
from engine.numerics.sampling import concentric_disk
from engine.numerics.vec import Vec, cross, dot

NEAREST = 1e-9  # metres in front of the lamp, below which x lies in its plane and gets nothing
CLOSE = 1.0  # radii from its plane below which a `glance` is not spread evenly over the area


class DiskLight(Light):
    """A one-sided round lamp; intensity is its radiance, in W·sr⁻¹·m⁻²."""

    type: Literal["disk"] = "disk"
    position: Annotated[Point, Field(description="its centre")]
    target: Annotated[Point, Field(description="a point straight in front of it")]
    radius: Annotated[float, Field(ge=1e-4, le=1e6, description="metres")] = 0.5

    has_extent: ClassVar[bool] = True

    @model_validator(mode="after")
    def _has_a_front(self) -> DiskLight:
        towards(self.position, self.target)
        return self

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`; then the radius, and the unit vectors across the axis."""
        normal = towards(self.position, self.target)
        row = self.start(self.position, normal)
        row[EXTRA] = self.radius
        s: Vec
        s, t = tangents.py_func(normal)
        row[EXTRA + 1 : EXTRA + 4], row[EXTRA + 4 : EXTRA + 7] = s, t
        return row


@njit
def _cone(p, x):
    """(h, X, Y, Z, 1/α², 1/β²): x's height and the cone's frame in the world, Z its axis.

    h is -1 where x is behind the disk or in its plane.
    """
    n = (np.float64(p[3]), np.float64(p[4]), np.float64(p[5]))
    cx, cy, cz = p[0] - x[0], p[1] - x[1], p[2] - x[2]
    h = -(cx * n[0] + cy * n[1] + cz * n[2])
    # Across the disk's axis, from x's foot to the centre.
    ex, ey, ez = cx + h * n[0], cy + h * n[1], cz + h * n[2]
    a, radius = math.sqrt(ex * ex + ey * ey + ez * ez), np.float64(p[9])
    if a > 1e-12 * (h + radius):
        e = (ex / a, ey / a, ez / a)
    else:
        e, _ = tangents(n)
        a = 0.0
    if h < NEAREST:
        return -1.0, e, e, n, 0.0, 0.0
    near, far = math.sqrt((a - radius) ** 2 + h * h), math.sqrt((a + radius) ** 2 + h * h)
    half = 0.5 * math.atan2(2.0 * radius * h, a * a + h * h - radius * radius)
    ia = 1.0 / math.tan(half)
    ib = (near + far) ** 2 / (4.0 * radius * radius) - 1.0
    # The axis: the sum of the unit vectors to both ends, in (e, -n).
    along, down = (a - radius) / near + (a + radius) / far, h / near + h / far
    r = math.sqrt(along * along + down * down)
    s, c = along / r, down / r
    z = (s * e[0] - c * n[0], s * e[1] - c * n[1], s * e[2] - c * n[2])
    xx = (c * e[0] + s * n[0], c * e[1] + s * n[1], c * e[2] + s * n[2])
    return h, xx, cross(z, xx), z, ia * ia, max(ib, 0.0)


@njit
def _height(k):
    """f = 1 - √(k / (1 + k)), with its digits for large k too."""
    return 1.0 / ((1.0 + k) * (1.0 + math.sqrt(k / (1.0 + k))))


@njit
def _density(cosine2, ia, ib):
    """Of a direction whose φ has this cos²: that of φ over f."""
    fa, fb = _height(ia), _height(ib)
    k = cosine2 * ia + (1.0 - cosine2) * ib
    kappa = math.sqrt(fb / fa)
    turn = kappa / (kappa * kappa * cosine2 + 1.0 - cosine2)
    return turn / (2.0 * math.pi * _height(k))


@njit
def illuminate(p, texels, x, size, u1, u2):
    """L / density, about L · solid angle."""
    h, ex, ey, ez, ia, ib = _cone(p, x)
    if h < 0.0:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    a, b = concentric_disk(u1, u2)
    v = a * a + b * b
    b *= math.sqrt(_height(ib) / _height(ia))
    r2 = a * a + b * b
    cosine2 = a * a / r2 if r2 > 0.0 else 1.0
    r = math.sqrt(r2) if r2 > 0.0 else 1.0
    drop = v * _height(cosine2 * ia + (1.0 - cosine2) * ib)
    s, c = math.sqrt(drop * (2.0 - drop)) / r, 1.0 - drop
    w = (
        s * (a * ex[0] + b * ey[0]) + c * ez[0],
        s * (a * ex[1] + b * ey[1]) + c * ez[1],
        s * (a * ex[2] + b * ey[2]) + c * ez[2],
    )
    facing = -(w[0] * p[3] + w[1] * p[4] + w[2] * p[5])
    if facing <= 0.0:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    weight = 1.0 / _density(cosine2, ia, ib)
    return (w[0], w[1], w[2], h / facing, p[6] * weight, p[7] * weight, p[8] * weight)


@njit
def _hit(p, o, d):
    """Distance along a ray to the front of the disk, -1 where it misses."""
    facing = -(d[0] * p[3] + d[1] * p[4] + d[2] * p[5])
    if facing <= 0.0:
        return -1.0
    cx, cy, cz = o[0] - p[0], o[1] - p[1], o[2] - p[2]
    t = (cx * p[3] + cy * p[4] + cz * p[5]) / facing
    if t <= 0.0:
        return -1.0
    hx, hy, hz = cx + t * d[0], cy + t * d[1], cz + t * d[2]
    return t if hx * hx + hy * hy + hz * hz <= p[9] * p[9] else -1.0


@njit
def pdf(p, x, w):
    """See the module."""
    if _hit(p, x, w) <= 0.0:
        return 0.0
    h, ex, ey, _, ia, ib = _cone(p, x)
    if h < 0.0:
        return 0.0
    a = w[0] * ex[0] + w[1] * ex[1] + w[2] * ex[2]
    b = w[0] * ey[0] + w[1] * ey[1] + w[2] * ey[2]
    r2 = a * a + b * b
    return _density(a * a / r2 if r2 > 0.0 else 1.0, ia, ib)


@njit
def emitted(p, o, d):
    """The radiance, where the ray meets the front."""
    t = _hit(p, o, d)
    if t <= 0.0:
        return (-1.0, 0.0, 0.0, 0.0)
    return (t, float(p[6]), float(p[7]), float(p[8]))


@njit
def irradiance(p, x, n, g):
    """Of a whole disk, that no horizon cuts: its irradiance is linear in the normal.

    With P = a² + h² + R² and S² = P² - 4 a² R², a surface that faces the disk's plane receives
    π L R² (P + S - 2 a²) / (S (P + S)), one that faces its axis 2 π L R² h a / (S (P + S)), in
    which nothing cancels; other normals as much of both (Hamilton and Morgan 1952, *Radiant-
    Interchange Configuration Factors*).
    """
    m = (np.float64(p[3]), np.float64(p[4]), np.float64(p[5]))
    c = (p[0] - x[0], p[1] - x[1], p[2] - x[2])
    h, radius2 = -dot(c, m), np.float64(p[9]) * p[9]
    if h < NEAREST:
        return DARK
    # How high the disk's lowest and highest points are over the horizons.
    facing, over = dot(n, m), dot(g, m)
    up, reach = dot(n, c), math.sqrt(radius2 * max(0.0, 1.0 - facing * facing))
    high, wide = dot(g, c), math.sqrt(radius2 * max(0.0, 1.0 - over * over))
    if up <= -reach or high <= -wide:
        return DARK
    if up < reach or high < wide:
        return UNKNOWN
    h2 = h * h
    a2 = max(0.0, dot(c, c) - h2)
    total, q = a2 + h2 + radius2, h2 + radius2 - a2
    s = math.sqrt(q * q + 4.0 * a2 * h2)
    down = q + s if q > 0.0 else 4.0 * a2 * h2 / (s - q)
    # n · e a = n · c + h n · m, for c = a e - h m.
    k = math.pi * radius2 / (s * (total + s))
    e = k * (2.0 * h * (up + h * facing) - down * facing)
    return (p[6] * e, p[7] * e, p[8] * e)


@njit
def glance(p, texels, x, size, u1, u2):
    """Evenly over the area, from CLOSE by as `illuminate`."""
    a, b = concentric_disk(u1, u2)
    a, b = a * p[9], b * p[9]
    dx = p[0] - x[0] + a * p[10] + b * p[13]
    dy = p[1] - x[1] + a * p[11] + b * p[14]
    dz = p[2] - x[2] + a * p[12] + b * p[15]
    h = -(dx * p[3] + dy * p[4] + dz * p[5])
    if h < CLOSE * p[9]:
        return illuminate(p, texels, x, size, u1, u2)
    r2 = dx * dx + dy * dy + dz * dz
    i = 1.0 / math.sqrt(r2)
    k = math.pi * p[9] * p[9] * h * i / r2
    return (dx * i, dy * i, dz * i, r2 * i, p[6] * k, p[7] * k, p[8] * k)
