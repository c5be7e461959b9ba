"""Every light shader in GLSL equals its Python twin."""

from __future__ import annotations

import numpy as np
import pytest
from backend.gl.one_call import call
from light.lights import EXAMPLES, WIDE, emitted, glance, illuminate, irradiance

from engine.backend.gl.context import Device
from engine.backend.gl.tables import CHOSEN_LIGHT, chosen_light
from engine.light.base import Light
from engine.light.table import LIGHTS, light_table
from engine.resources import resource

pytestmark = pytest.mark.gl
COUNT = 3000


def test_every_kind_is_here() -> None:
    assert {type(light) for light in EXAMPLES} == set(LIGHTS)


@pytest.mark.parametrize("light", EXAMPLES, ids=lambda light: light.id)
@pytest.mark.parametrize("size", [0.0, 0.05])
def test_illuminate(gpu: Device, light: Light, size: float) -> None:
    rng = np.random.default_rng(3)
    x = rng.uniform(-1, 1, (COUNT, 3)).astype(np.float32)
    x[:4] = [0, 0, 0], light.row()[:3], [0.5, 0.2, 0.2], [0.3, 0, -0.2]
    u = rng.integers(0, 8, (COUNT, 2)).astype(np.float32) / 8 + 1 / 16
    table = light_table([light])
    found = call(
        gpu, CHOSEN_LIGHT, "a.w.x, a.w.y, a.w.z, a.distance, a.rgb.x, a.rgb.y, a.rgb.z", 7,
        made={CHOSEN_LIGHT: chosen_light(int(table.kind[0]))},
        buffers={"b_texels": gpu.upload(table.texels)},
        before="Lit a = illuminate(p, x, size, u);",
        p=table.row, x=x, u=u, size=np.array([[size]]),
    )  # fmt: skip
    expected = illuminate(light, x, u, np.float32(size))
    assert np.isfinite(found).all()
    np.testing.assert_allclose(np.linalg.norm(found[:, :3], axis=1), 1, atol=1e-5)
    lit = expected[:, 4:].max(axis=1) > 0
    assert lit.any()
    assert ((found[:, 4:].max(axis=1) > 0) == lit).mean() > 0.999
    lit &= found[:, 4:].max(axis=1) > 0
    scale = np.linalg.norm(expected[lit, 4:])
    assert np.linalg.norm(found[lit, 4:] - expected[lit, 4:]) < 1e-5 * scale
    # Of a lamp seen on edge, within half a degree, float32 leaves two digits of the place on it.
    on_edge = np.abs((expected[:, :3] * light.row()[3:6]).sum(axis=1)) < 0.01
    if np.any(light.row()[3:6]):
        lit &= ~on_edge
    off = np.linalg.norm((found - expected)[lit, :3], axis=1)
    assert (off < 1e-4).mean() > 0.998
    assert off.max() < 1e-3
    np.testing.assert_allclose(found[lit, 3], expected[lit, 3], rtol=1e-3)


