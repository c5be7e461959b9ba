"""Angles between unit vectors without the inverse cosine of a library, which is slow.

The polynomial is that of Abramowitz and Stegun 1964, 4.4.46, for acos c / √(1 - c), which is smooth
on [0, 1]; it is off by 2e-8. Its twin on the GPU is `shaders/common/angles.glsl`, where the acos of
a driver may be 1e-3 off.
"""

from __future__ import annotations

import math

from engine.numerics.dispatch import formula


@formula
def _over_root(c):
    """acos c / √(1 - c) for c from 0 to 1."""
    a = 0.0066700901 - 0.0012624911 * c
    a = 0.0308918810 + c * (a * c - 0.0170881256)
    a = 0.0889789874 + c * (a * c - 0.0501743046)
    return 1.5707963050 + c * (a * c - 0.2145988016)


@formula
def angle_over_sine(c):
    """γ / sin γ for cos γ = c in (-1, 1]: 1 at c = 1, with all its digits there."""
    if c >= 0.0:
        return _over_root(c) / math.sqrt(1.0 + c)
    return math.pi / math.sqrt(max(1e-30, (1.0 - c) * (1.0 + c))) - _over_root(-c) / math.sqrt(
        1.0 - c
    )
