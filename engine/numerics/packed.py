"""The form of packed rows: what `engine.methods.fixed_view.rows` writes and products read.

The rows of a tile share a list of wavelets. Of each it holds the mean of its coefficients over the
tile and so many *steps*, its Haar coefficients over the tile's rows in units of their own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

TILE = 64  # rows
STEPS = (64, 16, 4, 0)  # of a wavelet: the kinds of wavelets, in the order of a tile's list
UNITS = (8, 4, 2)  # of the first 4, 16 and 64 steps: square roots of the rows that a step covers


def step_units() -> NDArray[np.float32]:
    """(64,) float32: the unit of each step."""
    return np.repeat(np.array(UNITS, np.float32), np.diff([0, 4, 16, TILE]))
