"""The figures of a report: coverage, gaps, reciprocity, energy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from engine.brdf.acquisition.pairs import degrees_of, turned
from engine.brdf.acquisition.report import WITHIN_DEGREES, Energy, Report
from engine.brdf.acquisition.samples import Samples, directions
from engine.brdf.albedo import ANGLES_DEGREES

Evaluate = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]

PROBES = 1 << 14
REVERSE_WITHIN_DEGREES = 3.0
APART = 0.1  # cosines that tell the steeper of two directions
AZIMUTHS_DEGREES = (0.0, 45.0, 90.0, 135.0)  # of the eye, where the material is not isotropic
# Rings about the mirror direction are as wide as their distance from it, up to a quarter of a
# radian, so that highlights of any sharpness are resolved; beyond it they are even.
NARROWEST, EVEN_FROM, NARROW_RINGS, EVEN_RINGS, SECTORS = 2e-3, 0.25, 24, 36, 48


def report_of_samples(samples: Samples, isotropic: bool, evaluate: Evaluate) -> Report:
    """The report on samples and on the function (wi, wo) -> (q, 3) that was made of them."""
    tree = cKDTree(_both(samples.wi, samples.wo, isotropic))
    nearest = np.tile(np.arange(len(samples.rgb)), 2)

    def of_the_nearest(wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        return samples.rgb[nearest[_nearest(tree, turned(wi, wo, isotropic), 1)[1][:, 0]]]

    coverage, gap = _coverage(tree, isotropic)
    pairs, unlike, bias = _reverses(samples, isotropic)
    return Report(
        samples.name,
        isotropic,
        len(samples.rgb),
        energy(of_the_nearest, isotropic),
        energy(evaluate, isotropic),
        dropped=samples.dropped,
        clamped=samples.clamped,
        out_of_gamut=samples.out_of_gamut,
        coverage=coverage,
        largest_gap_degrees=gap,
        reverse_pairs=pairs,
        unlike_reverses=unlike,
        reverse_bias=bias,
        unlike_after=unlike_reverses(evaluate),
    )


def energy(evaluate: Evaluate, isotropic: bool) -> Energy:
    """The largest directional albedo, of ANGLES_DEGREES from the normal."""
    # Light from the mirror direction of an eye at azimuth 0 is turned with the eye.
    found = []
    for azimuth in (0.0,) if isotropic else AZIMUTHS_DEGREES:
        for angle in ANGLES_DEGREES:
            wo = directions(np.radians([angle]), np.radians([azimuth]))
            wi, solid = about_mirror(wo[0])
            weight = solid * wi[:, 2]
            albedo = weight @ evaluate(wi, np.repeat(wo, len(wi), axis=0))
            found.append((float(albedo.max()), angle, int(albedo.argmax())))
    return Energy(*max(found))


def unlike_reverses(evaluate: Evaluate) -> float:
    """The largest relative difference of a function and its reverse."""
    wi, wo, _ = _probes()
    wi, wo = wi[::8], wo[::8]
    return float(np.abs(_difference(evaluate(wi, wo), evaluate(wo, wi))).max())


def _difference(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Relative differences (n,) of the sums of the channels of (n, 3) and (n, 3), -2 to 2."""
    x, y = a.sum(axis=1), b.sum(axis=1)
    return (x - y) / np.maximum(0.5 * (x + y), 1e-300)


def _both(wi: NDArray[np.float64], wo: NDArray[np.float64], isotropic: bool) -> NDArray[np.float64]:
    """Places of pairs and, after all of them, of their reverses."""
    return np.concatenate([turned(wi, wo, isotropic), turned(wo, wi, isotropic)])


def _coverage(tree: cKDTree, isotropic: bool) -> tuple[float, float]:
    """Part of the domain near a sample, and the farthest distance to one in degrees."""
    wi, wo, weight = _probes()
    away = degrees_of(_nearest(tree, turned(wi, wo, isotropic), 1)[0][:, 0])
    return float(weight[away <= WITHIN_DEGREES].sum() / weight.sum()), float(away.max())


def _probes() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Pairs (n, 3), (n, 3) evenly over all four angles, and their projected solid angles (n,)."""
    # Fractional parts of i·φ^-1 to i·φ^-4 with φ⁵ = φ + 1, as in `engine.brdf.albedo`.
    phi = 1.1673039782614187
    i = np.arange(PROBES)[:, None]
    u = (0.5 + i / phi ** np.arange(1, 5)) % 1.0
    theta, azimuth = u[:, :2] * (np.pi / 2), u[:, 2:] * (2 * np.pi)
    wi, wo = directions(theta[:, 0], azimuth[:, 0]), directions(theta[:, 1], azimuth[:, 1])
    return wi, wo, np.sin(2 * theta).prod(axis=1)


def _reverses(samples: Samples, isotropic: bool) -> tuple[int, float, float]:
    """How many samples have a reverse, the median of their relative differences, and their bias.

    The bias is the median with its sign, positive where the sample with the steeper light is the
    brighter one. Reverses are not met exactly, and on the slope of a highlight that alone makes a
    difference, but one with either sign.
    """
    if len(samples.rgb) < 2:
        return 0, 0.0, 0.0
    tree = cKDTree(turned(samples.wi, samples.wo, isotropic))
    distance, index = _nearest(tree, turned(samples.wo, samples.wi, isotropic), 2)
    # A sample that is nearly its own reverse tells nothing; the second nearest may.
    own = index[:, 0] == np.arange(len(index))
    away = degrees_of(np.where(own, distance[:, 1], distance[:, 0]))
    near = away <= REVERSE_WITHIN_DEGREES
    if not near.any():
        return 0, 0.0, 0.0
    other = np.where(own, index[:, 1], index[:, 0])[near]
    unlike = _difference(samples.rgb[near], samples.rgb[other])
    steeper = np.sign(samples.wi[near, 2] - samples.wo[near, 2])
    apart = np.abs(samples.wi[near, 2] - samples.wo[near, 2]) > APART
    bias = float(np.median((unlike * steeper)[apart])) if apart.any() else 0.0
    return int(near.sum()), float(np.median(np.abs(unlike))), bias


def _nearest(
    tree: cKDTree, places: NDArray[np.float64], k: int
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Distances (q, k) and indices (q, k) of the k points of a tree that are nearest to places."""
    distance, index = tree.query(places, k)
    return np.reshape(distance, (-1, k)), np.reshape(index, (-1, k))


def about_mirror(
    wo: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Directions (n, 3) above the surface, finer about the mirror image of wo, and their solid
    angles (n,)."""
    axis = np.array([-wo[0], -wo[1], wo[2]])
    side = np.cross(axis, (1.0, 0.0, 0.0) if abs(axis[0]) < 0.7 else (0.0, 1.0, 0.0))
    side /= np.linalg.norm(side)
    edges = np.concatenate(
        [
            [0.0],
            np.geomspace(NARROWEST, EVEN_FROM, NARROW_RINGS),
            np.linspace(EVEN_FROM, np.pi, EVEN_RINGS + 1)[1:],
        ]
    )
    ring = np.arccos(0.5 * (np.cos(edges[:-1]) + np.cos(edges[1:])))
    band = (np.cos(edges[:-1]) - np.cos(edges[1:])) * (2 * np.pi / SECTORS)
    phi = (np.arange(SECTORS) + 0.5) * (2 * np.pi / SECTORS)
    local = directions(np.repeat(ring, SECTORS), np.tile(phi, len(ring)))
    w = local @ np.stack([side, np.cross(axis, side), axis])
    above = w[:, 2] > 0
    return w[above], np.repeat(band, SECTORS)[above]
