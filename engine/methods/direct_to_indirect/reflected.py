"""What view samples do with the indirect light that arrives: k_d and k_g of eq. 4 to 6."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.frame_buffer import FrameBuffer
from engine.methods.fixed_view.view import Reflectance, View
from engine.numerics.parallel import for_ranges

FAINT = 0.02  # a gloss that reflects less than this counts as matt


def glossy_pixels(view: View) -> NDArray[np.bool_]:
    """(n,) bool: pixels whose gloss gets rows of its own."""
    return view.reflectance.gloss.max(axis=1) > FAINT


def as_gathered(reflectance: Reflectance, glossy: NDArray[np.bool_]) -> Reflectance:
    """The gloss of pixels that have no rows for it counted as matt."""
    matt, gloss = reflectance
    return Reflectance(
        np.where(glossy[:, None], matt, matt + gloss), np.where(glossy[:, None], gloss, 0)
    )


def add_indirect(
    arriving: NDArray[np.float32],
    mirrored: NDArray[np.float32],
    reflectance: Reflectance,
    image: NDArray[np.float32],
) -> None:
    """Add to an image (n, 3) what arrives at matt and at glossy parts (n, 3), in place."""
    for_ranges(_add_indirect, len(image), arriving, mirrored, *reflectance, image)


def add_at_edges(
    buffer: FrameBuffer,
    arriving: NDArray[np.float32],
    mirrored: NDArray[np.float32],
    reflectance: Reflectance,
    image: NDArray[np.float32],
) -> None:
    """The same for edge pixels, by the reflectances of their sub-samples (4 m, 3).

    Each takes what arrives at its donor (§3.6).
    """
    args = (buffer.edge, buffer.donor, arriving, mirrored, *reflectance, image)
    for_ranges(_add_at_edges, len(buffer.edge), *args)


@njit(cache=True, nogil=True)
def _add_indirect(start, stop, arriving, mirrored, matt, gloss, image):
    for i in range(start, stop):
        for c in range(3):
            image[i, c] += _reflected(arriving[i, c], mirrored[i, c], matt[i, c], gloss[i, c])


@njit(cache=True, nogil=True)
def _add_at_edges(start, stop, edge, donor, arriving, mirrored, matt, gloss, image):
    for e in range(start, stop):
        for s in range(4 * e, 4 * e + 4):
            i = donor[s]
            for c in range(3):
                image[edge[e], c] += 0.25 * _reflected(
                    arriving[i, c], mirrored[i, c], matt[s, c], gloss[s, c]
                )


@njit
def _reflected(arriving, mirrored, matt, gloss):
    # Culled wavelets can leave a little less than no light.
    return max(matt * arriving + gloss * mirrored, 0.0) * 0.3183098861837907
