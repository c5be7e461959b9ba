"""Sparse vectors on cube maps: what is kept, how exactly, and their sums."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.numerics.cube_map import solid_angles
from engine.numerics.wavelet_vectors import (
    STEPS,
    WaveletVectors,
    added,
    dense,
    keep_largest,
    to_haar,
    white_light,
)

N = 8
TEXELS = 6 * N * N


def kept(
    texels: NDArray, most: int, weight: NDArray | None = None, tolerance: float = 0.0
) -> WaveletVectors:
    """Vectors of cube maps (r, TEXELS, c)."""
    rows, _, channels = texels.shape
    weight = np.ones(channels, np.float32) if weight is None else weight
    length, base = np.zeros(rows, np.int32), np.zeros((rows, 6, channels), np.float32)
    scale, place = np.zeros((rows, channels), np.float32), np.zeros((rows, most), np.uint16)
    steps = np.zeros((rows, most, channels), np.int8)
    for i in range(rows):
        values = np.array(texels[i], np.float32)
        to_haar(values)
        length[i] = keep_largest(
            values, white_light(N), weight, most, tolerance, base[i], scale[i], place[i], steps[i]
        )
    used = np.arange(most) < length[:, None]
    return WaveletVectors(length, base, scale, place[used], steps[used])


def noise(channels: int = 2, rows: int = 3) -> NDArray[np.float32]:
    return np.random.default_rng(1).normal(size=(rows, TEXELS, channels)).astype(np.float32)


def test_with_all_wavelets_only_eight_bits_are_lost() -> None:
    texels = noise()
    off = np.abs(dense(kept(texels, TEXELS), N) - texels)
    assert off.max() < 8 * np.abs(texels).max() / STEPS
    assert off.max() > 0


def test_constant_faces_are_exact_and_short() -> None:
    texels = np.repeat(np.random.default_rng(2).normal(size=(1, 6, 1)), N * N, axis=1)
    found = kept(texels.astype(np.float32), TEXELS)
    assert (found.length == 0).all()
    assert np.allclose(dense(found, N), texels, rtol=1e-6)


@pytest.mark.parametrize("most", [6, 20, 100])
def test_white_light_meets_what_it_did(most: int) -> None:
    texels = np.abs(noise())
    before = (texels * solid_angles(N)[:, None]).sum(axis=1)
    after = (dense(kept(texels, most), N) * solid_angles(N)[:, None]).sum(axis=1)
    assert np.allclose(after, before, rtol=1e-4)


def test_black_has_no_coefficients() -> None:
    found = kept(np.zeros((1, TEXELS, 3)), 20)
    assert found.length[0] == 0
    assert not dense(found, N).any()


@pytest.mark.parametrize("most", [6, 7, 20, 100])
def test_the_largest_are_kept(most: int) -> None:
    texels = noise(1, 1)
    values = texels[0].copy()
    to_haar(values)
    found = kept(texels, most)
    assert found.length[0] == most - 6
    details = np.abs(values[:, 0])
    details[:: N * N] = 0
    best = np.sort(details)[::-1][: most - 6]
    assert np.allclose(np.sort(details[found.place])[::-1], best)
    assert (np.diff(found.place.astype(int)) > 0).all()


def test_weights_tell_what_is_large() -> None:
    texels = noise(2, 1)
    for weight in ([1, 0], [0, 1]):
        values = texels[0].copy()
        to_haar(values)
        mine = np.abs(values[:, weight.index(1)])
        mine[:: N * N] = 0
        found = kept(texels, 36, np.array(weight, np.float32))
        assert set(found.place) == set(np.argsort(mine)[::-1][:30])


def test_more_places_never_make_it_worse() -> None:
    texels = noise()
    errors = [np.linalg.norm(dense(kept(texels, m), N) - texels) for m in (6, 30, 100, 384)]
    assert (np.diff(errors) < 0).all()


@pytest.mark.parametrize("tolerance", [0.02, 0.1, 0.5])
def test_a_tolerance_is_held_and_used(tolerance: float) -> None:
    texels = noise(1, 4)
    found = kept(texels, TEXELS, tolerance=tolerance)
    off = np.linalg.norm(dense(found, N) - texels, axis=1) / np.linalg.norm(texels, axis=1)
    assert (off < tolerance + 0.02).all()
    assert (off > 0.7 * tolerance).all()
    assert (found.length < TEXELS - 6).all()


def test_sums() -> None:
    a, b = kept(noise(), TEXELS), kept(noise()[::-1], TEXELS)
    found = dense(added(a, b, np.ones(2, np.float32), TEXELS, 0.0, N), N)
    assert np.abs(found - dense(a, N) - dense(b, N)).max() < 0.2
