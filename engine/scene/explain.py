"""Turn a validation error into one field and one sentence that a person can act on."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from typing import Any

from pydantic import ValidationError

Path = tuple[str | int, ...]


def explain(error: ValidationError, document: Any, schema: dict[str, Any]) -> tuple[str, str]:
    """(dotted path, sentence) of the first problem of `document`, which `schema` describes."""
    found = [(_path(problem, document), problem) for problem in error.errors()]
    # Where several forms are allowed, the one that got furthest is the one that was meant.
    path, problem = found[0]
    for other, candidate in found[1:]:
        if other[: len(path)] == path and _reach(other, candidate) > _reach(path, problem):
            path, problem = other, candidate
    sentence = _sentence(path, problem, document, schema)
    if problem["type"] == "missing" and isinstance(path[-1], int):
        path = path[:-1]  # the list is there to be pointed at, its entry is not
    if problem["type"].startswith("union_tag"):
        path = (*path, problem["ctx"]["discriminator"].strip("'"))
    return ".".join(map(str, path)), sentence


def closest(word: str, words: Iterable[str]) -> str:
    """Which of the words was meant, as the end of a sentence."""
    words = sorted(words)
    near = difflib.get_close_matches(word, words, n=2, cutoff=0.6)
    if near:
        return f"did you mean {' or '.join(near)}?"
    if len(words) > 12:
        words = [*words[:12], "..."]
    return f"known: {', '.join(words)}" if words else "there are none"


def _reach(path: Path, problem: Any) -> tuple[int, bool]:
    """How far a form fitted: how deep, and whether it was at least of the right kind there."""
    return len(path), not problem["type"].endswith("_type")


def _path(problem: Any, document: Any) -> Path:
    """The location without the names of alternatives, which are no part of the document."""
    location: Path = problem["loc"]
    if document is None:
        return tuple(part for part in location if str(part).islower() or isinstance(part, int))
    path: list[str | int] = []
    value, chosen = document, False
    for k, part in enumerate(location):
        # An alternative chosen by `type` or `shape` stands first among its own keys, and may be
        # called like one of them.
        if (
            isinstance(value, dict)
            and not chosen
            and part in (value.get("type"), value.get("shape"))
        ):
            chosen = True
            continue
        entry = isinstance(value, dict) and part in value
        item = isinstance(value, list | tuple) and isinstance(part, int) and part < len(value)
        absent = k == len(location) - 1 and problem["type"] == "missing"
        if entry or item:
            value, chosen = value[part], False
        elif not absent:
            continue
        path.append(part)
    return tuple(path)


def _sentence(path: Path, problem: Any, document: Any, schema: dict[str, Any]) -> str:
    kind, context = problem["type"], problem.get("ctx", {})
    value = _at(path, document)
    if kind == "extra_forbidden":
        return f"unknown key; {closest(str(path[-1]), _keys(path[:-1], document, schema))}"
    if kind == "missing":
        if isinstance(path[-1], int):
            return f"{len(_at(path[:-1], document))} entries are too few"
        return "this key is missing and has no default"
    if kind == "union_tag_invalid":
        tag = context["discriminator"].strip("'")
        allowed = [word.strip(" '") for word in context["expected_tags"].split(",")]
        return f"unknown {tag} {context['tag']!r}; {closest(context['tag'], allowed)}"
    if kind == "union_tag_not_found":
        tag = context["discriminator"].strip("'")
        fields = [option.get("properties", {}) for option in _schemas(path, document, schema)]
        names = sorted({str(field[tag]["const"]) for field in fields if tag in field})
        return f"the key {tag} is missing; it is one of {', '.join(names)}"
    if kind == "value_error":
        return str(problem["msg"]).removeprefix("Value error, ")
    if kind in ("too_long", "too_short"):
        return f"{context['actual_length']} entries where {_wanted(context)} are allowed"
    if kind == "finite_number":
        return f"{value} is not a finite number"
    shown = repr(value)
    wanted = _WANTED.get(kind) or str(problem["msg"]).replace("Input should", "must")
    return f"{wanted}, not {shown if len(shown) <= 60 else shown[:57] + '...'}"


_WANTED = {
    "tuple_type": "must be a list",
    "list_type": "must be a list",
    "dict_type": "must be an object with keys",
    "model_type": "must be an object with keys",
    "model_attributes_type": "must be an object with keys",
    "bool_parsing": "must be true or false",
    "bool_type": "must be true or false",
    "float_parsing": "must be a number",
    "float_type": "must be a number",
    "int_parsing": "must be a whole number",
    "int_from_float": "must be a whole number",
    "int_type": "must be a whole number",
    "string_type": "must be a text",
}


def _wanted(context: dict[str, Any]) -> str:
    if "max_length" in context:
        return f"at most {context['max_length']}"
    return f"at least {context['min_length']}"


def _at(path: Path, document: Any) -> Any:
    for part in path:
        try:
            document = document[part]
        except (KeyError, IndexError, TypeError):
            return None
    return document


def _keys(path: Path, document: Any, schema: dict[str, Any]) -> set[str]:
    """The keys that the schema allows at a place of the document."""
    return {
        key for found in _schemas(path, document, schema) for key in found.get("properties", {})
    }


def _schemas(path: Path, document: Any, schema: dict[str, Any]) -> list[dict[str, Any]]:
    """The schemas that may hold at a place of the document."""
    found = list(_options([schema], schema))
    for k, part in enumerate(path):
        steps = []
        for option in _meant(found, _at(path[:k], document)):
            if isinstance(part, int):
                prefix = option.get("prefixItems", [])
                steps.append(prefix[part] if part < len(prefix) else option.get("items", {}))
            else:
                steps.append(
                    option.get("properties", {}).get(part, option.get("additionalProperties", {}))
                )
        found = list(_options([step for step in steps if isinstance(step, dict)], schema))
    return _meant(found, _at(path, document))


def _options(schemas: Iterable[dict[str, Any]], root: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The schemas with references followed and alternatives opened."""
    for schema in schemas:
        if "$ref" in schema:
            yield from _options([root["$defs"][schema["$ref"].rsplit("/", 1)[1]]], root)
        elif "anyOf" in schema or "oneOf" in schema:
            yield from _options(schema.get("anyOf", schema.get("oneOf", [])), root)
        else:
            yield schema


def _meant(options: list[dict[str, Any]], value: Any) -> list[dict[str, Any]]:
    """The alternatives whose fixed values (a `type`, a `shape`) are those of the document."""
    if not isinstance(value, dict):
        return options
    return [
        option
        for option in options
        if all(
            value.get(key, field["const"]) == field["const"]
            for key, field in option.get("properties", {}).items()
            if "const" in field
        )
    ]
