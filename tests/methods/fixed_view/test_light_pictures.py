"""Pictures of lights are remembered while they are of use, and no longer than there is room."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.light.point import PointLight
from engine.methods.fixed_view import light_pictures
from engine.methods.fixed_view.light_pictures import LightPictures

PIXELS = 100
PICTURE = PIXELS * 3 * 4  # bytes


def lights(count: int) -> tuple[PointLight, ...]:
    return tuple(
        PointLight(id=str(k), position=(k, 0, 0), intensity=(1, 1, 1)) for k in range(count)
    )


class Counted:
    """Pictures of lights, and how often each was computed."""

    def __init__(self) -> None:
        self.pictures = LightPictures()
        self.computed: list[str] = []

    def __call__(self, on: tuple[PointLight, ...], what: int = 1) -> NDArray[np.float32]:
        def compute(light: PointLight) -> NDArray[np.float32]:
            self.computed.append(light.id)
            return np.full((PIXELS, 3), light.position[0] + 1, np.float32)

        return self.pictures.total(what, on, compute, PIXELS)


def moved(light: PointLight, x: float) -> PointLight:
    return light.model_copy(update={"position": (x, 1.0, 0.0)})


def test_only_the_light_that_moved_is_computed_again() -> None:
    total, on = Counted(), lights(5)
    assert total(on)[0, 0] == 1 + 2 + 3 + 4 + 5
    for x in range(30):
        total.computed.clear()
        assert total((*on[:4], moved(on[4], x)))[0, 0] == 1 + 2 + 3 + 4 + x + 1
        assert total.computed == ["4"]
    total.computed.clear()
    total(on, what=2)
    assert total.computed == list("01234")


def test_a_drag_leaves_little_behind_and_lights_that_are_off_are_remembered() -> None:
    total, on = Counted(), lights(9)
    total(on)
    for x in range(30):
        total((moved(on[0], x),))
    assert total.pictures._bytes == PICTURE * (9 + light_pictures.KEPT_BEFORE)
    total.computed.clear()
    total((moved(on[0], 28), *on[1:]))
    assert total.computed == []


def test_lights_that_are_off_add_nothing() -> None:
    total, (a, b) = Counted(), lights(2)
    assert total((a, b.model_copy(update={"enabled": False})))[0, 0] == 1
    assert total.computed == ["0"]


@pytest.mark.parametrize("room", [1, 7])
def test_more_lights_than_there_is_room_for(room: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their sum is remembered: a light that moves costs itself, and where it was at most."""
    monkeypatch.setattr(light_pictures, "KEPT_BYTES", room * PICTURE)
    total, on = Counted(), lights(20)
    for _ in range(3):
        assert total(on)[0, 0] == sum(range(1, 21))
    assert len(total.computed) == 20
    for x in range(30):
        total.computed.clear()
        assert total((*on[:4], moved(on[4], x), *on[5:]))[0, 0] == sum(range(1, 21)) - 5 + x + 1
        assert total.computed in (["4"], ["4", "4"])
    # Another kind of picture has a sum of its own, and few lights need none.
    assert total(on, what=2)[0, 0] == sum(range(1, 21))
    assert total(on[: room + 1])[0, 0] == sum(range(1, room + 2))
    assert total(on)[0, 0] == sum(range(1, 21))


def test_a_light_taken_from_a_sum_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever came and went, the sum is what it would be afresh, to the last bit."""
    monkeypatch.setattr(light_pictures, "KEPT_BYTES", PICTURE)
    monkeypatch.setattr(light_pictures, "FEW", 4)
    rng = np.random.default_rng(1)

    def compute(light: PointLight) -> NDArray[np.float32]:
        seed = int(1000 * light.position[0]) + 1
        picture = np.random.default_rng(seed).lognormal(0, 4, (PIXELS, 3))
        return picture.astype(np.float32)

    pictures, on = LightPictures(), list(lights(8))
    before = pictures.total(1, tuple(on), compute, PIXELS)
    for x in rng.uniform(10, 20, 50):
        pictures.total(1, (*on[:3], moved(on[3], x), *on[4:]), compute, PIXELS)
    after = pictures.total(1, tuple(on), compute, PIXELS)
    np.testing.assert_array_equal(after, before)
    np.testing.assert_allclose(before, sum(compute(light) for light in on), rtol=1e-6)


def test_what_is_not_wanted_makes_room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(light_pictures, "KEPT_BYTES", 3 * PICTURE)
    total, on = Counted(), lights(3)
    for x in range(10):
        total((on[0], on[1], moved(on[2], x)))
    total.computed.clear()
    total((on[0], on[1], moved(on[2], 9)))
    assert total.computed == []
