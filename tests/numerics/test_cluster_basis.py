"""Vectors of neighbours in a basis of their own: small, near, exact in even light."""

from __future__ import annotations

import numpy as np
import pytest

from engine.backend.cpu.vectors import Factor
from engine.numerics.cluster_basis import Clusters, cluster
from engine.numerics.cube_map import FACES
from engine.numerics.wavelet_vectors import WaveletVectors, keep_largest, room_for, white_light

N = 16
TEXELS = FACES * N * N
WHITE = white_light(N)


def alike(count: int, channels: int, hidden: int = 3, *, apart: bool = False) -> WaveletVectors:
    """Vectors that are sums of `hidden` others, channels of others each if they are apart."""
    rng = np.random.default_rng(1)
    decay = 1 / (1 + np.arange(N * N)) ** 0.7
    parts = rng.normal(size=(hidden, TEXELS)) * np.tile(decay, FACES)
    parts[:, :: N * N] = np.abs(parts[:, :: N * N]) + 1
    share = rng.uniform(0.2, 1, (count, channels, hidden))
    if apart:
        share *= np.arange(hidden) % channels == np.arange(channels)[:, None]
    exact = share @ parts
    exact += 1e-3 * rng.normal(size=exact.shape) * np.abs(exact)
    room = room_for(count, 1024, channels)
    for i in range(count):
        room.length[i] = keep_largest(
            exact[i].T.astype(np.float32).copy(), WHITE, np.ones(channels, np.float32), 1024, 0.0,
            room.base[i], room.scale[i], room.place[i], room.steps[i],
        )  # fmt: skip
    return room.packed()


def product(stored: WaveletVectors | Clusters, terms: int, light: np.ndarray) -> np.ndarray:
    factor = Factor(stored, terms)
    out = np.zeros((factor.vertices, terms, 3), np.float32)
    factor.add_product(light.astype(np.float32), out)
    return out


def lights() -> list[np.ndarray]:
    rng = np.random.default_rng(5)
    return [rng.normal(size=(TEXELS, 3)) for _ in range(8)]


@pytest.mark.parametrize(("terms", "channels"), [(1, 1), (4, 1), (2, 3)])
@pytest.mark.parametrize("error", [0.2, 0.05, 0.01])
def test_the_error_is_what_was_asked_for(terms: int, channels: int, error: float) -> None:
    vectors = alike(60, terms * channels, hidden=20)
    made = cluster(vectors, WHITE, np.ones(terms * channels, np.float32), error)
    far = whole = 0.0
    for light in lights():
        true = product(vectors, terms, light)
        far += np.linalg.norm(product(made, terms, light) - true) ** 2
        whole += np.linalg.norm(true) ** 2
    # Leaving places out may add half, eight bits a thousandth or two.
    assert np.sqrt(far / whole) < 1.3 * error + 0.004


def test_a_smaller_error_takes_more_components() -> None:
    vectors = alike(60, 4, hidden=20)
    rank = [cluster(vectors, WHITE, np.ones(4, np.float32), e).rank[0] for e in (0.2, 0.05, 0.01)]
    assert rank[0] < rank[1] < rank[2]


def test_what_is_alike_takes_few_components() -> None:
    """Sums of three others: three components, and that of even light."""
    made = cluster(alike(200, 4, hidden=3), WHITE, np.ones(4, np.float32), 0.05)
    assert made.rank[0] == 4


@pytest.mark.parametrize(("terms", "channels"), [(1, 1), (4, 1), (2, 3)])
def test_even_light_is_exact_however_coarse_the_rest(terms: int, channels: int) -> None:
    vectors = alike(60, terms * channels, hidden=20)
    made = cluster(vectors, WHITE, np.ones(terms * channels, np.float32), 0.2)
    even = WHITE[:, None] * np.ones(3)
    found, true = product(made, terms, even), product(vectors, terms, even)
    assert np.abs(found - true).max() < 1e-3 * np.abs(true).max()


def test_a_channel_that_counts_little_takes_few() -> None:
    vectors = alike(60, 2, hidden=20, apart=True)
    both, first = (
        cluster(vectors, WHITE, np.array(weight, np.float32), 0.05).rank[0]
        for weight in ((1, 1), (1, 1e-3))
    )
    assert first < 0.7 * both


def test_black_vectors_and_no_vectors() -> None:
    for count in (0, 5):
        black = room_for(count, 6, 4).packed()
        made = cluster(black, WHITE, np.ones(4, np.float32), 0.05)
        assert made.rank[0] == 0
        found = product(made, 4, np.ones((TEXELS, 3)))
        assert found.shape == (count, 4, 3)
        assert not found.any()


def test_some_black_among_others() -> None:
    vectors = alike(20, 4)
    both = WaveletVectors(
        np.concatenate([vectors.length, np.zeros(5, np.int32)]),
        np.concatenate([vectors.base, np.zeros((5, FACES, 4), np.float32)]),
        np.concatenate([vectors.scale, np.zeros((5, 4), np.float32)]),
        vectors.place,
        vectors.steps,
    )
    made = cluster(both, WHITE, np.ones(4, np.float32), 0.01)
    assert not product(made, 4, np.ones((TEXELS, 3)))[20:].any()


def test_the_same_bytes_every_time() -> None:
    vectors, weight = alike(60, 4), np.ones(4, np.float32)
    first, second = (cluster(vectors, WHITE, weight, 0.05) for _ in range(2))
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))
