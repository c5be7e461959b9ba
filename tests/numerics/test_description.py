"""Field types: finite, bounded, and strict about what they do not know."""

from __future__ import annotations

import math

import pytest
from pydantic import ValidationError

from engine.numerics.description import Description, Finite, Point, Radiance, Reflectance


class _Thing(Description):
    at: Point = (0, 0, 0)
    angle: Finite = 0
    colour: Reflectance = (0, 0, 0)
    light: Radiance = (0, 0, 0)


@pytest.mark.parametrize(
    ("fields", "where"),
    [
        ({"at": (0, 0)}, "at.2"),
        ({"at": (0, 0, 0, 0)}, "at"),
        ({"at": (0, math.inf, 0)}, "at.1"),
        ({"at": (0, 2e9, 0)}, "at.1"),
        ({"angle": math.nan}, "angle"),
        ({"angle": "steep"}, "angle"),
        ({"colour": (0, 0, 1.01)}, "colour.2"),
        ({"colour": (-0.01, 0, 0)}, "colour.0"),
        ({"light": (0, -1, 0)}, "light.1"),
        ({"color": (0, 0, 0)}, "color"),
    ],
)
def test_bad_field_is_named(fields: dict[str, object], where: str) -> None:
    with pytest.raises(ValidationError) as error:
        _Thing(**fields)  # type: ignore[arg-type]
    assert ".".join(str(part) for part in error.value.errors()[0]["loc"]) == where


def test_good_fields_are_taken_and_frozen() -> None:
    thing = _Thing(at=(1, 2, 3), colour=(0, 0.5, 1), light=(0, 1e12, 5))
    assert thing.at == (1, 2, 3)
    with pytest.raises(ValidationError):
        thing.angle = 3  # type: ignore[misc]
