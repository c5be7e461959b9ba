"""A method's settings from text such as `coefficients=200`, with messages a person can act on."""

from __future__ import annotations

import dataclasses
import json
import typing
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from engine.errors import InputError


def settings_from(kind: type, values: Mapping[str, Any]) -> Any:
    """The frozen settings dataclass `kind` with some values in place of its defaults.

    Raises InputError for an unknown name, a value of another type, or one that `kind` refuses.
    """
    fields = {field.name: field for field in dataclasses.fields(kind)}
    hints = typing.get_type_hints(kind)
    checked = {}
    for name, value in values.items():
        if name not in fields:
            raise InputError(f"no such setting; there are {', '.join(sorted(fields))}", field=name)
        try:
            adapter = TypeAdapter(hints[name], config=ConfigDict(allow_inf_nan=False))
            checked[name] = adapter.validate_python(value)
        except ValidationError as error:
            raise InputError(f"{value!r}: {error.errors()[0]['msg']}", field=name) from None
    try:
        return kind(**checked)
    except (TypeError, ValueError) as error:
        raise InputError(str(error), field=", ".join(checked)) from None


def parse_value(text: str) -> Any:
    """A JSON value, or the text itself."""
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text


def parse_assignments(
    assignments: Iterable[str], parse: Callable[[str], Any] = parse_value
) -> dict[str, Any]:
    """{"key": value} from `key=value` texts."""
    values: dict[str, Any] = {}
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        if not equals or not name:
            raise InputError(f"{assignment!r} is not of the form key=value")
        if name in values:
            raise InputError("given twice", field=name)
        values[name] = parse(text)
    return values
