"""Pictures of lights are remembered while they are of use, and no longer than there is room."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.light.point import PointLight
from engine.methods.fixed_view import direct
from engine.methods.fixed_view.direct import LightPictures

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


def test_lights_that_are_off_add_nothing() -> None:
    total, (a, b) = Counted(), lights(2)
    assert total((a, b.model_copy(update={"enabled": False})))[0, 0] == 1
    assert total.computed == ["0"]


@pytest.mark.parametrize("room", [1, 7])
def test_more_lights_than_there_is_room_for(room: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As many as fit are remembered, and stay: the oldest would always be the next one wanted."""
    monkeypatch.setattr(direct, "KEPT_BYTES", room * PICTURE)
    total, on = Counted(), lights(20)
    for _ in range(3):
        total.computed.clear()
        assert total(on)[0, 0] == sum(range(1, 21))
    assert len(total.computed) == 20 - room


def test_what_is_not_wanted_makes_room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(direct, "KEPT_BYTES", 3 * PICTURE)
    total, on = Counted(), lights(3)
    for x in range(10):
        total((on[0], on[1], moved(on[2], x)))
    total.computed.clear()
    total((on[0], on[1], moved(on[2], 9)))
    assert total.computed == []
