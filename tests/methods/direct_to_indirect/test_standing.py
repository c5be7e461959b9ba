"""Light that stays: a glowing panel makes a room as bright as it is, whatever lamps lose."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from methods.fixed_view.test_gather_rays import louvred_room
from methods.scenes import POINT

from engine.measure.edges import scene_edges
from engine.methods import prepare
from engine.methods.direct_to_indirect import Settings, Transfer
from engine.reference import render
from engine.scene.edits import Edits
from engine.store import Store

SETTINGS = Settings(gather_samples=4096)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Transfer:
    store = Store(tmp_path_factory.mktemp("store"))
    return prepare(louvred_room("panel"), "direct_to_indirect", SETTINGS, store=store)  # type: ignore[return-value]


def test_a_room_under_a_glowing_panel_is_as_bright_as_it_is(room: Transfer) -> None:
    """Its 40 gather samples leave 3.5 %; the gains of lamps made it 10 % too bright."""
    scene = room.view.scene
    truth = render(scene, samples=2048)
    kept = ~scene_edges(scene)
    true = truth.image[kept].mean()
    noise = np.sqrt(truth.variance.mean(axis=2)[kept].sum()) / kept.sum() / true
    assert noise < 0.003
    assert room.relight(Edits()).image[kept].mean() == pytest.approx(true, rel=0.05)


def test_what_stays_and_what_moves_add_up(room: Transfer) -> None:
    """The panel alone, a lamp beside it, and the lamp gone again."""
    panel = room.relight(Edits()).image
    lamp = room.relight(Edits(lights=[POINT])).image - panel
    twice = room.relight(Edits(lights=[{**POINT, "intensity": [2.0, 1.6, 1.2]}])).image - panel
    assert lamp.mean() > 0.1 * panel.mean()
    np.testing.assert_allclose(twice, 2 * lamp, rtol=1e-3, atol=1e-5)
    assert room.relight(Edits()).image.tobytes() == panel.tobytes()


def test_bounces_that_miss_are_said_of_a_panel_too(tmp_path: Path) -> None:
    few = Settings(gather_samples=1024, bounces=0)
    dark = prepare(louvred_room("panel"), "direct_to_indirect", few, store=Store(tmp_path))
    found = [w for w in dark.relight(Edits()).warnings if w.code == "bounces_truncated"]
    assert len(found) == 1
    assert found[0].size > 0.2
