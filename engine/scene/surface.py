"""What a ray meets: position, normals and BRDF parameters at a point of a triangle (kernels)."""

from __future__ import annotations

import math

from numba import njit

from engine.brdf.base import GRAIN
from engine.numerics.frames import tangents
from engine.numerics.vec import add, cross, dot, normalize, scale, sub, vec
from engine.scene.description import TEXTURE_SLOTS
from engine.scene.tangents import along_coordinates, grain

NORMAL_MAP = TEXTURE_SLOTS.index("normal")


@njit
def position(geometry, triangle, b1, b2):
    """World position at barycentrics (b1, b2)."""
    a, b, c = geometry.triangles[triangle]
    return add(
        add(
            scale(vec(geometry.positions, a), 1.0 - b1 - b2), scale(vec(geometry.positions, b), b1)
        ),
        scale(vec(geometry.positions, c), b2),
    )


@njit
def geometric_normal(geometry, triangle):
    """Unit normal of the flat triangle, on its counter-clockwise side."""
    return normalize(_across(geometry, triangle))


@njit
def shows_front(geometry, triangle, w):
    """Whether the triangle's counter-clockwise side is seen from direction w."""
    return dot(_across(geometry, triangle), w) > 0.0


@njit
def _across(geometry, triangle):
    """Along the normal, twice as long as the triangle has area."""
    a, b, c = geometry.triangles[triangle]
    pa = vec(geometry.positions, a)
    return cross(sub(vec(geometry.positions, b), pa), sub(vec(geometry.positions, c), pa))


@njit
def _interpolated(values, corners, b1, b2):
    """(u, v) at barycentrics (b1, b2) of three rows of values (n, 2)."""
    a, b, c = corners
    b0 = 1.0 - b1 - b2
    return (
        b0 * values[a, 0] + b1 * values[b, 0] + b2 * values[c, 0],
        b0 * values[a, 1] + b1 * values[b, 1] + b2 * values[c, 1],
    )


@njit
def _bent(geometry, materials, triangle, b1, b2, n):
    """The unit normal n, on the counter-clockwise side, as a normal map has it.

    x of the map runs along ∂x/∂u of the flat triangle, made perpendicular to n, and y along ∂x/∂v.
    Where the texture coordinates are degenerate n stays as it is.
    """
    a, b, c = geometry.triangles[triangle]
    _, _, along_u, along_v, area = along_coordinates(geometry.positions, geometry.uvs, a, b, c)
    side = 1.0 if area > 0.0 else -1.0
    along_u, along_v = scale(along_u, side), scale(along_v, side)
    s = normalize(sub(along_u, scale(n, dot(n, along_u))))
    t = cross(n, s)
    if dot(t, along_v) < 0.0:
        t = scale(t, -1.0)
    if dot(s, s) == 0.0:
        return n
    u, v = _interpolated(geometry.uvs, (a, b, c), b1, b2)
    x, y, z = _texel(materials, materials.maps[geometry.material[triangle], NORMAL_MAP], u, v)
    bent = normalize(
        add(add(scale(s, 2.0 * x - 1.0), scale(t, 2.0 * y - 1.0)), scale(n, 2.0 * z - 1.0))
    )
    return bent if dot(bent, bent) > 0.0 else n


@njit
def normals(geometry, materials, triangle, b1, b2, w):
    """(geometric, shading) unit normals, both turned to the side of the direction w.

    Surfaces are two-sided: light and eye may come from either side and meet the same BRDF. The
    shading normal is bent back where it would face away from w, so that w never lies below it.
    """
    g = geometric_normal(geometry, triangle)
    a, b, c = geometry.triangles[triangle]
    s = normalize(
        add(
            add(
                scale(vec(geometry.normals, a), 1.0 - b1 - b2), scale(vec(geometry.normals, b), b1)
            ),
            scale(vec(geometry.normals, c), b2),
        )
    )
    if dot(s, g) < 0.0:
        s = scale(s, -1.0)
    if materials.maps[geometry.material[triangle], NORMAL_MAP] >= 0:
        s = _bent(geometry, materials, triangle, b1, b2, s)
    if dot(g, w) < 0.0:
        g, s = scale(g, -1.0), scale(s, -1.0)
    below = dot(s, w)
    if below < 1e-3:
        s = normalize(add(s, scale(w, 1e-3 - below)))
    if dot(s, s) == 0.0:
        s = g
    return g, s


@njit
def _texel(materials, texture, u, v):
    """Bilinear, repeating look-up of texture number `texture` at (u, v)."""
    first, width, height = materials.texture[texture]
    x, y = u * width - 0.5, v * height - 0.5
    x0, y0 = math.floor(x), math.floor(y)
    fx, fy = x - x0, y - y0
    r = g = b = 0.0
    for j in range(2):
        for i in range(2):
            w = (fx if i else 1.0 - fx) * (fy if j else 1.0 - fy)
            k = first + (int(y0) + j) % height * width + (int(x0) + i) % width
            r += w * materials.texels[k, 0]
            g += w * materials.texels[k, 1]
            b += w * materials.texels[k, 2]
    return (r, g, b)


@njit
def parameters(geometry, materials, triangle, b1, b2, n, out):
    """Fill out (ROW,) with the BRDF parameters at a point; returns the model's index.

    n is the shading normal there, about whose frame the grain of an anisotropic material is turned.
    """
    m = geometry.material[triangle]
    for k in range(out.shape[0]):
        out[k] = materials.row[m, k]
    if out[GRAIN] != 0.0 or out[GRAIN + 1] != 0.0:
        s, t = tangents(n)
        out[GRAIN], out[GRAIN + 1] = grain(geometry, triangle, b1, b2, s, t)
    if materials.maps[m, 0] >= 0 or materials.maps[m, 1] >= 0 or materials.maps[m, 2] >= 0:
        a, b, c = geometry.triangles[triangle]
        u, v = _interpolated(geometry.uvs, (a, b, c), b1, b2)
        for slot in range(2):
            if materials.maps[m, slot] >= 0:
                t = _texel(materials, materials.maps[m, slot], u, v)
                for k in range(3):
                    out[3 * slot + k] *= t[k]
        if materials.maps[m, 2] >= 0:
            out[6] *= _texel(materials, materials.maps[m, 2], u, v)[0]
    return materials.model[m]
