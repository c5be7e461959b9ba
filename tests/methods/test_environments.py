"""What every renderer makes of an environment's area light, and of one without background."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from methods.scenes import camera, rectangle, scene
from numpy.typing import NDArray

from engine.methods import prepare
from engine.methods.direct_to_indirect.settings import Settings as TransferSettings
from engine.methods.fixed_view.preview import DirectPreview
from engine.methods.glossy_prt.settings import Settings as PrtSettings
from engine.reference import render, render_direct
from engine.scene.edits import Edits, apply
from engine.scene.scene import Scene
from engine.store import Store

ALBEDO = 0.5
Draw = Callable[[dict[str, Any]], NDArray[np.float32]]


def open_floor(size: int = 12) -> Scene:
    """A matt floor under a black sky; the camera sees it and what is above it."""
    floor = rectangle("floor", [4, 4], [0, 0, 0], [-90, 0, 0])
    return scene(
        camera=camera(size, position=[0, 1, 3], target=[0, 0.4, 0], fov_y_degrees=50),
        environment={"map": [0, 0, 0]},
        materials={"floor": {"type": "diffuse", "diffuse": [ALBEDO] * 3}},
        objects=[{**floor, "material": "floor"}],
    )


@pytest.fixture(scope="module")
def renderers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Draw]:
    """By name: from an edit of the environment to a picture of the floor."""
    store = Store(tmp_path_factory.mktemp("store"))
    floor = open_floor()
    prt = prepare(
        floor, "glossy_prt", PrtSettings(bounces=0, coefficients=1024, tolerance=0), store=store
    )
    transfer = prepare(
        floor, "direct_to_indirect", TransferSettings(gather_samples=256), store=store
    )
    preview = DirectPreview(floor)

    def edits(environment: dict[str, Any]) -> Edits:
        return Edits(environment=environment)

    return {
        "reference": lambda e: render(apply(floor, edits(e)), samples=256).image,
        "brute force": lambda e: render_direct(apply(floor, edits(e)), samples=256).image,
        "preview": lambda e: preview.relight(edits(e)).image,
        "direct_to_indirect": lambda e: transfer.relight(edits(e), backend="cpu").image,
        "glossy_prt": lambda e: prt.relight(edits(e), backend="cpu").image,
    }


NAMES = ["reference", "brute force", "preview", "direct_to_indirect", "glossy_prt"]
# What noise there is in a mean over the floor, and what wavelets leave out.
CLOSE = {"reference": 0.01, "brute force": 0.01, "preview": 0.05, "glossy_prt": 0.01}
every_renderer = pytest.mark.parametrize("name", NAMES)
FLOOR, SKY = slice(8, 12), slice(0, 2)


@every_renderer
@pytest.mark.parametrize("place", [(0, 1, 0), (1, 1, 0.5), (-0.6, 1, 1.1)])
def test_a_disk_gives_an_open_floor_what_it_should(
    renderers: dict[str, Draw], name: str, place: tuple[float, float, float]
) -> None:
    """ρ/π · π L sin²r cos θ: linear in the radiance, the same from all around."""
    radius = 15.0
    light = {
        "direction": [-c for c in place],
        "radius_degrees": radius,
        "radiance": [4.0, 2.0, 1.0],
    }
    found = renderers[name]({"area_light": light, "rotation_degrees": 30.0})[FLOOR]
    cosine = place[1] / math.hypot(*place)
    expected = ALBEDO * math.sin(math.radians(radius)) ** 2 * cosine * np.array([4, 2, 1])
    np.testing.assert_allclose(found.mean(axis=(0, 1)), expected, rtol=CLOSE.get(name, 1e-3))


@every_renderer
def test_a_disk_is_seen_where_it_stands(renderers: dict[str, Draw], name: str) -> None:
    light = {"direction": [0, -0.1, 1], "radius_degrees": 8, "radiance": [3, 3, 3]}
    found = renderers[name]({"area_light": light})
    # The middle of the picture looks 11 degrees down; what stands 6 degrees up is above it.
    assert found[1:3, 5:7].max() == pytest.approx(3, rel=1e-3)
    assert found[0, 0].max() == 0


@every_renderer
def test_without_background_what_meets_nothing_is_black(
    renderers: dict[str, Draw], name: str
) -> None:
    """And the surfaces have the same light; so it is for the area light too."""
    light = {"direction": [0.3, -1, 1], "radius_degrees": 20}
    lit = {"map": "studio", "area_light": light}
    shown = renderers[name](lit)
    hidden = renderers[name]({**lit, "background": False})
    assert shown[SKY].min() > 0
    assert (hidden[SKY] == 0).all()
    np.testing.assert_array_equal(hidden[FLOOR], shown[FLOOR])
