"""The few forms that the JSON Schema of gains.json is put together from."""

from collections.abc import Iterable
from typing import Any

Row = dict[str, Any]

# maxLength, because $ of some regular expressions lets a line break through.
DIGEST: Row = {"type": "string", "pattern": "^[0-9a-f]{64}$", "maxLength": 64}


def closed(properties: Row, optional: Iterable[str] = ()) -> Row:
    """Return the schema of an object with these keys and no others."""
    left_out = set(optional)
    return {
        "type": "object",
        "properties": properties,
        "required": [key for key in properties if key not in left_out],
        "additionalProperties": False,
    }


def measured(unit: str, **bounds: float) -> Row:
    """Return the schema of {value, unit} in one unit (UCUM)."""
    return closed({"value": {"type": "number", **bounds}, "unit": {"const": unit}})


def listed(items: Row) -> Row:
    """Return the schema of a list."""
    return {"type": "array", "items": items}


def texts(*names: str) -> Row:
    """Return the schemas of keys that hold any text."""
    return {name: {"type": "string"} for name in names}
