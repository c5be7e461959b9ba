"""Adding a light: the example of the contract is one, and frames across an axis."""

from __future__ import annotations

import sys
import textwrap
import types
from collections.abc import Iterator

import numpy as np
import pytest
from numba import njit

from engine.light import base
from engine.light.base import across, towards
from engine.light.table import LIGHTS
from engine.numerics.dispatch import by_index
from engine.numerics.vec import vec

IMPORTS = """
from typing import Literal
from numba import njit
from numpy.typing import NDArray
import numpy as np
from engine.light.base import Light, no_formula, no_pdf, nothing_emitted
from engine.numerics.description import Point
from engine.numerics.vec import length
"""


@pytest.fixture
def glow() -> Iterator[types.ModuleType]:
    """The example of the contract's docstring, as a file of its own."""
    assert base.__doc__ is not None
    example = base.__doc__.partition("    class Glow(Light):")
    module = types.ModuleType("engine.light.glow")
    sys.modules[module.__name__] = module
    exec(IMPORTS + textwrap.dedent(example[1] + example[2]), module.__dict__)
    yield module
    del sys.modules[module.__name__]


def test_the_example_is_a_light(glow: types.ModuleType) -> None:
    """Described, packed, called by its number among the others, and the same near and far."""
    light = glow.Glow(id="g", position=(0, 2, 0), intensity=(3, 2, 1))
    modules = [*LIGHTS.values(), glow]
    illuminate = by_index([m.illuminate for m in modules], 6)
    pdf = by_index([m.pdf for m in modules], 3)

    @njit
    def call(kind, row, texels, x):
        w = illuminate(kind, row, texels, vec(x, 0), 0.0, 0.5, 0.5)
        return w, pdf(kind, row, vec(x, 0), (w[0], w[1], w[2]))

    for y in (0.0, -50.0):
        place = np.array([[0.0, y, 0.0]])
        found, density = call(len(LIGHTS), light.row(), np.zeros((0, 3), np.float32), place)
        assert found == (0, 1, 0, 2 - y, 3, 2, 1)
        assert density == 0
    for x in ((0.0, 2.0, 0.0), (0.0, 2.0, 1e-30)):
        values, _ = call(len(LIGHTS), light.row(), np.zeros((0, 3), np.float32), np.array([x]))
        assert np.isfinite(values).all()


def test_across_is_right_handed_and_never_fails() -> None:
    rng = np.random.default_rng(1)
    axes = [*rng.normal(size=(20, 3)), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 1e-4, 1)]
    for axis in axes:
        z = towards((0.0, 0.0, 0.0), tuple(axis))
        for up in ((0.0, 1.0, 0.0), (0.0, 0.0, 7.0), tuple(z)):
            s, t = across(z, up)
            frame = np.array([s, t, z])
            np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-9)
            assert np.linalg.det(frame) > 0
            assert np.dot(t, up) >= -1e-9
