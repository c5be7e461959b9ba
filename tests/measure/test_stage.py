"""The stage: objects of one size above a floor of so many vertices, or alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.brdf.published import BRUSHED
from engine.errors import SceneError
from engine.measure.edges import seen_objects
from engine.measure.stage import FLOOR_SIZE, LIFT, MATERIALS, ball, knot, read_thing, stage


def test_an_object_on_a_floor() -> None:
    thing = knot(64, 8)
    scene = stage(thing, BRUSHED, (40, 30), cuts=6)
    own = scene.geometry.positions[scene.geometry.triangles[scene.geometry.object == 0]]
    low, high = own.reshape(-1, 3).min(axis=0), own.reshape(-1, 3).max(axis=0)
    assert (high - low).max() == pytest.approx(1, abs=1e-5)
    assert low[1] == pytest.approx(LIFT, abs=1e-5)
    assert (low + high)[[0, 2]] == pytest.approx([0, 0], abs=1e-5)
    floor = scene.geometry.positions[len(thing.part.positions) :]
    assert len(floor) == 7 * 7
    assert np.abs(floor[:, 1]).max() < 1e-6
    assert np.ptp(floor[:, 0]) == np.ptp(floor[:, 2]) == FLOOR_SIZE
    up = scene.geometry.normals[len(thing.part.positions) :]
    assert up == pytest.approx(np.tile([0, 1, 0], (49, 1)), abs=1e-6)
    assert scene.materials[0] == BRUSHED
    assert scene.name == "knot on a floor"
    # The picture shows both, and hardly anything beyond.
    seen = seen_objects(scene)
    assert seen.shape == (30, 40)
    assert 0.1 < (seen == 0).mean() < 0.4
    assert (seen < 0).mean() < 0.15


def test_an_object_alone() -> None:
    """The ball has no texture coordinates, which would meet at its poles."""
    scene = stage(ball(8), MATERIALS["skin"], (16, 16), cuts=None)
    assert scene.object_names == ("object",)
    assert scene.name == "ball"
    assert not scene.geometry.uvs.any()
    assert set(np.unique(seen_objects(scene))) == {-1, 0}


def test_mesh_files_become_one_smooth_object(tmp_path: Path) -> None:
    """Two groups, of which one repeats the places of the other's edge."""
    path = tmp_path / "roof.obj"
    path.write_text(
        "v 0 0 0\nv 1 1 0\nv 1 1 2\nv 0 0 2\nv 1 1 0\nv 2 0 0\nv 2 0 2\nv 1 1 2\n"
        "g left\nf 1 4 3 2\ng right\nf 5 8 7 6\n"
    )
    thing = read_thing(str(path))
    assert thing.name == "roof"
    assert len(thing.part.triangles) == 4
    ridge = np.abs(thing.part.positions[:, 0] - 1) < 1e-6
    assert thing.part.normals is not None
    assert thing.part.normals[ridge] == pytest.approx(np.tile([0, 1, 0], (ridge.sum(), 1)))


def test_what_is_no_mesh_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="not a mesh format"):
        read_thing("knot")
    with pytest.raises(SceneError, match="cannot be read"):
        read_thing(str(tmp_path / "none.obj"))
