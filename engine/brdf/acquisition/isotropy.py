"""Whether scattered samples are those of an isotropic material."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from engine.brdf.acquisition.pairs import coordinates, half_and_difference, one_of_two
from engine.brdf.acquisition.samples import Samples

TOO_FEW = 64  # samples that cannot tell
SAME_DEGREES = 0.1
GAIN = 0.95  # what is left of the error where regard to azimuth does help
PER_TURN = (1, 2)  # a nap that leans to one side, a grain
NEIGHBOURS = 32
MOST = 2000  # samples tried
FLOOR = 1e-2  # of the median, below which differences are noise
RIDGES = (1e-12, 1e-4, 1e-2)  # of the value, of slopes over distance, of the swing with azimuth
STEEP = 0.02  # sines of the half angle to the normal below which it has hardly an azimuth


def is_isotropic(samples: Samples) -> bool:
    """Whether to take samples as isotropic.

    They are where wi has one azimuth only: nothing is known of others. Else each sample is foretold
    from its neighbours among isotropic pairs, which lie at any azimuth φ about the normal, by a
    linear fit: once without regard to φ and once with terms in cos mφ and sin mφ of the half
    vector. The terms foretell noise and isotropic samples worse than none do, those of a brushed
    surface better.
    """
    n = len(samples.rgb)
    if n < TOO_FEW or _one_azimuth(samples.wi):
        return True
    grey = samples.rgb.mean(axis=1)
    if not grey.any():
        return True
    logs = np.log(grey + FLOOR * np.median(grey[grey > 0]))
    chosen = np.random.default_rng(0).permutation(n)[:MOST]
    x = one_of_two(coordinates(samples.wi, samples.wo, True))
    weight, offset, nearest = _neighbours(x, chosen)

    h, _, _ = half_and_difference(samples.wi, samples.wo)
    phi = np.arctan2(h[:, 1], h[:, 0])
    sure = np.minimum(1.0, np.hypot(h[:, 0], h[:, 1]) / STEEP)
    without = _errors(weight, offset, logs, nearest, chosen)
    least = GAIN * without
    return all(
        _errors(weight, offset, logs, nearest, chosen, _swing(m * phi, sure)) >= least
        for m in PER_TURN
    )


def _one_azimuth(w: NDArray[np.float64]) -> bool:
    """Whether all directions that have an azimuth have the same one."""
    lean = w[np.hypot(w[:, 0], w[:, 1]) > 1e-3, :2]
    if not len(lean):
        return True
    lean = lean / np.linalg.norm(lean, axis=1)[:, None]
    return bool((lean @ lean[0] >= np.cos(np.radians(SAME_DEGREES))).all())


def _swing(angle: NDArray[np.float64], size: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([np.cos(angle), np.sin(angle)], axis=1) * size[:, None]


def _neighbours(
    x: NDArray[np.float64], chosen: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.intp]]:
    """Weights (q, k), offsets (q, k, 3) and indices (q, k) of neighbours of chosen places, less
    themselves."""
    found = cKDTree(x).query(x[chosen], NEIGHBOURS + 1)
    distance, nearest = np.asarray(found[0]), np.asarray(found[1])
    itself = nearest == chosen[:, None]
    # Where many coincide, a sample is not always among its own nearest.
    itself[~itself.any(axis=1), -1] = True
    distance = distance[~itself].reshape(-1, NEIGHBOURS)
    nearest = nearest[~itself].reshape(-1, NEIGHBOURS)
    radius = 1.03 * distance[:, -1:] + 1e-12
    t = distance / radius
    weight = (1 - t) ** 5 * (5 * t + 1)
    offset = (x[nearest] - x[chosen][:, None]) / radius[:, :, None]
    return weight / weight.sum(axis=1, keepdims=True), offset, nearest


def _errors(
    weight: NDArray[np.float64],
    offset: NDArray[np.float64],
    logs: NDArray[np.float64],
    nearest: NDArray[np.intp],
    chosen: NDArray[np.intp],
    swing: NDArray[np.float64] | None = None,
) -> float:
    """Mean error of the chosen logs, foretold from their neighbours; swing (n, 2) or none."""
    extra = np.zeros((len(logs), 0)) if swing is None else swing
    known = logs[nearest]
    terms = np.concatenate([np.ones((*nearest.shape, 1)), offset, extra[nearest]], axis=2)
    weighted = terms * weight[:, :, None]
    ridge = np.diag(np.repeat(RIDGES, (1, 3, extra.shape[1])))
    normal = weighted.swapaxes(1, 2) @ terms + ridge
    right = weighted.swapaxes(1, 2) @ known[:, :, None]
    fitted = np.linalg.solve(normal, right)[:, :, 0]
    told = fitted[:, 0] + (fitted[:, 4:] * extra[chosen]).sum(axis=1)
    told = np.clip(told, known.min(axis=1), known.max(axis=1))
    return float(np.abs(told - logs[chosen]).mean())
