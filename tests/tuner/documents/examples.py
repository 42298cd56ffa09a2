"""Made-up documents, built from the schema of their model: a key that is added there is in every example at once."""

import re
from functools import cache
from typing import Any

from tuner.store.document import Document

TEXT = "text"
# A file of a results folder, for what must name one.
IN_FOLDER = "inputs/study.toml"


def example_of(model: type[Document]) -> dict[str, Any]:
    """Return the content of a document with every key that its model knows."""
    schema = _schema(model)
    return filled(schema, schema.get("$defs", {}))


@cache
def _schema(model: type[Document]) -> dict[str, Any]:
    return model.model_json_schema(by_alias=True)


def filled(schema: Any, definitions: dict[str, Any], depth: int = 0) -> Any:
    """Return a value that fits a schema; a document inside one of its own kind is left empty."""
    if schema is True:
        return TEXT
    if "$ref" in schema:
        return filled(definitions[schema["$ref"].rpartition("/")[2]], definitions, depth + 1)
    if "const" in schema or "enum" in schema:
        return schema.get("const", schema.get("enum", [None])[0])
    for choice in ("anyOf", "oneOf"):
        if choice in schema:
            return filled(schema[choice][0], definitions, depth)
    kind = schema.get("type")
    if kind == "object" and "properties" in schema:
        return {key: filled(part, definitions, depth) for key, part in schema["properties"].items()}
    if kind == "object":
        return {TEXT: filled(schema["additionalProperties"], definitions, depth)}
    if kind == "array":
        return [] if depth > 20 else [filled(schema["items"], definitions, depth + 5)]
    if kind == "string":
        return next(text for text in (TEXT, "", IN_FOLDER) if re.search(schema.get("pattern", ""), text))
    return {"integer": 3, "number": 0.25, "boolean": True}.get(str(kind))
