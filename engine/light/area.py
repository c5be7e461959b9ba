"""A rectangle that shines from one side; `intensity` is its radiance, W·sr⁻¹·m⁻².

Every point of the side that the normal leaves emits the same radiance in every direction. The
lamp is no part of the geometry: it casts no shadow and reflects nothing.

It is sampled evenly over the solid angle it fills (Ureña, Fajardo, King 2013, *An Area-Preserving
Parametrization for Spherical Rectangles*), so that a sample never weighs more than 2π L, however
near the lamp is. Seen from afar that is all but the same as evenly over its area, which takes a
quarter of the time.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.light.base import DARK, EXTRA, UNKNOWN, Light, across, shares_plane, towards, unit
from engine.numerics.angles import angle_over_sine
from engine.numerics.description import Point
from engine.numerics.vec import cross, dot, length

NEAREST = 1e-9  # metres in front of the lamp, below which x lies in its plane and gets nothing
CLOSE = 0.75  # diagonals, below which a `glance` is not spread evenly over the area
FAR = 2.5  # of the lamp's diagonal: from there on r varies by a fifth each way over the lamp
VERY_FAR = 4.0  # diagonals, from where four points stand for all, to 2e-4
SMALL = 1e-6  # steradians below which the difference of angles loses its digits
Size = Annotated[float, Field(ge=1e-4, le=1e6)]


class AreaLight(Light):
    """A one-sided rectangular lamp; intensity is its radiance, in W·sr⁻¹·m⁻²."""

    type: Literal["area"] = "area"
    position: Annotated[Point, Field(description="its centre")]
    target: Annotated[Point, Field(description="a point straight in front of it")]
    up: Annotated[
        Point,
        Field(description="where its height runs; along z if this is parallel to the normal"),
    ] = (0.0, 1.0, 0.0)
    width: Annotated[Size, Field(description="metres, across up")] = 1.0
    height: Annotated[Size, Field(description="metres, along up")] = 1.0

    has_extent: ClassVar[bool] = True

    @model_validator(mode="after")
    def _has_a_front(self) -> AreaLight:
        towards(self.position, self.target)
        unit(self.up, "up is zero")
        return self

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`; then the unit vectors along width and height, half sizes, area."""
        normal = towards(self.position, self.target)
        row = self.start(self.position, normal)
        row[EXTRA : EXTRA + 3], row[EXTRA + 3 : EXTRA + 6] = across(normal, self.up)
        row[EXTRA + 6 : EXTRA + 9] = self.width / 2, self.height / 2, self.width * self.height
        return row


@njit
def _seen(p, x):
    """(x0, x1, y0, y1, z): the rectangle's sides and how far x is in front of it.

    In the rectangle's own axes, with x at the origin; z ≤ 0 where x is behind.
    """
    cx, cy, cz = p[0] - x[0], p[1] - x[1], p[2] - x[2]
    a = cx * p[9] + cy * p[10] + cz * p[11]
    b = cx * p[12] + cy * p[13] + cz * p[14]
    z = -(cx * p[3] + cy * p[4] + cz * p[5])
    return a - p[15], a + p[15], b - p[16], b + p[16], z


