"""Samples made to agree with their reverses.

The light that goes from wi to wo is the light that goes from wo to wi, but instruments differ from
it by a few per cent and, near the horizon, by much more. A function through samples and reverses as
they are would waver between the two. So before the reverses are added, half of the difference goes
to each side. What differs from place to place at random, as where a highlight is met by one side
alone, is no fault of the instrument and stays: only what neighbours have in common is moved.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from engine.brdf.acquisition.least_squares import cloud, thinned
from engine.brdf.acquisition.pairs import reverse

NEAR = 0.1  # a reverse this near to a sample, in the coordinates of `pairs`, counts as measured
FADE = 2.0  # times that far it does not count at all
FEWEST = 8
NEIGHBOURS = 24
MOST = 1 << 13
SCATTER = 1.5  # times the scatter, a difference is no more than that


def balanced(places: NDArray[np.float64], logs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Logarithms (n, 3) of samples at places (n, d), halfway to those of their reverses.

    Where reverses were not measured they stay as they are.
    """
    back = reverse(places)
    away, _ = cKDTree(places).query(back)
    share = np.clip((FADE - away / NEAR) / (FADE - 1.0), 0.0, 1.0)
    near = np.flatnonzero(away < NEAR)
    if len(near) < FEWEST:
        return logs
    # The difference varies slowly, and a part of many samples tells it as well.
    near = near[:: -(-len(near) // MOST)]
    # Both are read off the same smooth function, so that what it smooths away cancels out.
    seen = cloud(*thinned(places, logs))
    differences = seen.at(back[near]) - seen.at(places[near])
    _, nearest = cKDTree(places[near]).query(places[near], min(NEIGHBOURS, len(near)))
    common = cloud(places[near], _common(differences[nearest]))
    return logs + 0.5 * share[:, None] * common.at(places)


def _common(differences: NDArray[np.float64]) -> NDArray[np.float64]:
    """What differences (n, k, 3) have in common (n, 3), less where they scatter, 0 if widely."""
    middle = np.median(differences, axis=1)
    scatter = np.median(np.abs(differences - middle[:, None]), axis=1)
    sure = middle**2 - (SCATTER * scatter) ** 2
    return middle * np.maximum(0.0, sure) / np.maximum(middle**2, 1e-300)
