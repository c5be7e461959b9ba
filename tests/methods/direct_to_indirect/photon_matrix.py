"""The paper's multi-bounce matrix M, by photons that know where they come from (§4.3).

Gather samples emit photons as matt lamps do. A photon is deposited wherever it lands, and goes on
by the colour of the surface. The K photons nearest to a gather sample are its row of M: the disk
that they fill receives the light of the samples that they left. The product applies one bounce
several times in its place (`bounces.py`); this is its check, together with paths that no cloud is
behind.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from engine.light.base import Light
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.sides import cosine_rays, sides_met
from engine.methods.fixed_view.surface_points import describe, equivalent_albedo
from engine.numerics.parallel import for_ranges
from engine.scene.scene import Scene

TURNED = 10.0  # scene sizes that opposite normals are apart by: a disk keeps to its own plane


class PhotonMatrix(NamedTuple):
    """Rows of M, sparse.

    origin  (n_g, K) int32       gather samples that the nearest photons left
    weight  (n_g, K, 3) float32  radiance reflected, for a radiance of 1 there
    """

    origin: NDArray[np.int32]
    weight: NDArray[np.float32]

    def __matmul__(self, g: NDArray[np.float32]) -> NDArray[np.float32]:
        """M g, g (n_g, 3)."""
        out: NDArray[np.float32] = np.einsum("ikc,ikc->ic", self.weight, g[self.origin])
        return out

    def noise(self, g: NDArray[np.float32]) -> NDArray[np.float64]:
        """(n_g, 3) variance of M g: that of a sum over a Poisson number of photons."""
        return np.square(self.weight * g[self.origin], dtype=np.float64).sum(axis=1)


def photon_matrix(
    scene: Scene, cloud: GatherCloud, photons: int, nearest: int, length: int, seed: int
) -> PhotonMatrix:
    """M of paths of up to `length` flights, from so many photons, by the K = `nearest` of them."""
    each = photons // len(cloud)
    origin = np.repeat(np.arange(len(cloud), dtype=np.int32), each)
    # A sample of radiance 1 sends out the flux π A.
    flux = np.repeat(np.pi * cloud.area / each, each)[:, None] * np.ones(3)
    where, normal, left, carried = [], [], [], []
    start = cloud.points.take(origin)
    for alive, landed, colour in flights(scene, start, length, seed):
        where.append(landed.position)
        normal.append(landed.geometric)
        left.append(origin[alive])
        carried.append(flux[alive])
        flux[alive] = carried[-1] * colour
    bend = TURNED / 2 * scene.diagonal
    tree = cKDTree(np.hstack([np.concatenate(where), bend * np.concatenate(normal)]))
    points = cloud.points
    away, found = tree.query(np.hstack([points.position, bend * points.geometric]), nearest)
    # Of the K photons the farthest only says how wide the disk is.
    share = (nearest - 1) / nearest / (np.pi * away[:, -1:] ** 2)
    weight = np.concatenate(carried)[found] * share[..., None] * cloud.albedo[:, None] / np.pi
    return PhotonMatrix(np.concatenate(left)[found], weight.astype(np.float32))


def flights(
    scene: Scene, start: Points, length: int, seed: int
) -> Iterator[tuple[NDArray[np.intp], Points, NDArray[np.float32]]]:
    """Flight by flight of particles that bounce by the cosine: (who landed, where, its albedo)."""
    alive = np.arange(len(start))
    position, normal = start.position, start.geometric
    for flight in range(length):
        n = len(alive)
        origin, direction = np.zeros((2, n, 3), np.float32)
        args = (position, normal, scene.rays.epsilon, seed + 97 * flight, origin, direction)
        for_ranges(cosine_rays, n, *args)
        hits = scene.rays.intersect(origin, direction)
        met = np.flatnonzero(hits.triangle >= 0)
        back = sides_met(scene, hits, direction)[0][met].astype(np.bool_)
        place = np.stack([hits.b1, hits.b2], axis=1)[met]
        landed = describe(scene, hits.triangle[met], back, place)
        alive, position, normal = alive[met], landed.position, landed.geometric
        yield alive, landed, equivalent_albedo(landed)


def traced(
    scene: Scene, cloud: GatherCloud, light: Light, which: NDArray[np.intp], paths: int, seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(M g (m, 3), variance of that) of one light at the gather samples `which`, by paths.

    Three flights, with the light itself at the end of each: nothing here knows of samples.
    """
    start = cloud.points.take(np.repeat(which, paths))
    total, colour = np.zeros((len(start), 3)), np.ones((len(start), 3))
    matt = cloud.points.model[0]
    for alive, landed, albedo in flights(scene, start, 3, seed):
        row = np.zeros_like(landed.row)
        row[:, :3] = albedo
        landed.model[:], landed.row[:] = matt, row
        total[alive] += colour[alive] * light_on_points(scene.rays, landed, light)
        colour[alive] *= albedo
        gone = np.ones(len(start), np.bool_)
        gone[alive] = False
        colour[gone] = 0
    total *= np.repeat(cloud.albedo[which], paths, axis=0)
    each = total.reshape(len(which), paths, 3)
    return each.mean(axis=1), each.var(axis=1) / (paths - 1)
