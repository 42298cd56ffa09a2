"""What is wrong with a document of the current version, in words of ours: one error for each problem, with its key."""

from collections.abc import Iterator
from math import isfinite
from re import search
from typing import Any

from plant.errors import InputError, UnknownNameError
from plant.texts import check_name, check_texts
from tuner.gains.schema import gains_schema, validator
from tuner.gains.shapes import DIGEST, Row
from tuner.text.toml_text import shown

TYPES = {
    "object": "an object", "array": "a list", "string": "a text", "number": "a finite number", "integer": "a whole number",
    "boolean": "true or false", "null": "null",
}  # fmt: skip
BOUNDS = {
    "minimum": "at least", "exclusiveMinimum": "above", "maximum": "at most", "exclusiveMaximum": "below",
}  # fmt: skip
# What a name stands for, by the key that it has, or in which it is one.
KINDS = {"controller.position": "law", "controller.attitude": "law", "gains": "gain"}
# A misspelt key leaves a missing one behind: tell of the misspelling first.
ORDER = {"additionalProperties": 0, "enum": 1, "const": 1, "type": 1, "required": 3}


def not_finite(value: Any, key: str = "") -> Iterator[InputError]:
    """Yield every number that JSON cannot hold, or no double."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from not_finite(inner, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from not_finite(inner, f"{key}[{i}]")
    elif isinstance(value, int | float) and not isfinite(value):
        yield InputError(f"given {shown(value)}; this must be a finite number", key=key)


def text_problems(document: Row) -> Iterator[InputError]:
    """Yield the first text that is no line of letters that print, and an airframe's name that is no name.

    What an x-* key holds is for others to read.
    """
    block = document.get("airframe")
    name = block.get("name") if isinstance(block, dict) else None
    try:
        if isinstance(name, str):
            check_name(name, key="airframe.name")
        check_texts({key: value for key, value in document.items() if not key.startswith("x-")})
    except InputError as error:
        yield error


def schema_problems(document: Row) -> list[InputError]:
    """Return what the schema refuses, misspelt keys first, missing ones last."""
    found = sorted(validator().iter_errors(document), key=lambda error: ORDER.get(error.validator, 2))
    told: dict[tuple[str | None, str], InputError] = {}
    for error in found:
        for problem in _told(error):
            # The gains of both loops may speak of the same key.
            told.setdefault((problem.key, type(problem).__name__), problem)
    return list(told.values())


def _told(error: Any) -> Iterator[InputError]:
    kind, given, asked, key = error.validator, error.instance, error.validator_value, dotted(error.absolute_path)
    if kind == "additionalProperties":
        known = [*error.schema["properties"], *error.schema.get("patternProperties", ())]
        for name in _unknown(error):
            valid = [entry for entry in known if not entry.startswith("^")]
            yield UnknownNameError(KINDS.get(key, "key"), name, valid, key=joined(key, name))
    elif kind == "required":
        for name in asked:
            if name not in given:
                remedy = _remedy(error.schema["properties"].get(name, {}))
                yield InputError(f"this key is required and missing{remedy}", key=joined(key, name))
    elif kind == "enum" and isinstance(given, str):
        yield UnknownNameError(KINDS.get(key, "choice"), given, asked, key=key)
    elif kind == "const" and key.endswith(".unit"):
        yield InputError(f"given unit {shown(given)}; this must be in {asked} (UCUM)", key=key)
    else:
        yield InputError(f"given {shown(given)}; this must be {_expected(kind, asked)}", key=key)


def _unknown(error: Any) -> list[str]:
    patterns = error.schema.get("patternProperties", {})
    known = error.schema["properties"]
    return [name for name in error.instance if name not in known and not any(search(p, name) for p in patterns)]


def _remedy(schema: Row) -> str:
    """Return what to write for a missing quantity."""
    if "$ref" in schema:
        schema = gains_schema()["$defs"][schema["$ref"].removeprefix("#/$defs/")]
    unit = schema.get("properties", {}).get("unit", {}).get("const")
    return "" if unit is None else f'; write {{"value": ..., "unit": "{unit}"}}'


def _expected(kind: str, asked: Any) -> str:
    if kind == "type":
        return " or ".join(TYPES[name] for name in ([asked] if isinstance(asked, str) else asked))
    if kind in BOUNDS:
        return f"{BOUNDS[kind]} {asked:g}"
    if kind in ("minItems", "maxItems"):
        return f"a list of {asked}"
    if kind == "maxLength" and asked != DIGEST["maxLength"]:
        return f"a text of at most {asked} letters"
    if kind in ("pattern", "maxLength"):
        return "64 hexadecimal digits" if asked in (DIGEST["pattern"], DIGEST["maxLength"]) else "16 to 19 digits"
    if kind == "minLength":
        return "a text that is not empty"
    if kind == "enum":
        return f"one of {', '.join(repr(name) for name in asked)}"
    return shown(asked)


def dotted(path: Any) -> str:
    """Return a path as a key: "objectives[2].unit"."""
    key = ""
    for part in path:
        key = f"{key}[{part}]" if isinstance(part, int) else joined(key, part)
    return key


def joined(key: str, name: str) -> str:
    """Return the key of a name in a table; an empty name has to be seen."""
    name = name or '""'
    return f"{key}.{name}" if key else name
