"""One lamp of every type at known places, and the light contract over arrays."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from engine.light import table
from engine.light.area import AreaLight
from engine.light.base import Light
from engine.light.disk import DiskLight
from engine.light.distant import DistantLight
from engine.light.point import PointLight
from engine.light.projector import ProjectorLight
from engine.light.sphere import SphereLight
from engine.light.spot import SpotLight
from engine.light.sun import SunLight
from engine.light.uberlight import UberLight
from engine.numerics.vec import vec

# Each lamp shines straight or obliquely on the origin.
EXAMPLES: list[Light] = [
    PointLight(id="point", position=(0.3, 2.0, -0.2), intensity=(3.0, 2.0, 1.0)),
    SpotLight(id="spot", position=(1.0, 2.0, 0.5), target=(0, 0, 0), intensity=(3.0, 2.0, 1.0)),
    AreaLight(
        id="area",
        position=(0.5, 1.5, 0.2),
        target=(0, 0, 0),
        width=0.8,
        height=1.7,
        intensity=(3.0, 2.0, 1.0),
    ),
    AreaLight(
        id="far", position=(800, 900, 0), target=(0, 0, 0), width=0.6, intensity=(3.0, 2.0, 1.0)
    ),
    AreaLight(id="ceiling", position=(0, 1, 0), target=(0, 0, 0), intensity=(3.0, 2.0, 1.0)),
    DiskLight(
        id="disk", position=(0.5, 1.5, 0.2), target=(0, 0, 0.7), radius=0.9, intensity=(3, 2, 1)
    ),
    # From its rim at a grazing angle, from close by, and from far away.
    DiskLight(
        id="rim", position=(0.7, 0.3, 0), target=(0.7, 0, 0), radius=0.6, intensity=(3, 2, 1)
    ),
    DiskLight(
        id="close", position=(0.1, 0.4, 0), target=(0.1, 0, 0), radius=2, intensity=(3, 2, 1)
    ),
    DiskLight(
        id="far disk", position=(800, 900, 0), target=(0, 300, 0), radius=0.5, intensity=(3, 2, 1)
    ),
    SphereLight(id="sphere", position=(0.5, 1.5, 0.2), radius=0.4, intensity=(3, 2, 1)),
    SphereLight(id="close sphere", position=(0.3, 0.7, 0.9), radius=0.8, intensity=(3, 2, 1)),
    SphereLight(id="far sphere", position=(800, 900, 0), radius=0.5, intensity=(3, 2, 1)),
    ProjectorLight(
        id="projector",
        position=(-0.5, 1.5, 0.7),
        target=(0.1, 0, 0),
        up=(0, 0, 1),
        intensity=(3.0, 2.0, 1.0),
    ),
    UberLight(
        id="uberlight", position=(0.3, 1.5, 0.7), target=(0.1, 0, 0), intensity=(3.0, 2.0, 1.0)
    ),
    UberLight(
        id="busy",
        position=(0.3, 1.5, 0.7),
        target=(0.1, 0, 0),
        up=(1, 0, 0),
        parallel=True,
        roundness=0.4,
        cut_on=0.2,
        near_edge=0.1,
        cut_off=1.2,
        far_edge=3,
        falloff_exponent=1.3,
        most=4,
        beam_exponent=8,
        blocker_offset=(0.1, 0.05),
        blocker_size=(0.1, 0.3),
        blocker_edge=0.3,
        intensity=(3.0, 2.0, 1.0),
    ),
    SunLight(id="soft sun", direction=(1, -3, 2), diameter_degrees=10, intensity=(3.0, 2.0, 1.0)),
    SunLight(id="own sun", direction=(-1, -3, 1), intensity=(3.0, 2.0, 1.0)),
    DistantLight(id="sun", direction=(1, -3, 2), intensity=(3.0, 2.0, 1.0)),
]
WIDE = [light for light in EXAMPLES if light.has_extent]


def illuminate(light: Light, x: ArrayLike, u: ArrayLike, size: float = 0.0) -> NDArray[np.float64]:
    """(n, 7) of x (n, 3) and u (n, 2), lengths of one repeated."""
    a, b = _same(x, u)
    out = np.zeros((len(a), 7))
    packed = table.light_table([light])
    _illuminate(packed.kind[0], packed.row[0], packed.texels, a, size, b, out)
    return out


def pdf(light: Light, x: ArrayLike, w: ArrayLike) -> NDArray[np.float64]:
    """(n,) of x and w (n, 3)."""
    a, b = _same(x, w)
    out = np.zeros(len(a))
    _pdf(table.INDEX[type(light)], light.row(), a, b, out)
    return out


def emitted(light: Light, o: ArrayLike, d: ArrayLike) -> NDArray[np.float64]:
    """(n, 4) of o and d (n, 3)."""
    a, b = _same(o, d)
    out = np.zeros((len(a), 4))
    _emitted(table.INDEX[type(light)], light.row(), a, b, out)
    return out


def irradiance(light: Light, x: ArrayLike, n: ArrayLike, g: ArrayLike) -> NDArray[np.float64]:
    """(n, 3) of x, n and g (n, 3)."""
    (a, b), (_, c) = _same(x, n), _same(x, g)
    out = np.zeros((len(a), 3))
    _irradiance(table.INDEX[type(light)], light.row(), a, b, c, out)
    return out


def glance(light: Light, x: ArrayLike, u: ArrayLike) -> NDArray[np.float64]:
    """(n, 7) of x (n, 3) and u (n, 2), lengths of one repeated."""
    a, b = _same(x, u)
    out = np.zeros((len(a), 7))
    packed = table.light_table([light])
    _glance(packed.kind[0], packed.row[0], packed.texels, a, b, out)
    return out


def stratified(side: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """(side², 2) jittered numbers."""
    i, j = np.meshgrid(np.arange(side), np.arange(side))
    return (np.column_stack([i.ravel(), j.ravel()]) + rng.random((side * side, 2))) / side


def _same(a: ArrayLike, b: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    a, b = np.atleast_2d(np.asarray(a, float)), np.atleast_2d(np.asarray(b, float))
    n = max(len(a), len(b))
    return (
        np.ascontiguousarray(np.broadcast_to(a, (n, a.shape[1]))),
        np.ascontiguousarray(np.broadcast_to(b, (n, b.shape[1]))),
    )


@njit
def _illuminate(kind, row, texels, x, size, u, out):
    for i in range(len(x)):
        v = table.illuminate(kind, row, texels, vec(x, i), size, u[i, 0], u[i, 1])
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = v[0], v[1], v[2], v[3]
        out[i, 4], out[i, 5], out[i, 6] = v[4], v[5], v[6]


@njit
def _pdf(kind, row, x, w, out):
    for i in range(len(x)):
        out[i] = table.pdf(kind, row, vec(x, i), vec(w, i))


@njit
def _emitted(kind, row, o, d, out):
    for i in range(len(o)):
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = table.emitted(kind, row, vec(o, i), vec(d, i))


@njit
def _irradiance(kind, row, x, n, g, out):
    for i in range(len(x)):
        out[i] = table.irradiance(kind, row, vec(x, i), vec(n, i), vec(g, i))


@njit
def _glance(kind, row, texels, x, u, out):
    for i in range(len(x)):
        v = table.glance(kind, row, texels, vec(x, i), 0.0, u[i, 0], u[i, 1])
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = v[0], v[1], v[2], v[3]
        out[i, 4], out[i, 5], out[i, 6] = v[4], v[5], v[6]
