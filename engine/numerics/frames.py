"""Local frames: z is the normal; the tangent comes from a stereographic projection.

`glossy_prt` (Wang, Tran, Luebke 2006) §3.3.2: one formula for the tangent of every normal, with a
single discontinuity at n = (0, -1, 0), where the x axis is taken instead.
"""

from __future__ import annotations

from numba import njit

from engine.numerics.vec import cross, dot, normalize


@njit
def tangents(n):
    """(s, t) for a unit normal n: s, t, n is right-handed and orthonormal.

    s ∝ [(n_y+1)² + n_z² - n_x², -2(n_y+1) n_x, -2 n_x n_z], t = n × s.
    """
    m = n[0] * n[0] + n[2] * n[2]
    # n_y + 1 loses its digits near n_y = -1, where it is m / (1 - n_y).
    a = n[1] + 1.0 if n[1] > 0.0 else m / (1.0 - n[1])
    if m < 1e-20:
        s = (1.0, 0.0, 0.0)
    else:
        s = normalize((a * a + n[2] * n[2] - n[0] * n[0], -2.0 * a * n[0], -2.0 * n[0] * n[2]))
    return s, cross(n, s)


@njit
def to_local(w, s, t, n):
    """World direction w in the frame (s, t, n)."""
    return (dot(w, s), dot(w, t), dot(w, n))


@njit
def to_world(w, s, t, n):
    """Local direction w of the frame (s, t, n) in the world."""
    return (
        w[0] * s[0] + w[1] * t[0] + w[2] * n[0],
        w[0] * s[1] + w[1] * t[1] + w[2] * n[1],
        w[0] * s[2] + w[1] * t[2] + w[2] * n[2],
    )
