"""Newell's teapot: whole, smooth, faced outwards, and his."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from engine.scene import shapes
from engine.scene.part import Part
from engine.scene.rays import RayTracer
from engine.scene.teapot import PartName, Teapot, control_points

PARTS: tuple[PartName, ...] = Teapot(shape="teapot").parts


def make(segments: int = 8, *parts: PartName) -> Part:
    return shapes.make(Teapot(shape="teapot", segments=segments, parts=parts or PARTS))


def welded(part: Part) -> np.ndarray:
    """Triangles (t, 3) over the distinct positions: equal to the last digit, or not the same."""
    _, which = np.unique(part.positions + 0.0, axis=0, return_inverse=True)
    return which.reshape(-1)[part.triangles]


def area(part: Part) -> float:
    c = part.positions[part.triangles]
    return float(np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1).sum() / 2)


def test_has_the_size_of_the_classic_one() -> None:
    positions = make(segments=64).positions
    assert positions.min(axis=0) == pytest.approx([-3, 0, -2], abs=1e-12)
    assert positions.max(axis=0) == pytest.approx([3.4341, 3.15, 2], abs=1e-4)


def test_has_as_many_patches_as_his_and_a_bottom() -> None:
    nets = [control_points(part) for part in PARTS]
    patches = [(len(net) // 3) * (net.shape[1] // 3) for net in nets]
    assert sum(patches) == 28 + 4
    assert [len(make(2, part).triangles) for part in PARTS[1:4]] == [
        8 * count for count in patches[1:4]
    ]


@pytest.mark.parametrize("segments", [2, 3, 8])
def test_patches_meet_to_the_last_digit(segments: int) -> None:
    part = make(segments)
    triangles = welded(part)
    sides = Counter((int(t[k]), int(t[(k + 1) % 3])) for t in triangles for k in range(3))
    assert max(sides.values()) == 1
    open_ = [(a, b) for a, b in sides if (b, a) not in sides]
    # Open are the pot and its lid, and handle and spout at both ends.
    after = dict(open_)
    assert len(after) == len(open_)
    loops = []
    while after:
        loop = [next(iter(after))]
        while loop[-1] in after:
            loop.append(after.pop(loop[-1]))
        assert loop[0] == loop[-1]
        loops.append(len(loop) - 1)
    assert sorted(loops) == [2 * segments] * 4 + [4 * segments] * 2


@pytest.mark.parametrize(("below", "above"), [("bottom", "body"), ("body", "rim"), ("lid", "knob")])
def test_is_smooth_where_parts_meet(below: PartName, above: PartName) -> None:
    count = 4 * 8 + 1
    low, high = make(8, below), make(8, above)
    assert low.normals is not None
    assert high.normals is not None
    np.testing.assert_allclose(low.normals[-count:], high.normals[:count], atol=1e-12)
    # And round the seam of the texture.
    np.testing.assert_allclose(low.normals[::count], low.normals[count - 1 :: count], atol=1e-12)


def test_is_level_at_its_poles() -> None:
    bottom, knob = make(8, "bottom"), make(8, "knob")
    assert bottom.normals is not None
    assert knob.normals is not None
    np.testing.assert_allclose(bottom.normals[:33], np.tile([0.0, -1, 0], (33, 1)), atol=1e-12)
    np.testing.assert_allclose(knob.normals[-33:], np.tile([0.0, 1, 0], (33, 1)), atol=1e-12)


def test_area_converges_as_the_square_of_the_step() -> None:
    areas = np.array([area(make(segments)) for segments in (8, 16, 32, 64)])
    steps = np.diff(areas)
    assert steps[:-1] / steps[1:] == pytest.approx([4, 4], rel=0.08)
    assert areas[-1] == pytest.approx(52.88, abs=0.01)


def test_faces_whoever_looks_from_outside() -> None:
    part = make(segments=16)
    rays = RayTracer(part.positions.astype(np.float32), part.triangles.astype(np.int32))
    rng = np.random.default_rng(1)
    eye = rng.normal(size=(20_000, 3))
    eye *= 10 / np.linalg.norm(eye, axis=1, keepdims=True)
    ahead = rng.uniform([-3, 0, -2], [3.4, 3.1, 2], size=eye.shape) - eye
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    hit = rays.intersect(eye.astype(np.float32), ahead.astype(np.float32))
    met = hit.triangle >= 0
    assert met.mean() > 0.3
    c = part.positions[part.triangles[hit.triangle[met]]]
    across = np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0])
    back = np.sum(across * ahead[met], axis=1) > 0
    assert back.mean() < 0.02
    # What shows its back is seen through the rim or through the tip of the spout.
    behind = (eye + hit.distance[:, None] * ahead)[met][back]
    within = np.hypot(behind[:, 0], behind[:, 2]) < 2.01
    assert (within | (behind[:, 0] > 1.7)).all()


def test_parts_make_the_whole() -> None:
    assert sum(area(make(6, part)) for part in PARTS) == pytest.approx(area(make(6)), rel=1e-12)
    assert len(make(6, "knob", "handle").triangles) < len(make(6).triangles) / 3


@pytest.mark.data
def test_is_the_teapot_that_others_know(shared_data: Path) -> None:
    lines = (shared_data / "meshes" / "teapot.obj").read_text().splitlines()
    theirs = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], float)
    ours = make(segments=10).positions  # it is cut into as many, and rounded to six decimals
    assert len(theirs) == 3644
    assert cKDTree(ours).query(theirs)[0].max() < 2e-6
