"""The product of compressed transport vectors with a light: `glossy_prt` eq. 5, §4.3."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.borrow import borrow
from engine.numerics.cluster_basis import Clusters, starts
from engine.numerics.cube_map import FACES
from engine.numerics.parallel import for_ranges
from engine.numerics.wavelet_vectors import WaveletVectors


class Factor:
    """Transport vectors of c = K · channels channels, ready for products.

    The K terms come once if they are grey, else of red, of green, of blue.
    """

    def __init__(self, stored: WaveletVectors | Clusters, terms: int) -> None:
        self.stored, self.terms, self.channels = stored, terms, stored.scale.shape[1] // terms
        self._begins: Any
        if isinstance(stored, Clusters):
            self.vertices, self._begins = int(stored.vertices.sum()), starts(stored)
        else:
            self.vertices, self._begins = len(stored.length), stored.start

    @property
    def bytes(self) -> int:
        """What is stored."""
        return sum(array.nbytes for array in self.stored)

    def add_product(self, light: NDArray[np.float32], out: NDArray[np.float32]) -> None:
        """Add the terms of each vector times the light to out (vertices, K, 3) float32.

        light (6 n², 3) float32 holds the Haar coefficients of its faces.
        """
        v = self.stored
        if isinstance(v, Clusters):
            for_ranges(
                _add_clusters, len(v.rank), v, self._begins, light, self.terms, self.channels, out,
                grain=1,
            )  # fmt: skip
        else:
            kernel = _add_vectors(self.terms, self.channels)
            for_ranges(kernel, len(out), self._begins, *v[1:], light, out, grain=256)


@cache
def _add_vectors(terms: int, channels: int) -> Any:
    """With constant numbers of terms and channels, so that inner loops become vectors."""
    green_first, blue_first = (0, 0) if channels == 1 else (terms, 2 * terms)

    @njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
    def add(begin, end, start, base, scale, place, steps, light, out):
        size = light.shape[0] // FACES
        red, green, blue = np.zeros((3, terms), np.float32)
        for r in range(begin, end):
            red[:] = 0
            green[:] = 0
            blue[:] = 0
            for k in range(start[r], start[r + 1]):
                p = place[k]
                x, y, z = light[p, 0], light[p, 1], light[p, 2]
                for j in range(terms):
                    red[j] += np.float32(steps[k, j]) * x
                    green[j] += np.float32(steps[k, green_first + j]) * y
                    blue[j] += np.float32(steps[k, blue_first + j]) * z
            for j in range(terms):
                red[j] *= scale[r, j]
                green[j] *= scale[r, green_first + j]
                blue[j] *= scale[r, blue_first + j]
            for f in range(FACES):
                x, y, z = light[f * size, 0], light[f * size, 1], light[f * size, 2]
                for j in range(terms):
                    red[j] += base[r, f, j] * x
                    green[j] += base[r, f, green_first + j] * y
                    blue[j] += base[r, f, blue_first + j] * z
            for j in range(terms):
                out[r, j, 0] += red[j]
                out[r, j, 1] += green[j]
                out[r, j, 2] += blue[j]

    return add


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _add_clusters(begin, end, clusters, begins, light, terms, channels, out):
    clusters, begins = borrow(clusters), borrow(begins)
    most, widest = 0, 0
    for s in range(begin, end):
        most, widest = max(most, clusters.rank[s]), max(widest, clusters.vertices[s])
    seen, sums = np.zeros((3, most), np.float32), np.zeros((3, widest), np.float32)
    for s in range(begin, end):
        n, m, first = clusters.vertices[s], clusters.rank[s], begins.vertices[s]
        _by_basis(clusters, begins, s, light, seen)
        for q in range(terms * channels):
            k = q % terms
            low, high = (0, 3) if channels == 1 else (q // terms, q // terms + 1)
            sums[:, :n] = 0
            for j in range(m):
                unit = clusters.scale[begins.scale[s] + j, q]
                at = begins.weights[s] + (q * m + j) * n
                weights = clusters.weights[at : at + n]
                for c in range(low, high):
                    into, x = sums[c], unit * seen[c, j]
                    for v in range(n):
                        into[v] += np.float32(weights[v]) * x
            for c in range(low, high):
                for v in range(n):
                    out[first + v, k, c] += sums[c, v]


@njit(nogil=True, fastmath={"contract", "reassoc"})
def _by_basis(clusters, begins, s, light, out):
    """Fill out (3, m) with the products of a cluster's components with the light."""
    m, at = clusters.rank[s], begins.basis[s]
    red, green, blue = out[0, :m], out[1, :m], out[2, :m]
    red[:] = 0
    green[:] = 0
    blue[:] = 0
    first = begins.place[s]
    for i in range(first, first + clusters.length[s]):
        p, unit = clusters.place[i], clusters.unit[i]
        x, y, z = unit * light[p, 0], unit * light[p, 1], unit * light[p, 2]
        steps = clusters.basis[at : at + m]
        at += m
        for j in range(m):
            step = np.float32(steps[j])
            red[j] += step * x
            green[j] += step * y
            blue[j] += step * z
