"""Names and parts of gains.json, the blocks of its JSON Schema."""

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


def add_units(schema: Row, content: Any) -> Any:
    """Return plain content as a file of this schema has it: keys in its order, numbers with its units, no key of None."""
    if "items" in schema:
        return [add_units(schema["items"], part) for part in content]
    keys = schema.get("properties", {})
    if "unit" in keys:
        return {"value": content, "unit": keys["unit"]["const"]}
    return (
        {key: add_units(keys[key], content[key]) for key in keys if content.get(key) is not None} if keys else content
    )


FORMAT, VERSION = "gainproof-gains", "1.2"
PLANT_FORMAT, PLANT_VERSION = "gainproof-plant-gains", 1
"""Format of gains of a plant of the user's own: in place of airframe and cascade, its loops as [[channel]] tables."""
# 1.1 adds "vehicle", 1.2 "states" and the worst of them in "objectives".
VERSIONS = ("1.0", "1.1", VERSION)
CONVENTIONS = {
    "world_frame": "ENU",
    "body_frame": "FLU",
    "angle": "rad",
    "quaternion": "wxyz",
    "rotation": "body_to_world",
    "gains": "acceleration of the channel, torque over inertia, force over mass",
    "units": "UCUM",
}
STRUCTURE = {
    "kind": "cascade",
    "position": "x, y, z: position to acceleration, limited to the tilt cone, turned into roll, pitch and thrust at the heading",
    "attitude": "roll, pitch, yaw: angle to torque, allocated to the rotors with the thrust",
    "channel": "y'' = f + b0 u",
}
LINEARISED, DESCRIBING = "linearised", "describing function"
PLANT_INPUT, DEMAND = "plant input", "demand of the position loop"
# Whole numbers that every reader of JSON holds exactly; a larger seed is written as text.
MAX_EXACT_INTEGER = 2**53 - 1
