"""Barzel's light: every control that a lighting artist asked for, each of them a factor.

Barzel 1997, *Lighting Controls for Computer Cinematography* (Journal of Graphics Tools 2, 1), known
as the uberlight since the RenderMan shader of that name. `intensity` is the irradiance of a surface
that faces the light at the reference distance, W·m⁻², and the light that arrives is

    E = intensity · shape · slice · falloff · spread · blocker.

With smooth(a, b, t) = 3s² - 2s³ of s = (t - a) / (b - a) held to [0, 1], and the position of x in
the light's own axes, (X, Y) across and z along its axis:

shape    cross-section of the beam, at (X, Y) = (X, Y) / z for rays that part, in metres for
         parallel ones. Between two superellipses (|X| / a)^m + (|Y| / b)^m = 1, m = 2 / roundness,
         the outer one wider by `edge` both ways, the light falls to 0 (§3.1.2). With
         q = ((|X| / a)^m + (|Y| / b)^m)^(-1/m), the ray through (X, Y) leaves the inner one at q
         (X, Y) and the outer one, with r alike, at r (X, Y): shape = 1 - smooth(q, r, 1).
         Roundness 1 is an ellipse; 0 a rectangle, whose edges are smooth(a, a + edge, |X|) and the
         same for Y.
slice    smooth(cut_on - near_edge, cut_on, z) · (1 - smooth(cut_off, cut_off + far_edge, z)), so
         that light begins and ends within the beam (§3.1.4).
falloff  (d / r)^n at distance r, d the reference distance (§3.1.5). With `most` it bends over
         nearer than d and stays below that: most · exp(-s (r / d)^(n / s)) with s = ln(most), which
         has the same value and slope at d.
spread   cos^e of the angle to the axis, e = `beam_exponent` (§3.1.3).
blocker  an opaque card of half sizes a, b at z = `blocker_distance`, with a soft edge, of the shape
         of a rectangle: 1 - the shape above, of where the ray to x passes the card's plane; only
         for what lies behind it (§3.2.2). Sizes of 0 leave it out.

Two of Barzel's controls are not here, because they are not the light's: the colour of shadows, and
which objects are lit. His cookies are the projector's image.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.light.base import (
    EXTRA,
    Light,
    across,
    no_formula,
    no_pdf,
    nothing_emitted,
    towards,
    unit,
)
from engine.numerics.description import Finite, NonNegative, Point, Unit
from engine.numerics.vec import cross

BRIGHTEST = 1e20  # times the intensity, where nothing else bounds it
Distance = Annotated[float, Field(ge=0, le=1e6)]


class UberLight(Light):
    """Barzel's light; intensity is the irradiance at the reference distance, in W·m⁻²."""

    type: Literal["uberlight"] = "uberlight"
    position: Point
    target: Annotated[Point, Field(description="where the axis of the beam points")]
    up: Annotated[
        Point, Field(description="where its height runs; along z if this is along the axis")
    ] = (0.0, 1.0, 0.0)
    parallel: Annotated[
        bool, Field(description="whether its rays are parallel rather than part from its position")
    ] = False
    width: Annotated[
        float, Field(gt=0, le=1e6, description="of the beam, at 1 m where its rays part")
    ] = 0.6
    height: Annotated[float, Field(gt=0, le=1e6, description="of the beam, likewise")] = 0.6
    edge: Annotated[Distance, Field(description="over which it ends, outwards, likewise")] = 0.1
    roundness: Annotated[Unit, Field(description="of the beam: 0 is a rectangle, 1 an ellipse")] = (
        1.0
    )
    cut_on: Annotated[Distance, Field(description="metres along the axis where light begins")] = 0.0
    near_edge: Annotated[Distance, Field(description="metres before, over which it rises")] = 0.0
    cut_off: Annotated[Distance, Field(description="metres along the axis where it ends")] = 1e6
    far_edge: Annotated[Distance, Field(description="metres behind, over which it fades")] = 0.0
    falloff_exponent: Annotated[
        float, Field(ge=0, le=8, description="of the distance: 2 is nature's, 0 is none")
    ] = 2.0
    reference_distance: Annotated[
        float, Field(ge=1e-3, le=1e4, description="metres, where the intensity holds")
    ] = 1.0
    most: Annotated[
        float, Field(ge=0, le=1e9, description="nearer by, times the intensity; 0 is no bound")
    ] = 0.0
    beam_exponent: Annotated[
        float, Field(ge=0, le=1e3, description="how the middle of the beam outshines its rim")
    ] = 0.0
    blocker_distance: Annotated[Distance, Field(description="of a card in the beam, metres")] = 0.5
    blocker_offset: Annotated[
        tuple[Finite, Finite],
        Field(description="of its middle from the axis: right and up, metres"),
    ] = (0.0, 0.0)
    blocker_size: Annotated[
        tuple[NonNegative, NonNegative],
        Field(description="its width and height in metres; 0 leaves it out"),
    ] = (0.0, 0.0)
    blocker_edge: Annotated[
        Distance, Field(description="metres over which its shadow ends, outwards")
    ] = 0.0

    @model_validator(mode="after")
    def _makes_sense(self) -> UberLight:
        towards(self.position, self.target)
        unit(self.up, "up is zero")
        if self.cut_off < self.cut_on:
            raise ValueError("cut_off is nearer than cut_on, so that nothing is lit")
        if 0 < self.most <= 1.01:
            raise ValueError("most must be above 1.01, or 0 for no bound")
        return self

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`; then left, the shape's a, b, edge and m (0 for a rectangle), the four
        distances of the slice, falloff, d and s, spread, whether parallel, and the blocker.
        """
        axis = towards(self.position, self.target)
        row = self.start(self.position, axis)
        row[EXTRA : EXTRA + 3], _ = across(axis, self.up)
        # A superellipse of a high power is a rectangle, and its powers overflow.
        power = 2 / self.roundness if self.roundness > 0.02 else 0.0
        row[12:16] = self.width / 2, self.height / 2, self.edge, power
        row[16:20] = (
            self.cut_on - self.near_edge,
            self.cut_on,
            self.cut_off,
            self.cut_off + self.far_edge,
        )
        row[20:23] = self.falloff_exponent, self.reference_distance, math.log(self.most or 1)
        row[23:25] = self.beam_exponent, self.parallel
        wide, high = self.blocker_size
        row[25] = self.blocker_distance if wide > 0 and high > 0 else 0.0
        row[26:28] = self.blocker_offset
        row[28:31] = wide / 2, high / 2, self.blocker_edge
        return row


@njit
def _smooth(a, b, t):
    """0 up to a, 1 from b, in between 3s² - 2s³."""
    if t <= a:
        return 0.0
    if t >= b:
        return 1.0
    s = (t - a) / (b - a)
    return s * s * (3.0 - 2.0 * s)


@njit
def _inside(x, y, a, b, edge, power):
    """1 in the inner superellipse, 0 outside the outer one; power 0 is a rectangle."""
    x, y = abs(x), abs(y)
    if power == 0.0:
        return (1.0 - _smooth(a, a + edge, x)) * (1.0 - _smooth(b, b + edge, y))
    if x <= 0.5 * a and y <= 0.5 * b:
        return 1.0
    if x >= a + edge or y >= b + edge:
        return 0.0
    inner = ((x / a) ** power + (y / b) ** power) ** (-1.0 / power)
    if inner >= 1.0:
        return 1.0
    x, y = x / (a + edge), y / (b + edge)
    return 1.0 - _smooth(inner, (x**power + y**power) ** (-1.0 / power), 1.0)


@njit
def _falloff(r, n, d, s):
    """(d / r)^n, bent over below d so that it stays under e^s."""
    t = r / d
    if t >= 1.0 or n == 0.0 or s == 0.0:
        return min(t**-n, BRIGHTEST)
    return math.exp(s - s * t ** (n / s))


@njit
def illuminate(p, texels, x, size, u1, u2):
    """The product of the module's factors."""
    dx, dy, dz = x[0] - p[0], x[1] - p[1], x[2] - p[2]
    z = dx * p[3] + dy * p[4] + dz * p[5]
    if z < 1e-10 or z <= p[16] or z >= p[19]:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    # Across the axis: axis × left is up.
    ux, uy, uz = cross((p[3], p[4], p[5]), (p[9], p[10], p[11]))
    right = -(dx * p[9] + dy * p[10] + dz * p[11])
    up = dx * ux + dy * uy + dz * uz
    if p[24] > 0.0:
        wx, wy, wz, r, cosine, part = -p[3], -p[4], -p[5], z, 1.0, 1.0
    else:
        r = math.sqrt(z * z + right * right + up * up)
        wx, wy, wz, cosine, part = -dx / r, -dy / r, -dz / r, z / r, 1.0 / z
    k = _inside(right * part, up * part, p[12], p[13], p[14], p[15])
    k *= _smooth(p[16], p[17], z) * (1.0 - _smooth(p[18], p[19], z))
    if k <= 0.0:
        return (wx, wy, wz, r, 0.0, 0.0, 0.0)
    k *= _falloff(r, p[20], p[21], p[22]) * cosine ** p[23]
    if p[25] > 0.0 and z > p[25]:
        at = 1.0 if p[24] > 0.0 else p[25] / z
        k *= 1.0 - _inside(right * at - p[26], up * at - p[27], p[28], p[29], p[30], 0.0)
    return (wx, wy, wz, r, p[6] * k, p[7] * k, p[8] * k)


pdf, emitted = no_pdf, nothing_emitted
irradiance, glance = no_formula, illuminate
