"""How far off sharp lobes are: as sums of elements, along a pixel's rays, under points of lamps.

All three depend on how wide the lobe is, so that a frame can tell them in no time.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.curve_basis import Basis
from engine.brdf.half_angle import angle_of
from engine.brdf.layers import Layers
from engine.methods.brdf_editing.arriving import Surface
from engine.methods.brdf_editing.light_seen import Shining, from_lamp
from engine.methods.brdf_editing.settings import Settings
from engine.numerics.borrow import borrow

PLACES = 256  # that a lobe is looked up at
PIXELS = 64  # that tell how far apart the points of a lamp are
SIDE = 8  # of the grid of points of a lamp
# Error of a lobe, by the number of elements within half its height, to the power of minus the
# order. Measured on Blinn-Phong, Phong, Beckmann and GGX lobes, of which it is what the worst has
# at 5 %; of the others, and where it is smaller, half of it or more.
ORDER = {"tents": 2, "boxes": 1}
ERROR = {"tents": 0.4, "boxes": 0.74}
# Error under even light, by the number of rays in a lobe: lattices do better than 1 / √n.
LATTICE = 0.7


class Lobe(NamedTuple):
    """A lobe, as far as limits ask.

    half   rad: γ where it falls to half of its height
    rays   of a pixel that count in it, of the settings that it was looked up for
    """

    half: float
    rays: float


def lobe_of(layers: Layers, row: NDArray[np.float32], settings: Settings) -> Lobe | None:
    """That of a material's row, seen along the normal; None where it has none."""
    u = (np.arange(PLACES) + 0.5) / PLACES
    gamma = angle_of(u)
    value = layers.lobes(row, gamma).sum(axis=(0, 2))
    if not value.any():
        return None
    peak = int(value.argmax())
    low = peak + np.flatnonzero(value[peak:] < 0.5 * value[peak])
    k = int(low[0]) if len(low) else PLACES - 1
    half_height = angle_of(np.interp(-0.5 * value[peak], -value[k - 1 : k + 1], u[k - 1 : k + 1]))
    # The rays' own number per sr, and what the lobe makes of each.
    half, turned = (0.5 * gamma, gamma) if layers.mirrored else (gamma, 2 * gamma)
    solid = 8 * np.pi * u**3 * (1 if layers.mirrored else 4 * np.cos(half))
    cosine, n = np.maximum(0, np.cos(turned)), settings.lobe_exponent
    lobe = (n + 1) / (2 * np.pi) * np.cos(half) ** n / (4 * np.cos(half))
    rays = settings.cosine_count * cosine / np.pi
    rays = rays + (settings.view_rays - settings.cosine_count) * lobe
    light = value * cosine * solid
    spread = light * value * cosine / np.maximum(rays, 1e-30)
    return Lobe(float(half_height), float(light.sum() ** 2 / spread.sum() / PLACES))


def basis_error(half: float, bands: int, basis: Basis) -> float:
    """Relative L2 error of a lobe of that half width as a sum of so many elements."""
    within = (bands - (basis == "tents")) * _place(half)
    return min(1.0, ERROR[basis] / within ** ORDER[basis])


def bands_for(half: float, error: float, basis: Basis) -> int:
    """How many elements keep that below an error."""
    within = (ERROR[basis] / error) ** (1 / ORDER[basis])
    return math.ceil(within / _place(half)) + (basis == "tents")


def _place(half: float) -> float:
    return float((1 - math.cos(half)) ** 0.25)


def points_error(half: float, apart: float) -> float:
    """Relative RMS error of the mirror image of a lamp made of points, in a lobe so wide.

    apart is the angle between half vectors of neighbours. In closed form for a Gaussian lobe: a
    grid of them is its mean and ripples, each e⁻²ᵖⁱ²ˢ² of it.
    """
    if apart <= 0:
        return 0.0
    ripple = math.exp(-2 * math.pi**2 / math.log(2) * (half / apart) ** 2)
    theta = 1 + 2 * sum(ripple ** (k * k) for k in range(1, 64))
    return math.sqrt(theta**2 - 1)


def half_for(error: float, apart: float) -> float:
    """How wide a lobe must be, rad, for that to be less than a small error."""
    return apart * math.sqrt(math.log(2 / error) * math.log(2)) / math.pi


def lamp_spacing(surface: Surface, lights: Shining, pixels: NDArray[np.int32]) -> float:
    """rad: between half vectors of neighbouring points of the lamp where those lie farthest apart.

    As some of the pixels see it; 0 where no lamp has an extent.
    """
    lamps = np.flatnonzero(lights.points > 1)
    if not len(lamps) or not len(pixels):
        return 0.0
    some = pixels[:: -(-len(pixels) // PIXELS)]
    w = np.zeros((len(some), len(lamps), SIDE, SIDE, 3))
    _directions(surface, lights, some, lamps, w)
    steps = [np.linalg.norm(np.diff(w, axis=axis), axis=-1).mean(axis=(2, 3)) for axis in (2, 3)]
    # A half vector turns by half of what the light does.
    return 0.5 * float(np.median(np.maximum(*steps), axis=0).max())


@njit(cache=True, nogil=True)
def _directions(surface, lights, pixels, lamps, out):
    surface, lights = borrow(surface), borrow(lights)
    for q in range(pixels.shape[0]):
        for r in range(lamps.shape[0]):
            for k in range(lights.points[lamps[r]]):
                w, _ = from_lamp(surface, lights, pixels[q], lamps[r], k)
                x = int(lights.place[lamps[r], k, 0] * out.shape[2])
                y = int(lights.place[lamps[r], k, 1] * out.shape[3])
                for c in range(3):
                    out[q, r, x, y, c] = w[c]