@njit
def _angles(x0, x1, y0, y1, z, far):
    """(solid angle, k, b0, b1) of Ureña, Fajardo, King 2013, §4; zeros from `far` diagonals on.

    The solid angle is the sum of the spherical rectangle's four inner angles less 2π. The planes
    through the origin and the sides have normals along (0, z, y0), (z, 0, x1), (0, z, y1),
    (z, 0, x0), up to sign.
    """
    a, b, dx, dy = (x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0
    if a * a + b * b + z * z > far * far * (dx * dx + dy * dy):
        return 0.0, 0.0, 0.0, 0.0
    n0, n2 = math.sqrt(z * z + y0 * y0), math.sqrt(z * z + y1 * y1)
    n1, n3 = math.sqrt(z * z + x1 * x1), math.sqrt(z * z + x0 * x0)
    g0 = math.acos(max(-1.0, min(1.0, y0 * x1 / (n0 * n1))))
    g1 = math.acos(max(-1.0, min(1.0, -x1 * y1 / (n1 * n2))))
    g2 = math.acos(max(-1.0, min(1.0, y1 * x0 / (n2 * n3))))
    g3 = math.acos(max(-1.0, min(1.0, -x0 * y0 / (n3 * n0))))
    k = 2.0 * math.pi - g2 - g3
    solid = g0 + g1 - k
    return (solid, k, -y0 / n0, y1 / n2) if solid > SMALL else (0.0, 0.0, 0.0, 0.0)


@njit
def _point(x0, x1, y0, y1, z, k, solid, b0, b1, u1, u2):
    """(a, b) on the rectangle, uniform over its solid angle (ibid., §4.1 and §4.2)."""
    # The column: its part of the solid angle grows evenly with u1.
    phi = u1 * solid + k
    s, f = math.sin(phi), math.cos(phi) * b0 - b1
    c = math.copysign(s / max(1e-30, math.sqrt(f * f + b0 * b0 * s * s)), s * f)
    c = max(-1.0, min(1.0, c))
    a = max(x0, min(x1, c * z / math.sqrt(max(1e-30, 1.0 - c * c))))
    # The height in it: the sine of its elevation grows evenly with u2.
    d2 = a * a + z * z
    h0, h1 = y0 / math.sqrt(d2 + y0 * y0), y1 / math.sqrt(d2 + y1 * y1)
    h = h0 + u2 * (h1 - h0)
    b = max(y0, min(y1, h * math.sqrt(d2 / max(1e-30, 1.0 - h * h))))
    return a, b


@njit
def _shine(p, x, u1, u2, far):
    """Uniform over the solid angle, L · solid angle; from `far` diagonals on over the area."""
    x0, x1, y0, y1, z = _seen(p, x)
    if z < NEAREST:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    weight, k, b0, b1 = _angles(x0, x1, y0, y1, z, far)
    if weight == 0.0:
        a, b = x0 + u1 * (x1 - x0), y0 + u2 * (y1 - y0)
        r = math.sqrt(a * a + b * b + z * z)
        weight = p[17] * z / (r * r * r)
    else:
        a, b = _point(x0, x1, y0, y1, z, k, weight, b0, b1, u1, u2)
        r = math.sqrt(a * a + b * b + z * z)
    a, b, c = a / r, b / r, z / r
    return (
        a * p[9] + b * p[12] - c * p[3],
        a * p[10] + b * p[13] - c * p[4],
        a * p[11] + b * p[14] - c * p[5],
        r,
        p[6] * weight,
        p[7] * weight,
        p[8] * weight,
    )


@njit
def illuminate(p, texels, x, size, u1, u2):
    """Uniform over the solid angle, L · solid angle; from far away over the area instead."""
    return _shine(p, x, u1, u2, FAR)


@njit
def glance(p, texels, x, size, u1, u2):
    """Evenly over the area from a little way off already."""
    return _shine(p, x, u1, u2, CLOSE)


@njit
def irradiance(p, x, n, g):
    """Lambert's formula for polygons (1760), with the part below the horizon cut off."""
    x0, x1, y0, y1, z = _seen(p, x)
    if z < NEAREST:
        return DARK
    n, g = _in_axes(p, n), _in_axes(p, g)
    # How high the lowest and highest corners are over the horizons.
    a, b, dx, dy = 0.5 * (x0 + x1), 0.5 * (y0 + y1), x1 - x0, y1 - y0
    up, reach = a * n[0] + b * n[1] + z * n[2], 0.5 * (dx * abs(n[0]) + dy * abs(n[1]))
    high, wide = a * g[0] + b * g[1] + z * g[2], 0.5 * (dx * abs(g[0]) + dy * abs(g[1]))
    if up <= -reach or high <= -wide:
        return DARK
    if high < wide and not shares_plane(n, g):
        return UNKNOWN
    if up < reach:
        e = _cut(x0, x1, y0, y1, z, n)
    elif a * a + b * b + z * z > VERY_FAR * VERY_FAR * (dx * dx + dy * dy):
        e = _from_afar(a, b, dx, dy, z, n)
    else:
        e = _whole(x0, x1, y0, y1, z, n)
    return (p[6] * e, p[7] * e, p[8] * e)


@njit
def _in_axes(p, w):
    """A direction in the rectangle's own axes, in which x looks up to it along z."""
    return (
        w[0] * p[9] + w[1] * p[10] + w[2] * p[11],
        w[0] * p[12] + w[1] * p[13] + w[2] * p[14],
        -(w[0] * p[3] + w[1] * p[4] + w[2] * p[5]),
    )


@njit
def _whole(x0, x1, y0, y1, z, n):
    """½ Σ n · (a × b) / |a × b| · angle of a and b, over the sides from a to b."""
    x02, x12, y02, y12, z2 = x0 * x0, x1 * x1, y0 * y0, y1 * y1, z * z
    i00, i10 = 1.0 / math.sqrt(x02 + y02 + z2), 1.0 / math.sqrt(x12 + y02 + z2)
    i01, i11 = 1.0 / math.sqrt(x02 + y12 + z2), 1.0 / math.sqrt(x12 + y12 + z2)
    x01, y01 = x0 * x1 + z2, y0 * y1 + z2
    low, high = i00 * i10, i01 * i11
    left, right = i00 * i01, i10 * i11
    along = (z * n[1] - y0 * n[2]) * low * angle_over_sine((x01 + y02) * low)
    along -= (z * n[1] - y1 * n[2]) * high * angle_over_sine((x01 + y12) * high)
    up = (x1 * n[2] - z * n[0]) * right * angle_over_sine((x12 + y01) * right)
    up -= (x0 * n[2] - z * n[0]) * left * angle_over_sine((x02 + y01) * left)
    return max(0.0, 0.5 * ((x1 - x0) * along + (y1 - y0) * up))


@njit
def _from_afar(a, b, dx, dy, z, n):
    """Gauss's four points."""
    e = 0.0
    for sx in (-0.28867513459481287, 0.28867513459481287):
        for sy in (-0.28867513459481287, 0.28867513459481287):
            x, y = a + sx * dx, b + sy * dy
            r2 = x * x + y * y + z * z
            e += (x * n[0] + y * n[1] + z * n[2]) / (r2 * r2)
    return 0.25 * dx * dy * z * e


@njit
def _cut(x0, x1, y0, y1, z, n):
    """The same sum over the part above the horizon, whose last side lies in it."""
    corners = ((x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z))
    e, comes, goes = 0.0, corners[0], corners[0]
    for k in range(4):
        a, b = corners[k], corners[(k + 1) % 4]
        ha, hb = dot(a, n), dot(b, n)
        if ha <= 0.0 and hb <= 0.0:
            continue
        t = ha / (ha - hb) if ha != hb else 0.0
        between = (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), z)
        if ha <= 0.0:
            a = comes = between
        elif hb <= 0.0:
            b = goes = between
        e += _side(a, b, n)
    return max(0.0, e + _side(goes, comes, n))


