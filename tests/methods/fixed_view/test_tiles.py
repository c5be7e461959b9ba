"""Tiles cover every pixel once, and the coarse picture is every fourth of their rows."""

from __future__ import annotations

import numpy as np
import pytest

from engine.methods.fixed_view.tiles import coarse_tiles, pixel_tiles, run_tiles

SIZES = [(1, 1), (8, 8), (16, 8), (7, 9), (33, 17), (1, 40), (63, 2)]


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_every_pixel_is_in_one_tile(width: int, height: int):
    tiles = pixel_tiles(width, height)
    assert tiles.shape == (-(-width // 8) * -(-height // 8), 64)
    np.testing.assert_array_equal(np.sort(tiles[tiles >= 0]), np.arange(width * height))
    for tile in tiles:
        y, x = np.divmod(tile[tile >= 0], width)
        assert len(np.unique(y // 8)) == len(np.unique(x // 8)) == 1


def test_pixels_are_in_quad_tree_order():
    """Four in a row are a block of 2 x 2, sixteen one of 4 x 4."""
    tile = pixel_tiles(16, 16)[3]
    for run in (1, 2, 4, 8):
        y, x = np.divmod(tile.reshape(-1, run * run), 16)
        assert (np.ptp(x, axis=1) == run - 1).all()
        assert (np.ptp(y, axis=1) == run - 1).all()


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_coarse_tiles_are_every_second_pixel(width: int, height: int):
    coarse, full = coarse_tiles(width, height), pixel_tiles(width, height)[:, ::4]
    every_second = np.arange(width * height).reshape(height, width)[::2, ::2].ravel()
    np.testing.assert_array_equal(coarse >= 0, full >= 0)
    np.testing.assert_array_equal(every_second[coarse[coarse >= 0]], full[full >= 0])
    np.testing.assert_array_equal(np.sort(coarse[coarse >= 0]), np.arange(len(every_second)))


@pytest.mark.parametrize("n", [1, 63, 64, 65, 4096])
def test_runs(n: int):
    runs = run_tiles(n)
    np.testing.assert_array_equal(runs.ravel()[:n], np.arange(n))
    assert (runs.ravel()[n:] == -1).all()
