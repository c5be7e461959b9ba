"""The passes over a picture equal their twins on the CPU."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from methods.direct_to_indirect.test_gl import shiny
from pydantic import TypeAdapter

from engine.backend.cpu import penumbra, shading
from engine.backend.gl.bvh import build_tree
from engine.backend.gl.context import Device
from engine.backend.gl.shading import HAS_SUBSAMPLES, Shading, light_ends, smooth_penumbrae
from engine.backend.gl.sums import add, reflect
from engine.light.table import AnyLight, light_table
from engine.methods.fixed_view.direct import CENTRE
from engine.methods.fixed_view.gl_view import GlView, upload_points
from engine.methods.fixed_view.view import View

pytestmark = pytest.mark.gl


@pytest.fixture(scope="module")
def view(tmp_path_factory: pytest.TempPathFactory) -> View:
    return View(shiny(tmp_path_factory.mktemp("shiny")))


def array(buffer: Any, n: int) -> np.ndarray:
    return np.frombuffer(buffer.read(12 * n), np.float32).reshape(n, 3)


def test_where_light_ends(gpu: Device) -> None:
    width, height = 67, 41
    rng = np.random.default_rng(1)
    visible = rng.choice([0, 1, 2, 3], width * height, p=[0.5, 0.24, 0.24, 0.02]).astype(np.uint8)
    skip = rng.random(len(visible)) < 0.1
    listed = gpu.room(4 * (1 + len(visible)))
    for _ in range(2):  # the second list takes the place of the first
        light_ends(
            gpu, gpu.upload(visible.astype(np.int32)),
            gpu.upload(HAS_SUBSAMPLES * skip.astype(np.int32)), width, len(visible), listed,
        )  # fmt: skip
    count, *pixels = np.frombuffer(listed.read(), np.int32)
    expected = shading.light_edges(visible, skip, width)
    assert 0 < len(expected) < len(visible)
    np.testing.assert_array_equal(np.sort(pixels[:count]), expected)


def test_penumbrae(gpu: Device, view: View) -> None:
    points, alike, width = view.buffer.centre, view.buffer.alike, view.scene.camera.width
    radiance = np.random.default_rng(2).random((len(points), 3)).astype(np.float32)
    buffer = gpu.upload(radiance)
    smooth_penumbrae(
        gpu, upload_points(gpu, points), gpu.upload(alike.astype(np.int32)), width, buffer,
        gpu.room(radiance.nbytes),
    )  # fmt: skip
    expected = penumbra.smooth_penumbrae(radiance, points.row, alike, width)
    np.testing.assert_allclose(array(buffer, len(points)), expected, rtol=1e-5, atol=1e-6)


def test_sums(gpu: Device) -> None:
    rng = np.random.default_rng(3)
    n = 1000
    a, b = rng.random((2, n, 3)).astype(np.float32)
    total = gpu.upload(a)
    add(gpu, total, gpu.upload(b), n, (1.0, 2.0, -0.5))
    expected = a + b * np.float32([1, 2, -0.5])
    np.testing.assert_allclose(array(total, n), expected, rtol=1e-6, atol=1e-7)
    reflect(gpu, total, gpu.upload(b), n, 0.7)
    expected *= 0.7 * b
    np.testing.assert_allclose(array(total, n), expected, rtol=1e-5, atol=1e-7)


def test_more_items_than_threads(gpu: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    """What one thread would take is taken by others, several items each."""
    monkeypatch.setattr("engine.backend.gl.context.MOST_GROUPS", 3)
    total, n = gpu.floats(3 * 1000), 1000
    add(gpu, total, gpu.upload(np.ones((n, 3), np.float32)), n)
    assert (array(total, n) == 1).all()


LAMPS: dict[str, dict[str, Any]] = {
    # Each in the open for one part and behind the ball or the block for another.
    "area": {"position": [0.3, 0.5, -0.4], "target": [0.4, 0.9, 2.2], "width": 0.7, "height": 0.3},
    "disk": {"position": [-0.3, 0.5, -0.5], "target": [0.4, 0.9, 2.2], "radius": 0.2},
    "sphere": {"position": [0.4, 0.6, -0.3], "radius": 0.25},
    "sun": {"direction": [-0.34, 0.1, 1.03], "diameter_degrees": 12},
}


@pytest.mark.parametrize("scale", [1, 2])
@pytest.mark.parametrize("kind", LAMPS)
def test_lamps_in_the_picture(gpu: Device, view: View, kind: str, scale: int) -> None:
    light = TypeAdapter(AnyLight).validate_python({"id": kind, "type": kind, **LAMPS[kind]})
    points = view.points(scale)
    expected = np.full((len(points), 3), 2, np.float32)
    view._show_light(light, scale, expected)
    total = gpu.upload(np.full((len(points), 3), 2, np.float32))
    GlView(gpu, view)._show(light, scale, total)
    found = array(total, len(points))
    changed = (expected != 2).any(axis=1)
    assert 10 < changed.sum() < 0.5 * len(points)
    # At the rim rounding decides: one of sixteen places in a pixel or two.
    wrong = np.abs(found - expected).max(axis=1) > 1e-5 * np.abs(expected).max()
    assert wrong.sum() <= 2
    assert np.linalg.norm(found - expected) < 1e-3 * np.linalg.norm(expected)


@pytest.mark.parametrize("kind", ["spot", "area", "projector"])
def test_light_on_points_whose_normals_lean(gpu: Device, view: View, kind: str) -> None:
    """Shading normals may lean so far that a light is over one of the two normals alone."""
    rng = np.random.default_rng(5)
    points = view.buffer.sub.take(slice(None))
    lean = points.normal + rng.normal(scale=0.8, size=points.normal.shape)
    lean *= np.sign((lean * points.view).sum(axis=1, keepdims=True))
    points.normal[:] = lean / np.linalg.norm(lean, axis=1, keepdims=True)
    points.phase[:] = rng.integers(0, 16, len(points))
    n, rays = len(points), view.scene.rays
    table = light_table([light for light in view.scene.lights if light.id == kind])
    samples = rng.random((4, 3, 2)) if table.extent[0] else CENTRE
    at = np.arange(n, dtype=np.int32)
    expected, visible = shading.light_points(
        rays, at, points.position, points.normal, points.geometric, points.view, points.model,
        points.row, points.phase, points.size, table, samples,
    )  # fmt: skip
    radiance, found = gpu.room(12 * n), gpu.room(4 * n)
    geometry = view.scene.geometry
    tree = build_tree(geometry.positions, geometry.triangles)
    lit = Shading(gpu, tree, rays.epsilon)
    lit.points(upload_points(gpu, points), table, samples, radiance, found)
    assert len(set(visible)) >= 3
    wrong = np.frombuffer(found.read(4 * n), np.int32) != visible
    assert wrong.mean() < 1e-3
    off = (array(radiance, n) - expected)[~wrong]
    assert np.linalg.norm(off) < 1e-4 * np.linalg.norm(expected)
