"""GLSL helpers equal their Python twins."""

from __future__ import annotations

import numpy as np
import pytest
from backend.gl.one_call import call
from numba import njit

from engine.backend.gl.context import Device
from engine.light.environment_samples import places_on_map
from engine.numerics import frames, sampling
from engine.numerics.hemisphere_maps import disk_taps
from engine.numerics.vec import normalize

pytestmark = pytest.mark.gl
RNG = np.random.default_rng(1)


def directions(n: int) -> np.ndarray:
    v = RNG.normal(size=(n, 3))
    v = np.concatenate([v, np.eye(3), -np.eye(3), [[1e-4, -1, 1e-4], [1e-8, -1, 0]]])
    return (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)


def test_tangents(gpu: Device):
    n = directions(500)
    found = call(
        gpu, "common/frames.glsl", "s.x, s.y, s.z, t.x, t.y, t.z", 6,
        before="vec3 s, t; tangents(n, s, t);", n=n,
    )  # fmt: skip
    expected = [np.concatenate(frames.tangents(tuple(v))) for v in n.astype(float)]
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_local_and_world(gpu: Device):
    n, w = directions(200), directions(200)
    before = (
        "vec3 s, t; tangents(n, s, t); vec3 a = to_local(w, s, t, n), b = to_world(a, s, t, n);"
    )
    found = call(gpu, "common/frames.glsl", "a.z, b.x, b.y, b.z", 4, before=before, n=n, w=w)
    np.testing.assert_allclose(found[:, 0], (n * w).sum(axis=1), atol=1e-6)
    np.testing.assert_allclose(found[:, 1:], w, atol=1e-6)


def test_power(gpu: Device):
    x = np.concatenate([10 ** RNG.uniform(-6, 6, 2000), RNG.uniform(0.5, 2, 2000), [0, 0, 1]])
    y = np.concatenate([RNG.uniform(-4, 4, 2000), RNG.uniform(-50, 50, 2000), [0, 2, 1e5]])
    x, y = x.astype(np.float32), y.astype(np.float32)
    found = call(gpu, "common/power.glsl", "power(x, y)", 1, x=x[:, None], y=y[:, None])[:, 0]
    np.testing.assert_allclose(found, x.astype(float) ** y.astype(float), rtol=2e-5)


@pytest.mark.parametrize("n", [0, 1, 50, 1000, 1e5])
def test_lobe(gpu: Device, n: float):
    """Within what rounding the directions to float32 leaves of it."""
    angle = RNG.uniform(0, 1, 500) * min(1.5, 3 / np.sqrt(n + 1))
    a = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1).astype(np.float32)
    up = np.array([[0, 0, 1]], np.float32)
    found = call(gpu, "common/power.glsl", "lobe(a, b, n)", 1, a=a, b=up, n=np.array([[n]]))[:, 0]
    a64 = a.astype(float)
    versine = 0.5 * ((a64 - up) ** 2).sum(axis=1)
    np.testing.assert_allclose(found, np.exp(n * np.log1p(-versine)), rtol=5e-5)
    np.testing.assert_allclose(found, np.cos(angle) ** n, rtol=1e-5 + 2e-6 * np.sqrt(n) * 5)


@pytest.mark.parametrize("versine", [1e-5, 0.1, 1.0])
def test_cone(gpu: Device, versine: float):
    u = np.concatenate([RNG.random((500, 2)), [[0.5, 0.5], [0, 0], [1, 0.5]]]).astype(np.float32)
    found = call(
        gpu, "common/sampling.glsl", "w.x, w.y, w.z", 3,
        before="vec3 w = uniform_cone(u, v);", u=u, v=np.array([[versine]]),
    )  # fmt: skip
    expected = [_cone(*pair, np.float32(versine)) for pair in u.astype(float)]
    np.testing.assert_allclose(found, expected, atol=2e-6 + 2e-6 * versine)


@njit
def _cone(u1, u2, versine):
    return sampling.uniform_cone(u1, u2, versine)


def test_unit(gpu: Device):
    v = np.concatenate([RNG.normal(size=(200, 3)), np.zeros((1, 3))]).astype(np.float32)
    found = call(gpu, "common/frames.glsl", "w.x, w.y, w.z", 3, before="vec3 w = unit(v);", v=v)
    np.testing.assert_allclose(found, [normalize(tuple(a)) for a in v.astype(float)], atol=1e-6)


@pytest.mark.parametrize("size", [1, 2, 24])
def test_disk_taps(gpu: Device, size: int):
    w = directions(500)
    w[:, 2] = np.abs(w[:, 2])
    found = call(
        gpu, "common/hemisphere_maps.glsl", "a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w", 8,
        before="Taps t = disk_taps(w, int(size)); vec4 a = vec4(t.texel), b = t.weight;",
        w=w, size=np.array([[size]]),
    )  # fmt: skip
    for (*texels, a, b, c, d), v in zip(found, w.astype(float), strict=True):
        expected, (fx, fy) = disk_taps(tuple(v), size)
        assert tuple(texels) == expected
        weights = (1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy
        np.testing.assert_allclose((a, b, c, d), weights, atol=2e-6 * size)


def test_place_on_map(gpu: Device):
    """Near the poles the CPU's own angle has fewer digits; at them any column will do."""
    d = directions(3000)
    d = d[np.abs(d[:, 1]) < 1]
    found = call(
        gpu, "light/environment.glsl", "p.x, p.y", 2, before="vec2 p = place_on_map(d);",
        buffers={"b_map": gpu.floats(3)}, d=d,
    )  # fmt: skip
    expected = places_on_map(d)
    np.testing.assert_allclose(
        np.cos(2 * np.pi * found[:, 0]), np.cos(2 * np.pi * expected[:, 0]), atol=2e-6
    )
    np.testing.assert_allclose(found[:, 1], expected[:, 1], atol=1e-4)
    level = np.abs(d[:, 1]) < 0.9
    np.testing.assert_allclose(found[level], expected[level], atol=3e-7)
