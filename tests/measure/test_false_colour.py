"""Differences in false colour: which colours, what they stand for, what becomes of noise."""

from __future__ import annotations

import numpy as np
import pytest

from engine.measure.false_colour import WIDEST, difference, false_colour
from engine.measure.metrics import Image
from engine.measure.truth import Truth

SIDE = 40
WHITE = np.ones((SIDE, SIDE, 3), np.float32)
KEPT = np.ones((SIDE, SIDE), np.bool_)


def reference(image: Image, variance: float) -> Truth:
    return Truth(image, np.full_like(image, variance), 0.1, 1.0, 64)


def test_too_bright_is_red_too_dark_blue_and_equal_neutral() -> None:
    image = WHITE[:1, :3] * np.float32([[1.1], [1.0], [0.9]])
    bright, same, dark = false_colour(image, WHITE[:1, :3], KEPT[:1, :3], 0.1)[0]
    assert bright[0] > bright[2] + 0.2
    assert dark[2] > dark[0] + 0.2
    assert np.ptp(same) < 0.01


@pytest.mark.parametrize(("off", "full"), [(0.0, 0.02), (0.03, 0.05), (0.6, 1.0), (9.0, 2.0)])
def test_full_colours_are_as_far_off_as_most_pixels(off: float, full: float) -> None:
    image, kept = WHITE * np.float32(1 + off), KEPT.copy()
    image[0], kept[0] = 50, False  # an edge
    found = difference(image, reference(WHITE, 0.0), kept)
    assert (found.full, found.averaged) == (full, 1)
    assert np.ptp(found.colours[0]) < 0.01, "edges are left out"
    assert difference(image, reference(WHITE, 0.0), ~KEPT).full == 0.02


def test_noise_is_averaged_and_what_is_off_is_seen() -> None:
    """A tenth of noise would hide that a half of the picture is 3 % too dark."""
    noisy = (
        WHITE + np.float32(0.1) * np.random.default_rng(1).normal(size=WHITE.shape[:2])[..., None]
    )
    image = WHITE.copy()
    image[:, : SIDE // 2] *= 0.97
    found = difference(image, reference(noisy.astype(np.float32), 0.009), KEPT)
    assert found.averaged == 5
    assert difference(image, reference(noisy.astype(np.float32), 1.0), KEPT).averaged == WIDEST
    bluer = found.colours[..., 2] - found.colours[..., 0]
    assert bluer[:, : SIDE // 2].mean() > bluer[:, SIDE // 2 :].mean() + 0.2
    assert np.isclose(bluer[:, SIDE // 2 + 3 :].mean(), 0, atol=0.1)
