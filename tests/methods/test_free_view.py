"""What the rasteriser finds is what rays through the same points find."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from methods.scenes import camera, rectangle, scene, small_knot, with_camera

from engine.methods import free_view as view
from engine.methods.free_view import Seen
from engine.scene.scene import Scene


def both(of: Scene, step: int) -> tuple[Seen, Seen]:
    """(by the rasteriser, by rays) through all pixels' centres."""
    shape = of.camera.shape(step)
    drawn = view._rasterise(of, of.camera, step, shape)
    assert drawn is not None
    return drawn, view._cast(of, of.camera, *view._grid(shape, step))


def assert_same(of: Scene, step: int = 1) -> None:
    drawn, cast = both(of, step)
    same = drawn.triangle == cast.triangle
    assert same.mean() > 1 - 1e-4
    hit = same & (cast.triangle >= 0)
    assert hit.any()
    np.testing.assert_allclose(drawn.away, cast.away, atol=1e-6)
    np.testing.assert_array_equal(drawn.front[hit], cast.front[hit])
    np.testing.assert_allclose(drawn.distance[hit], cast.distance[hit], rtol=1e-5)
    assert np.isinf(drawn.distance[drawn.triangle < 0]).all()
    # In metres, as barycentrics of slivers are worth nothing; at grazing angles it is the more.
    corners = of.geometry.positions[of.geometry.triangles[drawn.triangle[hit]]]
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    off = (drawn.b1 - cast.b1)[hit, None] * e1 + (drawn.b2 - cast.b2)[hit, None] * e2
    assert np.linalg.norm(off, axis=1).max() < 1e-5 * of.diagonal


@pytest.fixture(scope="module")
def tied() -> Scene:
    return small_knot()


@pytest.mark.parametrize("step", [1, 2])
@pytest.mark.parametrize("position", [[0.5, 0.6, 0.9], [-0.8, 0.2, 0.3], [0.1, 1.6, 0.1]])
def test_the_knot(tied, position, step):
    assert_same(with_camera(tied, position=position, width=192, height=160), step)


def test_refuses_what_is_too_near(tied):
    """A camera that all but touches the floor."""
    low = with_camera(tied, position=[0.5, 1e-3, 0.5], target=[0, 0, 0])
    assert view._rasterise(low, low.camera, 1, low.camera.shape(1)) is None


def test_two_large_triangles_that_go_far_beyond_the_picture():
    """Seen at a low angle, from the front and from the back, and turned inside out."""
    wall = scene(
        camera=camera(96, position=[0.3, -0.2, 0.15], target=[0.1, 0.4, 0]),
        materials={"grey": {"type": "diffuse", "diffuse": [0.5] * 3}},
        objects=[{**rectangle("wall", [20, 20], [0, 0, 0]), "material": "grey"}],
    )
    behind = with_camera(wall, position=[0.3, -0.2, -0.15])
    for of, front in ((wall, True), (behind, False)):
        assert_same(of)
        drawn, _ = both(of, 1)
        assert (drawn.front[drawn.triangle >= 0] == front).all()
    turned = replace(
        wall, geometry=wall.geometry._replace(triangles=wall.geometry.triangles[:, ::-1].copy())
    )
    assert not both(turned, 1)[0].front.any()
