"""Local frames: orthonormal, right-handed, and with one discontinuity alone."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from engine.numerics.frames import tangents, to_local, to_world
from engine.numerics.vec import cross, dot, length, normalize, reflect, vec


@njit
def _frames(n, out):
    for i in range(len(n)):
        s, t = tangents(vec(n, i))
        for k in range(3):
            out[i, 0, k], out[i, 1, k] = s[k], t[k]


def frames(n: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m, 3, 3): rows s, t, n."""
    out = np.zeros((len(n), 3, 3))
    out[:, 2] = n
    _frames(n, out)
    return out


def normals() -> NDArray[np.float64]:
    """Random, along the axes, and ever nearer to the discontinuity at -y."""
    rng = np.random.default_rng(1)
    n = [rng.normal(size=(1000, 3)), np.eye(3), -np.eye(3)]
    for size in np.geomspace(1e-12, 1, 25):
        n.append(np.array([0, -1, 0]) + size * rng.normal(size=(20, 3)))
    stacked = np.concatenate(n)
    return stacked / np.linalg.norm(stacked, axis=1, keepdims=True)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_orthonormal_and_right_handed(dtype: type) -> None:
    """For normals that were rounded to float32 too, as the scene's are."""
    n = normals().astype(dtype).astype(np.float64)
    made = frames(n)
    assert np.isfinite(made).all()
    error = made @ made.transpose(0, 2, 1) - np.eye(3)
    assert np.abs(error).max() < (2e-10 if dtype is np.float64 else 5e-7)
    np.testing.assert_allclose(np.linalg.det(made), 1, atol=1e-6)


def test_formula_of_the_paper() -> None:
    """`glossy_prt` §3.3.2: the tangent is the x axis seen through a stereographic projection."""
    n = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.6, 0.0, 0.8]])
    expected = [(1, 0, 0), (1, 0, 0), (1, 0, 0), (1 - 0.36 + 0.64, -1.2, -0.96)]
    s = np.array(expected) / np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(frames(n)[:, 0], s, atol=1e-12)


def test_continuous_but_at_one_point() -> None:
    """A small step of the normal is a small step of the tangent, away from -y."""
    rng = np.random.default_rng(2)
    n = rng.normal(size=(5000, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    n = n[n[:, 1] > -0.9]
    m = n + 1e-6 * rng.normal(size=n.shape)
    m /= np.linalg.norm(m, axis=1, keepdims=True)
    assert np.abs(frames(m) - frames(n)).max() < 1e-4


@njit
def _there_and_back(w, n, out):
    for i in range(len(w)):
        s, t = tangents(vec(n, i))
        v = to_world(to_local(vec(w, i), s, t, vec(n, i)), s, t, vec(n, i))
        out[i, 0], out[i, 1], out[i, 2] = v


def test_world_and_back() -> None:
    n, w = normals(), normals()[::-1].copy()
    out = np.zeros_like(w)
    _there_and_back(w, n, out)
    np.testing.assert_allclose(out, w, atol=2e-10)
    # The normal is z in its own frame.
    assert to_local((0.0, 0.0, 1.0), *tangents((0.0, 0.0, 1.0)), (0.0, 0.0, 1.0)) == (0, 0, 1)


def test_vectors_against_numpy() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        a, b = (tuple(float(x) for x in row) for row in rng.normal(size=(2, 3)))
        np.testing.assert_allclose(cross(a, b), np.cross(a, b))
        assert dot(a, b) == pytest.approx(np.dot(a, b))
        assert length(normalize(a)) == pytest.approx(1)
        n = normalize(b)
        mirrored = reflect(a, n)
        assert dot(mirrored, n) == pytest.approx(dot(a, n))
        np.testing.assert_allclose(reflect(mirrored, n), a)
    assert normalize((0.0, 0.0, 0.0)) == (0, 0, 0)
