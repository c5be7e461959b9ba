"""Lights within millimetres of a wall, and lights that go through one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from methods.scenes import POINT, camera, rectangle, scene, white_room

from engine.methods.base import Frame
from engine.methods.direct_to_indirect import Transfer
from engine.scene.edits import Edits

SIZE = 24
CODE = "light_between_samples"


def moved(*position: float) -> Edits:
    return Edits(lights=[{"id": "point", "position": list(position)}])


def said(frame: Frame) -> float:
    """Size of what the frame says of lights that the cloud misses; 0 where it says nothing."""
    return next((w.size for w in frame.warnings if w.code == CODE), 0.0)


def test_ordinary_lights_are_not_talked_about(make: Callable[..., Transfer]) -> None:
    """In the open, wide or narrow, in a ball or outside of the room: no false alarm."""
    room = white_room(0.5, [POINT], SIZE)
    product = make(room, gather_samples=4096)
    rng = np.random.default_rng(7)
    for k in range(20):
        spot = {
            "id": "point",
            "type": "spot",
            "position": rng.uniform(-0.7, 0.7, 3).tolist(),
            "target": rng.uniform(-1, 1, 3).tolist(),
            "cone_degrees": float(rng.uniform(8, 60)),
        }
        for edit in (moved(*rng.uniform(-0.8, 0.8, 3)), Edits(lights=[spot])):
            assert said(product.relight(edit)) == 0, (k, edit)
    for position in ((0, 3, 0), (0, 1.001, 0), (-5, 0.2, 0.1)):
        frame = product.relight(moved(*position))
        assert not frame.image.any()
        assert said(frame) == 0


def test_a_light_crossing_a_thin_wall(make: Callable[..., Transfer]) -> None:
    """Through a wall without thickness in steps of a millimetre: on the far side it is dark.

    On the near side the room keeps its light up to the last millimetre but for what is missed and
    said; what comes through is what culled wavelets mix of the wall's two sides.
    """
    two = scene(
        camera=camera(SIZE, position=[-1.9, 0.1, 0.05], target=[0, 0, 0]),
        lights=[{**POINT, "position": [-1, 0.3, 0]}],
        objects=[
            {"name": "rooms", "mesh": {"shape": "box", "size": [4, 2, 2]}},
            rectangle("wall", [2, 2], [0, 0, 0], [0, 90, 0]),
        ],
    )
    product = make(two, gather_samples=4096)
    whole = float(product.relight(Edits()).image.mean())
    means = {}
    for x in np.linspace(-0.005, 0.005, 11):
        frame = product.relight(moved(float(x), 0.3, 0.0))
        assert np.isfinite(frame.image).all()
        assert frame.image.min() >= 0
        means[round(1000 * float(x))] = float(frame.image.mean()) / whole
        if -0.005 < x < -1e-4:
            assert said(frame) > 0.1
    near = [share for mm, share in means.items() if mm < 0]
    far = [share for mm, share in means.items() if mm > 0]
    # From 86 to 66 % of what there is in the middle of the room, as less and less falls on samples.
    assert min(near) > 0.6, means
    assert max(near) < 1, means
    # 0.95 %, and the same wherever beyond the wall the light is: the wall's own two sides.
    assert max(far) < 0.012, means
    # In the plane of the wall itself the light is on one side of it or on the other.
    assert means[0] < 1, means
