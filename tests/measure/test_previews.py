"""When a preview is worth it, and what it is made with."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

from engine.measure.previews import PREVIEWS, doubled, halved, preview_settings
from engine.methods import METHODS
from engine.scene.open import open_scene
from engine.scene.scene import Scene


@pytest.fixture(scope="module")
def box() -> Scene:
    return open_scene("cornell-box")


@pytest.fixture(autouse=True)
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RELIGHT_THREADS", "2")


def small(scene: Scene) -> Scene:
    return scene.with_camera(scene.camera.model_copy(update={"width": 64, "height": 64}))


@pytest.mark.parametrize("method", list(PREVIEWS))
def test_usual_settings_are_lowered_for_a_large_picture_alone(method: str, box: Scene) -> None:
    usual = METHODS[method].settings()
    quick = preview_settings(box, method, usual)
    assert {**asdict(usual), **PREVIEWS[method]} == asdict(quick)
    few = METHODS[method].settings(gather_samples=1024)
    assert preview_settings(small(box), method, few) is None


def test_many_cores_need_none(box: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RELIGHT_THREADS", "64")
    assert (
        preview_settings(box, "direct_to_indirect", METHODS["direct_to_indirect"].settings())
        is None
    )


def test_what_the_user_has_lower_stays(box: Scene) -> None:
    asked = METHODS["direct_to_indirect"].settings(coefficients=7, seed=3)
    quick = preview_settings(box, "direct_to_indirect", asked)
    assert (quick.coefficients, quick.seed) == (7, 3)
    assert quick.view_rays < asked.view_rays


def test_methods_without_one(box: Scene) -> None:
    for method in METHODS.keys() - PREVIEWS.keys():
        assert preview_settings(box, method, METHODS[method].settings()) is None


@pytest.mark.parametrize(("width", "height"), [(7, 4), (1, 1), (2, 5)])
def test_half_a_picture_and_back(box: Scene, width: int, height: int) -> None:
    """What is even stays even, a ramp a ramp but at the rim; pixels stay where they are."""
    odd = box.with_camera(box.camera.model_copy(update={"width": width, "height": height}))
    camera = halved(odd).camera
    half = (camera.height, camera.width)
    assert half == ((height + 1) // 2, (width + 1) // 2)
    even = doubled(np.full((*half, 3), 2, np.float32), width, height)
    assert even.shape == (height, width, 3)
    assert even.dtype == np.float32
    assert (even == 2).all()
    ramp = np.arange(half[1], dtype=np.float32)[None, :, None] + np.zeros((*half, 3), np.float32)
    inner = doubled(ramp, width, height)[:, 1 : 2 * half[1] - 1]
    centres = (np.arange(width)[1 : 2 * half[1] - 1] + 0.5) / 2 - 0.5
    np.testing.assert_allclose(inner, np.broadcast_to(centres[:, None], inner.shape), atol=1e-6)
