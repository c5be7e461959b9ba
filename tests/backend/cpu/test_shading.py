"""Where light ends: the pixels to look at more closely."""

from __future__ import annotations

import numpy as np
import pytest

from engine.backend.cpu.shading import HIDDEN, VISIBLE, light_edges

WIDTH, HEIGHT = 9, 7


@pytest.mark.parametrize("reach", [1, 2, 3])
def test_all_within_reach_of_both_light_and_shadow(reach: int) -> None:
    """Brute force over all pairs of pixels, with some that lie on no surface."""
    visible = np.random.default_rng(reach).choice(
        [0, HIDDEN, VISIBLE, HIDDEN | VISIBLE], WIDTH * HEIGHT, p=[0.6, 0.19, 0.19, 0.02]
    )
    y, x = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
    near = abs(x[:, None] - x) + abs(y[:, None] - y) <= reach
    dark, lit = (((visible & bit) > 0) @ near for bit in (HIDDEN, VISIBLE))
    skip = x == 4
    found = light_edges(visible.astype(np.uint8), skip, WIDTH, reach)
    np.testing.assert_array_equal(found, np.flatnonzero(dark & lit & ~skip))
    assert 0 < len(found) < len(visible)


def test_even_light_has_no_end() -> None:
    for everywhere in (0, HIDDEN, VISIBLE):
        visible = np.full(WIDTH * HEIGHT, everywhere, np.uint8)
        assert not len(light_edges(visible, np.zeros(len(visible), np.bool_), WIDTH, 2))
