"""Where light ends: the pixels to look at more closely."""

from __future__ import annotations

import numpy as np
import pytest

from engine.backend.cpu.shading import HIDDEN, VISIBLE, light_edges, seen_around

WIDTH, HEIGHT = 9, 7


def some(seed: int) -> np.ndarray:
    """What pixels see of a light, some of which lie on no surface."""
    choices = [0, HIDDEN, VISIBLE, HIDDEN | VISIBLE]
    return np.random.default_rng(seed).choice(
        np.array(choices, np.uint8), WIDTH * HEIGHT, p=[0.6, 0.19, 0.19, 0.02]
    )


def steps() -> tuple[np.ndarray, np.ndarray]:
    """(across, down) between every two pixels."""
    y, x = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
    return abs(x[:, None] - x), abs(y[:, None] - y)


def test_all_one_step_from_both_light_and_shadow() -> None:
    """Brute force over all pairs of pixels."""
    visible = some(1)
    across, down = steps()
    dark, lit = (((visible & bit) > 0) @ (across + down <= 1) for bit in (HIDDEN, VISIBLE))
    skip = np.arange(WIDTH * HEIGHT) % WIDTH == 4
    found = light_edges(visible, skip, WIDTH)
    np.testing.assert_array_equal(found, np.flatnonzero(dark & lit & ~skip))
    assert 0 < len(found) < len(visible)


@pytest.mark.parametrize("reach", [0, 1, 2, 3])
def test_all_that_is_seen_in_a_square(reach: int) -> None:
    visible = some(reach)
    near = np.maximum(*steps()) <= reach
    dark, lit = (((visible & bit) > 0) @ near for bit in (HIDDEN, VISIBLE))
    np.testing.assert_array_equal(seen_around(visible, WIDTH, reach), dark * HIDDEN + lit * VISIBLE)


def test_even_light_has_no_end() -> None:
    for everywhere in (0, HIDDEN, VISIBLE):
        visible = np.full(WIDTH * HEIGHT, everywhere, np.uint8)
        assert not len(light_edges(visible, np.zeros(len(visible), np.bool_), WIDTH))
        assert (seen_around(visible, WIDTH, 2) == everywhere).all()