@pytest.mark.parametrize("light", WIDE, ids=lambda light: light.id)
def test_emitted(gpu: Device, light: Light) -> None:
    """Along rays at places on the lamp, past its rim, and away from it."""
    rng = np.random.default_rng(4)
    o = rng.uniform(-1, 1, (COUNT, 3)).astype(np.float32)
    d = illuminate(light, o, rng.random((COUNT, 2)))[:, :3] + rng.normal(size=(COUNT, 3)) * (
        10 ** rng.uniform(-5, 0, (COUNT, 1))
    )
    d = (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(np.float32)
    table = light_table([light])
    found = call(
        gpu, CHOSEN_LIGHT, "a.w, a.x, a.y, a.z", 4,
        made={CHOSEN_LIGHT: chosen_light(int(table.kind[0]))},
        before="vec4 a = emitted(p, o, d);", p=table.row, o=o, d=d,
    )  # fmt: skip
    expected = emitted(light, o, d)
    met = expected[:, 0] >= 0
    assert 0.02 < met.mean() < 1
    # At the rim rounding decides; from afar the rim is everywhere.
    both = met & (found[:, 0] >= 0)
    assert (met != (found[:, 0] >= 0)).mean() < 2e-3
    np.testing.assert_allclose(found[both], expected[both], rtol=2e-3)


@pytest.mark.parametrize("light", WIDE, ids=lambda light: light.id)
def test_irradiance(gpu: Device, light: Light) -> None:
    """Over, under and across the horizon, and for normals that lean."""
    rng = np.random.default_rng(6)
    x = rng.uniform(-1, 1, (COUNT, 3)).astype(np.float32)
    n = rng.normal(size=(COUNT, 3))
    g = n + rng.normal(size=(COUNT, 3)) * (0.3 * (np.arange(COUNT) % 2))[:, None]
    n, g = ((v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32) for v in (n, g))
    table = light_table([light])
    found = call(
        gpu, CHOSEN_LIGHT, "a.x, a.y, a.z", 3,
        made={CHOSEN_LIGHT: chosen_light(int(table.kind[0]))},
        before="vec3 a = irradiance(p, x, n, g);", p=table.row, x=x, n=n, g=g,
    )  # fmt: skip
    expected = irradiance(light, x, n, g)
    assert ((found < 0) == (expected < 0)).mean() > 0.998
    known = (found[:, 0] >= 0) & (expected[:, 0] >= 0)
    assert (expected[known] > 0).any()
    scale = expected[known].max()
    # Of a tiny lamp on the horizon float32 leaves less.
    np.testing.assert_allclose(found[known], expected[known], rtol=1e-3, atol=1e-4 * scale)
    assert np.linalg.norm((found - expected)[known]) < 1e-5 * np.linalg.norm(expected[known])


@pytest.mark.parametrize("light", WIDE, ids=lambda light: light.id)
def test_glance(gpu: Device, light: Light) -> None:
    rng = np.random.default_rng(7)
    x = rng.uniform(-1, 1, (COUNT, 3)).astype(np.float32)
    u = rng.integers(0, 8, (COUNT, 2)).astype(np.float32) / 8 + 1 / 16
    table = light_table([light])
    found = call(
        gpu, CHOSEN_LIGHT, "a.w.x, a.w.y, a.w.z, a.distance, a.rgb.x, a.rgb.y, a.rgb.z", 7,
        made={CHOSEN_LIGHT: chosen_light(int(table.kind[0]))},
        before="Lit a = glance(p, x, 0.0, u);", p=table.row, x=x, u=u,
    )  # fmt: skip
    expected = glance(light, x, u)
    lit = (expected[:, 4] > 0) & (found[:, 4] > 0)
    assert ((expected[:, 4] > 0) == lit).mean() > 0.998
    # At the limit of `illuminate` rounding decides which of two ways a sample is taken.
    off = np.abs(found - expected)[lit] / np.maximum(1, np.abs(expected[lit]))
    assert (off.max(axis=1) < 1e-3).mean() > 0.995


def test_the_example_of_the_readme(gpu: Device) -> None:
    """A light of the user's own, as it would lie beside the others."""
    text = (resource("shaders") / "README.md").read_text()
    example = text.partition("```glsl\n")[2].partition("```")[0]
    x = np.random.default_rng(5).normal(size=(20, 3)).astype(np.float32)
    p = np.zeros((1, 32), np.float32)
    p[0, :9] = 1, 2, 3, 0, 0, 0, 4, 5, 6
    found = call(
        gpu, "light/glow.glsl", "a.w.x, a.w.y, a.w.z, a.distance, a.rgb.x, a.rgb.y, a.rgb.z", 7,
        made={"light/glow.glsl": example}, before="Lit a = illuminate_glow(p, x, 0.0, vec2(0.5));",
        p=p, x=x,
    )  # fmt: skip
    way = p[0, :3] - x
    far = np.linalg.norm(way, axis=1, keepdims=True)
    expected = np.concatenate([way / far, far, np.tile([4, 5, 6], (20, 1))], axis=1)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6)
