"""What the settings of all methods have in common."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import pytest

from engine.errors import InputError
from engine.methods import METHODS
from engine.methods.brdf_editing import Settings


@pytest.mark.parametrize("name", METHODS)
def test_numbers_take_the_types_of_their_fields(name: str) -> None:
    """A kernel would be compiled again for another, and a product be made again."""
    kind: Any = METHODS[name].settings
    usual = kind()
    numbers = {f.name: getattr(usual, f.name) for f in fields(kind) if f.type in ("int", "float")}
    whole = {key: value for key, value in numbers.items() if value == int(value)}
    other = kind(**{k: int(v) if isinstance(v, float) else float(v) for k, v in whole.items()})
    assert repr(other) == repr(usual)


def test_a_part_of_a_whole_number_is_refused() -> None:
    with pytest.raises(InputError, match=r"lobe_exponent: 200\.5 is no whole number"):
        Settings(lobe_exponent=200.5)  # type: ignore[arg-type]