@njit
def _side(a, b, n):
    i = 1.0 / (length(a) * length(b))
    return 0.5 * i * dot(n, cross(a, b)) * angle_over_sine(dot(a, b) * i)


@njit
def _hit(p, o, d):
    """(distance, cos θ_light) along a ray to the front of the rectangle; distance < 0: missed."""
    facing = -(d[0] * p[3] + d[1] * p[4] + d[2] * p[5])
    if facing <= 0.0:
        return -1.0, 0.0
    cx, cy, cz = o[0] - p[0], o[1] - p[1], o[2] - p[2]
    t = (cx * p[3] + cy * p[4] + cz * p[5]) / facing
    if t <= 0.0:
        return -1.0, 0.0
    hx, hy, hz = cx + t * d[0], cy + t * d[1], cz + t * d[2]
    if abs(hx * p[9] + hy * p[10] + hz * p[11]) > p[15]:
        return -1.0, 0.0
    if abs(hx * p[12] + hy * p[13] + hz * p[14]) > p[16]:
        return -1.0, 0.0
    return t, facing


@njit
def pdf(p, x, w):
    """1 / solid angle; r² / (area · cos θ_light) from far away."""
    t, facing = _hit(p, x, w)
    if t <= 0.0:
        return 0.0
    x0, x1, y0, y1, z = _seen(p, x)
    if z < NEAREST:
        return 0.0
    solid, _, _, _ = _angles(x0, x1, y0, y1, z, FAR)
    return 1.0 / solid if solid > 0.0 else t * t / (p[17] * facing)


@njit
def emitted(p, o, d):
    """The radiance, where the ray meets the front."""
    t, _ = _hit(p, o, d)
    if t <= 0.0:
        return (-1.0, 0.0, 0.0, 0.0)
    return (t, float(p[6]), float(p[7]), float(p[8]))
