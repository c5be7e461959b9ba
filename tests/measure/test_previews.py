"""When a preview is worth it, and what it is made with."""

from __future__ import annotations

from dataclasses import asdict

import pytest

from engine.measure.previews import PREVIEWS, preview_settings
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
