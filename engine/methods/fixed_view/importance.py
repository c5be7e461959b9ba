"""Which wavelets of the gather cloud matter: those that lights excite.

A coefficient F_xk of a row is worth what it adds to a picture, F_xk times the light's coefficient
g_k. So rows are culled by F_xk² E[g_k²], the expectation over lights that a person may place. The
paper multiplies by the support of the wavelet (*area weighting*, §4.3 of Hašan et al. 2006), which
stands for the same: large wavelets carry most light. Here the expectation is measured with point
lights and spots at random places in the open space of the scene.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from engine.light.base import Light
from engine.light.environment_samples import DEPTH
from engine.light.point import PointLight
from engine.light.spot import SpotLight
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.direct import light_on_points
from engine.numerics import haar
from engine.scene.scene import Scene

LIGHTS = 96
CONES_DEGREES = (12.0, 25.0)
# Few lights say little about one small wavelet, so half of its weight is the mean of its level.
OF_LEVEL = 0.5


def wavelet_importance(scene: Scene, cloud: GatherCloud, seed: int) -> NDArray[np.float32]:
    """(n_g,) float32: root mean square of the wavelet coefficients of such lights, at most 1."""
    energy = np.zeros(len(cloud), np.float64)
    for light in trial_lights(scene, cloud, seed):
        direct = light_on_points(scene.rays, cloud.points, light).mean(axis=1, keepdims=True)
        coefficients = haar.forward(direct).ravel().astype(np.float64) ** 2
        total = coefficients.sum()
        if total > 0:
            # A light far from everything counts as much as one close to a wall.
            energy += coefficients / total
    for level in range(cloud.clusters.depth):
        span = slice(4**level, 4 ** (level + 1))
        node = np.repeat(energy[span].reshape(-1, 3).mean(axis=1), 3)
        energy[span] = (1 - OF_LEVEL) * node + OF_LEVEL * energy[span].mean()
    energy = np.maximum(energy, 1e-12 * energy.max(initial=1e-30))
    return np.sqrt(energy / energy.max()).astype(np.float32)


@cache
def environment_importance() -> NDArray[np.float32]:
    """(n_e,) float32, of the wavelets of environment samples: 0.7 from each level to the next.

    What a wavelet of a surrounding holds falls by about half from level to level (Dror, Willsky,
    Adelson 2004, *Statistical characterization of real-world illumination*: power over frequency
    as 1/f²), and by less where there are lamps in it: 0.4 to 0.9 in the maps that we have.
    """
    level = np.repeat(np.arange(DEPTH), [4 ** (k + 1) - 4**k for k in range(DEPTH)])
    return np.concatenate([[1.0], 0.7**level]).astype(np.float32)


def trial_lights(scene: Scene, cloud: GatherCloud, seed: int) -> list[Light]:
    """Lights in the open space before random gather samples, every other one a spot."""
    rng = np.random.default_rng(seed)
    chosen = _by_area(cloud)[rng.integers(0, len(cloud), LIGHTS)]
    normal = cloud.points.geometric[chosen].astype(np.float64)
    direction = rng.normal(size=(LIGHTS, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    # A unit vector plus a random one on the sphere is cosine-distributed about it.
    direction = normal + 0.999 * direction
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    origin = cloud.points.position[chosen] + scene.rays.epsilon * normal
    hits = scene.rays.intersect(origin.astype(np.float32), direction.astype(np.float32))
    reach = np.where(np.isfinite(hits.distance), hits.distance, 0.5 * scene.diagonal)
    place = origin + direction * (reach * rng.uniform(0.1, 0.9, LIGHTS))[:, None]
    lights: list[Light] = []
    for k, (p, o) in enumerate(zip(place.tolist(), origin.tolist(), strict=True)):
        if k % 2:
            cone = CONES_DEGREES[k // 2 % len(CONES_DEGREES)]
            lights.append(
                SpotLight(
                    id=f"trial {k}",
                    position=tuple(p),
                    target=tuple(o),
                    cone_degrees=cone,
                    intensity=(1, 1, 1),
                )
            )
        else:
            lights.append(PointLight(id=f"trial {k}", position=tuple(p), intensity=(1, 1, 1)))
    return lights


def _by_area(cloud: GatherCloud) -> NDArray[np.intp]:
    """(n_g,) samples in order, each as often as it stands for the mean area of one."""
    upto = np.cumsum(cloud.area, dtype=np.float64)
    places = (np.arange(len(cloud)) + 0.5) / len(cloud) * upto[-1]
    return np.searchsorted(upto, places)
