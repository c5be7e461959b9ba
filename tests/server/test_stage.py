"""Names of scenes in URLs, and what is kept."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.errors import EditError, NotFound
from engine.scene.edits import Edits
from server.stages import slug, stages, unique


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("/x/Living Room.OBJ", "living-room"),
        ("/x/living_room.obj", "living-room"),
        ("/x/kitchen/scene.json", "kitchen"),
        ("/x/...", "scene"),
        ("/x/Büro 2.glb", "b-ro-2"),
    ],
)
def test_slugs(path: str, name: str) -> None:
    assert slug(Path(path)) == name


def test_names_are_unique(tmp_path: Path) -> None:
    assert unique("a", {"a", "a-2"}) == "a-3"
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "cornell box.obj").touch()
    files = [str(tmp_path / folder / "cornell box.obj") for folder in ("one", "two")]
    names = list(stages(files).stages)
    assert names[:2] == ["cornell-box-2", "cornell-box-3"]
    assert "cornell-box" in names


def test_unknown_scenes_are_refused_at_once() -> None:
    with pytest.raises(NotFound, match="no-such-scene"):
        stages(["no-such-scene"])
    with pytest.raises(NotFound, match="cornell-box"):
        stages([]).get("no-such-scene")


def test_a_moving_camera_pays_for_small_buffers_only(tiny_scene: Path) -> None:
    stage = stages([str(tiny_scene)]).default
    camera = stage.camera(Edits(camera={"position": [0.3, 0.3, -0.9]}))
    coarse = stage.view(camera, 2)
    frame = coarse.relight(Edits())
    assert frame.image.shape == (9, 12, 3)
    assert (coarse.scale, coarse.method) == (1, "direct")
    full = stage.view(camera, 1)
    assert full.relight(Edits()).image.shape == (18, 24, 3)
    # Once the full buffer is there it serves both.
    assert stage.view(camera, 2).renderer is full.renderer


def test_a_picture_that_is_too_large_for_a_service(tiny_scene: Path) -> None:
    """A thousand bytes of a request must not take gigabytes."""
    stage = stages([str(tiny_scene)]).default
    assert stage.camera(Edits(camera={"width": 3840, "height": 2160})).width == 3840
    with pytest.raises(EditError, match=r"the 8 million that the service draws") as caught:
        stage.camera(Edits(camera={"width": 4096, "height": 4096}))
    assert caught.value.field == "camera"
