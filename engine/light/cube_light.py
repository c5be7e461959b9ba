"""An environment as a cube map: the light vector of `glossy_prt` (Wang, Tran, Luebke 2006, §4.3).

A texel holds the mean of the map over its solid angle. What part of each texel each pixel of a
latitude-longitude map covers is found once; a turn about +y then is a shift of the map's columns,
so that it flickers nowhere, has no seam, and is quick. The parts are balanced: a constant map gives
the same constant, and every pixel brings its whole energy, at any angle. An area light is added to
the texels (`cube_disk`), so that moving it never asks for another map.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import block_array, csr_array, diags_array
from scipy.sparse.linalg import cg

from engine.light.cube_disk import covered
from engine.light.environment import Environment
from engine.numerics import cube_map, haar
from engine.numerics.parallel import for_ranges

PIXELS = 8  # columns of the map per texel of a face: two across each texel
PLACES = 8  # along both sides of a pixel, that its parts are found from
PRECISION, ROUNDS = 1e-3, 1000  # of balancing


class Parts(NamedTuple):
    """Which pixels every texel is made of.

    start   (6 n² + 1,) int64   texel t has the entries start[t] to start[t + 1]
    pixel   (q,) int32          row · width + column
    share   (q,) float32        of the texel; those of a texel sum to 1
    """

    start: NDArray[np.int64]
    pixel: NDArray[np.int32]
    share: NDArray[np.float32]


class CubeLight:
    """Environments as cube maps of n x n texels a face; what the last map needed is kept."""

    def __init__(self, n: int) -> None:
        self._n, self._width, self._height = n, PIXELS * n, PIXELS * n // 2
        self._solid = cube_map.solid_angles(n)[:, None].astype(np.float32)
        self._known: NDArray[np.float32] | None = None
        self._map: NDArray[np.float32] = np.zeros((self._height, self._width, 3), np.float32)

    def radiance(self, environment: Environment | None) -> NDArray[np.float32]:
        """(6 n², 3) float32, mean radiance of the texels; None is black."""
        out = np.zeros((cube_map.FACES * self._n**2, 3), np.float32)
        if environment is None:
            return out
        if environment.radiance is not self._known:
            self._map = resampled(environment.radiance, self._height, self._width)
            self._known = environment.radiance
        description = environment.description
        whole, part = divmod(description.rotation_degrees / 360 % 1.0 * self._width, 1.0)
        turned = np.zeros_like(self._map)
        for_ranges(_turn, self._height, self._map, int(whole), part, description.intensity, turned)
        parts = _parts(self._n)
        for_ranges(_mix, len(out), *parts, turned.reshape(-1, 3), out, grain=1024)
        if description.area_light is not None:
            disk = environment.disk
            out += covered(disk, self._n)[:, None] * np.array(disk.radiance, np.float32)
        return out

    def coefficients(self, environment: Environment | None) -> NDArray[np.float32]:
        """(6 n², 3) float32: radiance times solid angle in the Haar basis of every face.

        The solid angle goes with the light, which is kept whole, and not with the transport: what
        that is then left with is smooth wherever visibility is, and needs fewer wavelets.
        """
        return in_haar(self.radiance(environment) * self._solid)


def in_haar(texels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Haar coefficients (6 n², c) of a cube map (6 n², c), face by face."""
    faces = np.split(texels, cube_map.FACES)
    return np.concatenate([haar.forward(face) for face in faces])


def resampled(radiance: NDArray[np.float32], height: int, width: int) -> NDArray[np.float32]:
    """A latitude-longitude map (h, w, 3) as (height, width, 3) float32.

    A pixel becomes the mean, over solid angle, of what it covers: energy is kept.
    """
    rows, columns = radiance.shape[:2]
    across = _means(radiance.astype(np.float64), np.linspace(0, columns, width + 1), axis=1)
    # Rows are equal in angle and their means are over the sine's integral.
    level, wanted = (np.cos(np.pi * np.arange(k + 1) / k) for k in (rows, height))
    edges = np.interp(-wanted, -level, np.arange(rows + 1.0))
    solid = level[:-1] - level[1:]
    share = _sums(solid[:, None, None], edges, axis=0)
    return (_sums(across * solid[:, None, None], edges, axis=0) / share).astype(np.float32)


