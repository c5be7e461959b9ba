"""Settings from text: what fits is taken, what does not is named."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from engine.errors import InputError
from engine.measure.settings import parse_assignments, settings_from


@dataclass(frozen=True)
class Settings:
    coefficients: int = 100
    cull: bool = True
    threshold: float = 0.5
    shadows: str = "rays"
    budget: float | None = None

    def __post_init__(self) -> None:
        if self.coefficients < 1:
            raise ValueError(f"coefficients {self.coefficients} is below 1")


def parsed(*assignments: str) -> Settings:
    settings: Settings = settings_from(Settings, parse_assignments(assignments))
    return settings


def test_values_take_the_type_of_their_field() -> None:
    assert parsed() == Settings()
    assert parsed("coefficients=25", "cull=false", "threshold=1e-3", "shadows=map") == Settings(
        25, False, 0.001, "map"
    )
    assert parsed("budget=null").budget is None
    assert parsed("budget=3").budget == 3.0
    assert parsed("shadows=").shadows == ""


@pytest.mark.parametrize(
    ("assignments", "message"),
    [
        (["coefficient=3"], "coefficient: no such setting; there are .*coefficients"),
        (["coefficients=many"], "coefficients: 'many'.*integer"),
        (["coefficients=2.5"], "coefficients: 2.5"),
        (["coefficients=0"], "coefficients: coefficients 0 is below 1"),
        (["cull=maybe"], "cull"),
        (["threshold=NaN"], "threshold.*finite"),
        (["threshold=Infinity"], "threshold.*finite"),
        (["coefficients"], "not of the form key=value"),
        (["=3"], "not of the form key=value"),
        (["cull=true", "cull=false"], "cull: given twice"),
    ],
)
def test_what_does_not_fit_is_named(assignments: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        parsed(*assignments)


def test_values_are_json_or_text() -> None:
    values: dict[str, Any] = parse_assignments(["a=1", "b=x=y", "c=[1,2]", "d=true"])
    assert values == {"a": 1, "b": "x=y", "c": [1, 2], "d": True}
    assert parse_assignments(["a=1,2"], parse=str) == {"a": "1,2"}
