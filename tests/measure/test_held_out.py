"""Which edits methods are judged on, and under which light."""

from __future__ import annotations

import numpy as np
import pytest

from engine.errors import InputError
from engine.measure.held_out import HELD_OUT, drag_path, judged_on, kind_of_edits, methods_for
from engine.methods import METHODS
from engine.scene.edits import Edits
from engine.scene.open import open_scene


def test_every_kind_of_edit_can_be_drawn() -> None:
    assert set(HELD_OUT) == {kind for method in METHODS.values() for kind in method.edits}


@pytest.mark.parametrize(
    ("methods", "kind"),
    [
        (["direct_to_indirect"], "lights"),
        (["glossy_prt"], "environment"),
        (["brdf_editing"], "materials"),
        (["wavelet_brdf"], "lights"),
        (["direct_to_indirect", "brdf_editing"], "lights"),
        (["direct_to_indirect", "glossy_prt"], "environment"),
        (["brdf_editing", "wavelet_brdf"], "lights"),
    ],
)
def test_methods_are_judged_on_what_all_of_them_take(methods: list[str], kind: str) -> None:
    assert kind_of_edits(methods) == kind


def test_a_kind_can_be_asked_for() -> None:
    assert kind_of_edits(["brdf_editing"], "lights") == "lights"
    assert methods_for("lights") == ["direct_to_indirect", "brdf_editing", "wavelet_brdf"]
    with pytest.raises(InputError, match="glossy_prt takes no edits of lights"):
        kind_of_edits(["direct_to_indirect", "glossy_prt"], "lights")
    with pytest.raises(InputError, match="'weather' cannot be drawn"):
        kind_of_edits(["glossy_prt"], "weather")
    with pytest.raises(InputError, match="no method takes edits of 'weather'"):
        methods_for("weather")
    with pytest.raises(InputError, match="chart them one by one"):
        kind_of_edits(["glossy_prt", "brdf_editing"])


def test_only_light_that_all_carry_shines() -> None:
    scene = open_scene("knot")
    assert scene.lights
    assert scene.environment is not None
    turned, edits = judged_on(scene, ["glossy_prt"], 2, 1)
    assert not turned.lights
    assert all(edit.environment for edit in edits)
    assert turned.rays is scene.rays
    lit, edits = judged_on(scene, ["wavelet_brdf"], 2, 1)
    assert lit.environment is None
    assert lit.lights == scene.lights
    assert all(edit.lights for edit in edits)
    _, edits = judged_on(scene, ["wavelet_brdf"], 2, 1, "camera")
    assert all(edit.camera for edit in edits)
    with pytest.raises(InputError, match="no light in common"):
        judged_on(scene, ["wavelet_brdf", "glossy_prt"], 2, 1, "camera")


def test_a_drag_goes_on_from_the_edit() -> None:
    scene = open_scene("cornell-box")
    edit = Edits(lights=[{"id": "key", "position": (0.1, 0.2, 0.3)}])
    path = drag_path(scene, edit)
    places = np.array([step.lights[0]["position"] for step in path if step.lights])
    assert path[0] == edit
    assert len(places) == 4
    steps = np.diff(places, axis=0)
    np.testing.assert_allclose(steps, [[0.01 * scene.diagonal, 0, 0]] * 3, atol=1e-12)
