"""Transport vectors times a light on the GPU equal those on the CPU."""

from __future__ import annotations

import numpy as np
import pytest

from engine.backend.cpu.vectors import Factor
from engine.backend.gl.context import Device
from engine.backend.gl.vectors import Part, StoredVectors
from engine.numerics.cluster_basis import Clusters, cluster
from engine.numerics.cube_map import FACES
from engine.numerics.wavelet_vectors import WaveletVectors, white_light

pytestmark = pytest.mark.gl
SIZE = 16 * 16
LIGHT = np.random.default_rng(1).lognormal(size=(FACES * SIZE, 3)).astype(np.float32)


def some_vectors(rows: int, columns: int, longest: int, seed: int = 2) -> WaveletVectors:
    """Of any lengths up to the longest, none among them."""
    rng = np.random.default_rng(seed)
    length = rng.integers(0, longest + 1, rows).astype(np.int32)
    q = int(length.sum())
    return WaveletVectors(
        length,
        rng.normal(size=(rows, FACES, columns)).astype(np.float32),
        rng.lognormal(size=(rows, columns)).astype(np.float32),
        rng.integers(0, FACES * SIZE, q).astype(np.uint16),
        rng.integers(-127, 128, (q, columns)).astype(np.int8),
    )


def some_clusters(rows: int, columns: int, longest: int, clusters: int = 3) -> Clusters:
    white = white_light(16)
    made = [
        cluster(some_vectors(rows, columns, longest, seed), white, np.ones(columns), 0.1)
        for seed in range(clusters)
    ]
    return Clusters(*map(np.concatenate, zip(*made, strict=True)))


def on_cpu(part: Part) -> np.ndarray:
    factor = Factor(part.vectors, part.terms)
    out = np.zeros((factor.vertices, part.terms, 3), np.float32)
    factor.add_product(LIGHT, out)
    return out.reshape(-1, 3)


def on_gpu(gpu: Device, rows: int, *sets: list[Part]) -> np.ndarray:
    out = StoredVectors(gpu, len(LIGHT), *sets).multiply(LIGHT)
    return np.frombuffer(out.read(12 * rows), np.float32).reshape(rows, 3)


def assert_same(found: np.ndarray, expected: np.ndarray) -> None:
    assert np.linalg.norm(found - expected) < 1e-6 * np.linalg.norm(expected)
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("terms", [1, 3, 4, 5, 13])
@pytest.mark.parametrize("longest", [0, 1, 15, 16, 17, 130])
def test_one_part(gpu: Device, terms: int, channels: int, longest: int) -> None:
    part = Part(0, terms, some_vectors(37, terms * channels, longest))
    assert_same(on_gpu(gpu, 37 * terms, [part]), on_cpu(part))


@pytest.mark.parametrize(("terms", "channels"), [(1, 1), (4, 1), (3, 3)])
@pytest.mark.parametrize("longest", [0, 30])
def test_clusters(gpu: Device, terms: int, channels: int, longest: int) -> None:
    part = Part(0, terms, some_clusters(37, terms * channels, longest))
    expected = on_cpu(part)
    assert expected.any()
    assert_same(on_gpu(gpu, len(expected), [part], [part]), 2 * expected)


@pytest.mark.parametrize("rows", [1, 3, 4, 5, 1000])
def test_any_number_of_vectors(gpu: Device, rows: int) -> None:
    part = Part(0, 2, some_vectors(rows, 2, 40))
    assert_same(on_gpu(gpu, 2 * rows, [part]), on_cpu(part))


def test_materials_lie_behind_each_other_and_sets_add_up(gpu: Device) -> None:
    """Grey direct transport beside coloured bounces; one material has no vertices."""
    terms, counts, first = (4, 1, 2), (30, 0, 11), (0, 120, 120)
    sets = [
        [
            Part(start, k, some_vectors(count, k * channels, 20, seed))
            for start, k, count in zip(first, terms, counts, strict=True)
        ]
        for seed, channels in ((3, 1), (4, 3))
    ]
    expected = sum(np.concatenate([on_cpu(part) for part in parts]) for parts in sets)
    assert_same(on_gpu(gpu, 142, *sets), expected)


def test_the_same_bytes_every_time_and_no_light_is_black(gpu: Device) -> None:
    vectors = StoredVectors(gpu, len(LIGHT), [Part(0, 4, some_vectors(50, 4, 60))])
    first = vectors.multiply(LIGHT).read()
    assert not any(vectors.multiply(0 * LIGHT).read())
    assert vectors.multiply(LIGHT).read() == first
