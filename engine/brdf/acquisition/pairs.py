"""Where a pair of directions lies among others: coordinates in which neighbours look alike.

With h the half vector, θ_h its angle to the normal, and d the direction wi as seen from h
(Rusinkiewicz 1998), θ_d its angle to h, a pair lies at

    a = √2 (1 - cos θ_h)^¼                 √θ_h nearly: small half angles get most room
    b = 3/2 tan(θ_d / 2)                   the stereographic projection of d
    c = ½ (cos θ_o - cos θ_i)              = sin θ_h sin θ_d cos φ_d

where the BRDF is isotropic, and otherwise at (a cos φ_h, a sin φ_h, b cos α, b sin α), where α is
the azimuth of d once the shortest rotation has taken h to the normal; unlike φ_d it does not jump
where h passes the normal. To swap the directions turns the sign of c, or of both places of d. To
rotate both of them, or to mirror them in a plane through the normal, leaves (a, b, c) as it is.

A highlight depends on θ_h far more than on the others, so that neighbours along b and c tell of it
where the raw directions (wi, wo) would smear it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def coordinates(
    wi: NDArray[np.float64], wo: NDArray[np.float64], isotropic: bool
) -> NDArray[np.float64]:
    """Places (q, 3) of isotropic pairs, (q, 4) of others; wi, wo (q, 3) unit, z ≥ 0."""
    h, e, cosine = half_and_difference(wi, wo)
    slope = np.hypot(h[:, 0], h[:, 1])
    a = np.sqrt(2.0) * np.sqrt(slope / np.sqrt(1.0 + h[:, 2]))
    scale = 1.5 / (1.0 + cosine)
    if isotropic:
        return np.stack([a, np.hypot(e[:, 0], e[:, 1]) * scale, 0.5 * (wo[:, 2] - wi[:, 2])], 1)
    along = h[:, :2] * (a / np.maximum(slope, 1e-300))[:, None]
    return np.concatenate([along, e * scale[:, None]], axis=1)


def reverse(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where pairs at places (q, d) lie with their directions swapped."""
    return places * ((1, 1, -1) if places.shape[1] == 3 else (1, 1, -1, -1))


def one_of_two(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of the two places of a pair and its reverse always the same one.

    So whatever is a function of the result is reciprocal to the last bit.
    """
    first, last = places[:, 2], places[:, -1]
    other = (first < 0) | ((first == 0) & (last < 0))
    return np.where(other[:, None], reverse(places), places)


def half_and_difference(
    wi: NDArray[np.float64], wo: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(h, e, cos θ_d): half vector (q, 3), and d as seen from it: (q, 2) and its height (q,).

    Swapping the directions turns the sign of e and changes nothing else, to the last bit. Where
    they are opposite, both on the horizon, h is the normal.
    """
    both = wi + wo
    twice = np.linalg.norm(both, axis=1)
    flat = twice < 1e-12
    h = np.where(flat[:, None], (0.0, 0.0, 1.0), both / np.where(flat, 1.0, twice)[:, None])
    # The rest of wi beside its part along h, taken along as h is turned to the normal.
    rest = 0.5 * (wi - wo)
    e = rest[:, :2] - h[:, :2] * (rest[:, 2] / (1.0 + h[:, 2]))[:, None]
    return h, e, 0.5 * twice


def turned(
    wi: NDArray[np.float64], wo: NDArray[np.float64], isotropic: bool
) -> NDArray[np.float64]:
    """The directions themselves as places, (q, 5) of isotropic pairs, (q, 6) of others.

    Isotropic pairs are rotated until wi has azimuth 0, and mirrored until wo has one of 0 to π. The
    distance of two places is the root of the sum of the squares of the two chords.
    """
    if not isotropic:
        return np.concatenate([wi, wo], axis=1)
    slope = np.hypot(wi[:, 0], wi[:, 1])
    ahead = np.where(slope[:, None] > 1e-9, wi[:, :2] / np.maximum(slope, 1e-9)[:, None], (1, 0))
    along = wo[:, 0] * ahead[:, 0] + wo[:, 1] * ahead[:, 1]
    across = np.abs(wo[:, 1] * ahead[:, 0] - wo[:, 0] * ahead[:, 1])
    return np.stack([slope, wi[:, 2], along, across, wo[:, 2]], axis=1)


def degrees_of(distance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles of distances between places of `turned`, as if one direction alone had moved."""
    return np.degrees(2.0 * np.arcsin(np.minimum(1.0, 0.5 * distance)))
