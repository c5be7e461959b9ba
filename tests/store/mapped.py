"""What lies under an array."""

from __future__ import annotations

import numpy as np


def mapping_under(array: np.ndarray) -> object:
    """The object whose memory it is, such as a mapped file."""
    base: object = array
    while isinstance(base, np.ndarray):
        base = base.base
    return base.obj if isinstance(base, memoryview) else base
