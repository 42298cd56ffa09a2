"""A table as the text of a TOML or JSON file; whatever a table can hold can be written, nesting of any depth too."""

import json
from dataclasses import dataclass
from math import isfinite


@dataclass(frozen=True)
class Nested:
    """A number inside so many lists."""

    levels: int


def toml_of(table):
    """Everything below the top level stands inline."""
    return "".join(f"{_text(key)} = {_value(value, ' = ')}\n" for key, value in table.items())


def json_of(table):
    return _value(table, ": ")


def _text(text):
    # A JSON string is a TOML basic string, but for the delete character, which TOML wants escaped.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value, equals):
    if isinstance(value, Nested):
        return "[" * value.levels + "1.0" + "]" * value.levels
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_text(key)}{equals}{_value(entry, equals)}" for key, entry in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_value(entry, equals) for entry in value) + "]"
    if isinstance(value, float) and not isfinite(value):
        return repr(value) if equals == " = " else json.dumps(value)
    if value is None:
        return "null"
    return str(value).lower() if isinstance(value, bool) else repr(value)
