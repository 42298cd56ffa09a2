"""Markdown tables from JSON Schemas: one section for each table of a document, one row for each key."""

import ast
from dataclasses import dataclass, field
from inspect import cleandoc, getsource
from itertools import pairwise
from textwrap import dedent
from typing import Any

Row = dict[str, Any]
BOUNDS = {"minimum": "from", "exclusiveMinimum": "above", "maximum": "up to", "exclusiveMaximum": "below"}
PLAIN = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false", "null": "null"}


@dataclass
class Section:
    """One table of a document: its path, its meaning, and its keys."""

    path: str
    about: str = ""
    keys: dict[str, Row] = field(default_factory=dict)


class Document:
    """A JSON Schema with what its references stand for."""

    def __init__(self, schema: Row) -> None:
        self.schema = schema
        self.definitions = schema.get("$defs", {})

    def followed(self, schema: Row) -> Row:
        """Return a schema without reference, and without the null of what may be left out."""
        if "$ref" in schema:
            target = self.definitions[schema["$ref"].removeprefix("#/$defs/")]
            return {**target, **{key: value for key, value in schema.items() if key != "$ref"}}
        kinds = [kind for kind in schema.get("anyOf", []) if kind != {"type": "null"}]
        if len(kinds) == 1:
            return {**self.followed(kinds[0]), **{key: value for key, value in schema.items() if key != "anyOf"}}
        return schema

    def kind(self, schema: Row) -> str:
        """Return in words what a key takes."""
        schema = self.followed(schema)
        for union in ("oneOf", "anyOf"):
            if union in schema:
                return " or ".join(
                    dict.fromkeys(self.kind(part) for part in schema[union] if part.get("type") != "null")
                )
        if "const" in schema:
            return f"`{written(schema['const'])}`"
        if "enum" in schema:
            return ", ".join(f"`{written(value)}`" for value in schema["enum"])
        kinds = schema.get("type", "")
        if isinstance(kinds, list):
            return " or ".join(PLAIN.get(kind, "table") for kind in kinds)
        if kinds == "array":
            return f"list of {self.kind(schema['items'])}" if "items" in schema else "list"
        bounds = "".join(f", {word} {written(schema[key])}" for key, word in BOUNDS.items() if key in schema)
        return PLAIN.get(kinds, "table") + bounds

    def is_table(self, schema: Row) -> bool:
        """Return whether a key holds a table of known keys."""
        return bool(self.followed(schema).get("properties"))


def written(value: Any) -> str:
    """Return a value as TOML and JSON write it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {written(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(written, value)) + "]"
    return f"{value:g}" if isinstance(value, float) else f"{value:,}" if isinstance(value, int) else str(value)


def attribute_docstrings(kind: type) -> dict[str, str]:
    """Return the texts that stand below the attributes of a class and of those that it is made from.

    Pydantic could put them into the schema by itself, at half a second whenever the program starts.
    """
    if kind.__module__.startswith("pydantic"):
        return {}
    inherited = {
        name: text for base in kind.__bases__ if base is not object for name, text in attribute_docstrings(base).items()
    }
    try:
        body = ast.parse(dedent(getsource(kind))).body[0]
    except (OSError, TypeError):
        return inherited
    assert isinstance(body, ast.ClassDef)
    return inherited | {
        entry.target.id: cleandoc(text.value.value)
        for entry, text in pairwise(body.body)
        if isinstance(entry, ast.AnnAssign)
        and isinstance(entry.target, ast.Name)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
        and isinstance(text.value.value, str)
    }


def cell(text: str) -> str:
    """Return a text that a cell of a table can hold."""
    return " ".join(text.split()).replace("|", "\\|")
