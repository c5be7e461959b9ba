"""The GPU draws what the CPU draws, of codes of every symmetry and at every level."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any

import numpy as np
import pytest
from methods.wavelet_brdf.measured_scenes import GENERAL, measured, off, table, with_general
from numpy.typing import NDArray

from engine.backend.gl.context import device
from engine.errors import BackendError
from engine.methods.fixed_view.gl_view import GlView
from engine.methods.wavelet_brdf import Wavelets
from engine.scene.edits import Edits
from engine.scene.scene import Scene

pytestmark = [pytest.mark.gl, pytest.mark.usefixtures("small_codes")]
Make = Callable[..., Wavelets]
PARTS = {"codes", "view", "light", "total"}
SAME = 1e-3  # relative L2 of a whole frame
MEDIAN = 1e-6  # of a pixel's difference, as a part of the mean
SPOT = {
    "id": "spot", "type": "spot", "position": [-1, 1, 1], "target": [0, -0.4, 0],
    "cone_degrees": 20, "intensity": [2, 4, 6],
}  # fmt: skip
AREA = {
    "id": "area", "type": "area", "position": [0, 1.5, 0], "target": [0, -1, 0], "up": [0, 0, 1],
    "width": 0.6, "height": 0.4, "intensity": [9, 9, 9],
}  # fmt: skip


def shown(file: str, **more: Any) -> Scene:
    """A ball and a floor of it, in three lights."""
    made = table(measured(file), measured(file, specular=[0.5, 0.7, 0.9]), size=45, **more)
    return with_general(made) if file == GENERAL else made


def same(product: Wavelets, edits: Edits = Edits(), scale: int = 1) -> NDArray[np.float32]:  # noqa: B008
    """Both backends draw the same picture, which this returns, and say the same of it."""
    theirs, ours = (product.relight(edits, scale, backend) for backend in ("cpu", "gl"))
    device().check()
    assert ours.warnings == theirs.warnings
    assert set(ours.timings) == set(theirs.timings) == PARTS
    assert np.isfinite(ours.image).all()
    assert theirs.image.max() > 0
    assert off(ours.image, theirs.image) < SAME
    apart = np.abs(ours.image - theirs.image).max(axis=2)
    assert np.median(apart) < MEDIAN * theirs.image.mean()
    return ours.image


@pytest.mark.parametrize("scale", [1, 2])
@pytest.mark.parametrize("file", ["plastic", "brushed", "threads", GENERAL])
def test_codes_of_every_symmetry(make: Make, file: str, scale: int) -> None:
    product = make(shown(file), detail="distance", alpha=6)
    lamp = same(product, scale=scale)
    moved = Edits(camera={"position": [-0.9, 0.8, 2.0]}, lights=[SPOT])
    assert off(same(product, moved, scale), lamp) > 0.1


@pytest.mark.parametrize("fields", [{"detail": "footprint"}, {"shadows": False}], ids=list)
def test_settings_that_change_the_picture(make: Make, fields: dict[str, Any]) -> None:
    plain, other = (make(shown("plastic"), cells=32, **more) for more in ({}, fields))
    assert off(same(other), same(plain)) > 0.01


def test_lamps_with_extent(make: Make) -> None:
    same(make(shown("brushed", lights=[AREA])))


def test_materials_that_come_later(make: Make) -> None:
    """The GPU holds the codes that were there when it was first asked, and gets the others."""
    product = make(shown("plastic"))
    first = same(product)
    for edits in (
        Edits(materials={"floor": {"file": "threads"}}),
        Edits(materials={"floor": {"type": "phong", "exponent": 9}}),
        Edits(materials={"ball": {"type": "ggx"}, "floor": {"type": "diffuse"}}),
    ):
        assert off(same(product, edits), first) > 0.01
    assert same(product).tobytes() == first.tobytes()


def test_levels_in_colours_need_no_gpu(make: Make) -> None:
    product = make(shown("plastic"), detail="footprint", show="levels")
    pictures = [product.relight(Edits(), 1, backend).image for backend in ("cpu", "gl")]
    assert pictures[0].tobytes() == pictures[1].tobytes()


def test_gl_that_fails_is_replaced_by_the_cpu(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the frame on in which it fails, with a plain notice."""
    product = copy(make(shown("plastic")))
    expected = product.relight(Edits(), 1, "cpu").image

    def fail(*_: Any) -> None:
        raise BackendError("the GPU has fallen off")

    with monkeypatch.context() as patch:
        patch.setattr(GlView, "direct", fail)
        frame = product.relight(Edits(), 1, "gl")
    again = product.relight(Edits(), 1, "gl")
    for each in (frame, again):
        assert each.image.tobytes() == expected.tobytes()
        assert each.warnings[0].code == "gl_unavailable"
        assert "has fallen off" in each.warnings[0].message