def _sums(values: NDArray[np.float64], edges: NDArray[np.float64], axis: int) -> NDArray:
    """Integrals of piecewise constant values between edges, in units of their index."""
    values = np.moveaxis(values, axis, 0)
    total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    whole = np.minimum(edges.astype(int), len(values) - 1)
    part = (edges - whole).reshape(-1, *[1] * (values.ndim - 1))
    return np.moveaxis(np.diff(total[whole] + part * values[whole], axis=0), 0, axis)


def _means(values: NDArray[np.float64], edges: NDArray[np.float64], axis: int) -> NDArray:
    shape = [1] * values.ndim
    shape[axis] = -1
    return _sums(values, edges, axis) / np.diff(edges).reshape(shape)


@cache
def _parts(n: int) -> Parts:
    """The parts of a map of PIXELS n columns that is not turned."""
    width, height = PIXELS * n, PIXELS * n // 2
    falls = np.zeros((width * height, PLACES * PLACES), np.int64)
    for_ranges(_place_pixels, len(falls), height, width, n, falls, grain=1024)
    key, count = np.unique(falls, return_counts=True)
    texel, pixel = np.divmod(key, width * height)
    level = np.cos(np.pi * np.arange(height + 1) / height)
    of_pixel = np.repeat((level[:-1] - level[1:]) * 2 * np.pi / width, width)
    of_texel = cube_map.solid_angles(n)
    # Places within a pixel stand for equal solid angles.
    overlap = csr_array(
        (count * of_pixel[pixel] / PLACES**2, (texel, pixel)), (len(of_texel), len(of_pixel))
    )
    share = _balanced(overlap, of_texel, of_pixel).data / of_texel[texel]
    start = np.concatenate([[0], np.cumsum(np.bincount(texel, minlength=len(of_texel)))])
    return Parts(start, pixel.astype(np.int32), share.astype(np.float32))


def _balanced(
    overlap: csr_array, of_rows: NDArray[np.float64], of_columns: NDArray[np.float64]
) -> csr_array:
    """The overlaps, changed as little as makes their sums what they ought to be.

    Entry ij becomes (1 + a_i + b_j) times what it was, with a and b of least squares.
    """
    rows, columns = overlap.sum(axis=1), overlap.sum(axis=0)
    lack = np.concatenate([of_rows - rows, of_columns - columns])
    system: csr_array = block_array(
        [[diags_array(rows), overlap], [overlap.T, diags_array(columns)]], format="csr"
    )
    jacobi = diags_array(1 / system.diagonal())
    solved, _ = cg(system, lack, rtol=PRECISION, maxiter=ROUNDS, M=jacobi)
    a, b = np.split(solved, [len(rows)])
    row, column = overlap.tocoo().coords
    overlap.data *= 1 + a[row] + b[column]
    return overlap


@njit(cache=True, nogil=True)
def _place_pixels(start, stop, height, width, n, out):
    """Fill out (pixels, PLACES²) with texel · pixels + pixel of places all over each pixel."""
    side = int(np.sqrt(out.shape[1]))
    for p in range(start, stop):
        row, column = p // width, p % width
        top, bottom = np.cos(np.pi * row / height), np.cos(np.pi * (row + 1) / height)
        for k in range(side * side):
            y = top + (k // side + 0.5) / side * (bottom - top)
            r = np.sqrt(1.0 - y * y)
            phi = 2.0 * np.pi * ((column + (k % side + 0.5) / side) / width - 0.5)
            texel = cube_map.texel((r * np.sin(phi), y, -r * np.cos(phi)), n)
            out[p, k] = texel * height * width + p


@njit(cache=True, nogil=True)
def _mix(begin, end, start, pixel, share, radiance, out):
    for t in range(begin, end):
        red = green = blue = np.float32(0)
        for k in range(start[t], start[t + 1]):
            p, s = pixel[k], share[k]
            red += s * radiance[p, 0]
            green += s * radiance[p, 1]
            blue += s * radiance[p, 2]
        out[t, 0], out[t, 1], out[t, 2] = red, green, blue


@njit(cache=True, nogil=True)
def _turn(begin, end, image, whole, part, factor, out):
    """Move columns left by whole + part, linearly between two."""
    width = image.shape[1]
    here, there = np.float32(factor * (1.0 - part)), np.float32(factor * part)
    for row in range(begin, end):
        for column in range(width):
            i = (column + whole) % width
            j = i + 1 if i + 1 < width else 0
            for c in range(3):
                out[row, column, c] = here * image[row, i, c] + there * image[row, j, c]
