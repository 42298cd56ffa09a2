"""The JSON Schema (2020-12) of gains.json, made from the registries: laws, frames, numbers of an airframe, units.

Nothing but x-* at the top is open, so that a misspelt key is an error. The gains that a law needs are chosen by
controller.position and controller.attitude. It is made once a process; `tuner schema gains` prints it for other programs.
"""

import json
from functools import cache
from typing import Any

from plant.cascade import ATTITUDE_AXES, POSITION_AXES
from plant.laws import LAWS
from plant.laws.law import GainInfo, Law
from tuner.gains.airframe_block import airframe_schema
from tuner.gains.sections import (
    CONVENTIONS,
    DIGEST,
    FORMAT,
    VERSIONS,
    Row,
    closed,
    controller_schema,
    cost_schema,
    design_schema,
    exports_schema,
    listed,
    margins_schema,
    objectives_schema,
    study_schema,
    texts,
    vehicle_schema,
)
from tuner.gains.ucum import ucum

ID = "urn:holdfast:gains:1.1"
LOOPS = {"position": POSITION_AXES, "attitude": ATTITUDE_AXES}
# Keys that a document may lack.
OPTIONAL = ("vehicle", "study", "objectives", "design", "margins", "cost", "exports", "sha256")


@cache
def gains_schema() -> Row:
    """Return the schema as JSON-able data."""
    top = closed(
        {
            "format": {"const": FORMAT},
            "version": {"enum": list(VERSIONS)},
            "generator": closed(texts("name", "version")),
            "conventions": closed({key: {"const": value} for key, value in CONVENTIONS.items()}),
            "airframe": airframe_schema(),
            "controller": controller_schema(list(LAWS)),
            "gains": {"type": "object"},
            "vehicle": vehicle_schema(),
            "study": study_schema(),
            "objectives": listed(objectives_schema()),
            "design": listed(design_schema()),
            "margins": listed(margins_schema()),
            "cost": listed(cost_schema()),
            "exports": listed(exports_schema()),
            "sha256": DIGEST,
        },
        optional=OPTIONAL,
    )
    choices, definitions = gains_by_law()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": ID,
        "title": "gains.json of holdfast: a quadrotor controller with every number's unit (UCUM)",
        "description": "sha256: SHA-256 over the RFC 8785 canonical form of everything but sha256, exports and cost.",
        **top,
        "patternProperties": {"^x-": {}},
        "allOf": choices,
        "$defs": definitions,
    }


def gains_by_law() -> tuple[list[Row], Row]:
    """Return the choice of the gains by the law of each loop, and what it refers to; laws with the same gains share."""
    choices, definitions = [], {}
    for loop in LOOPS:
        sharing: dict[str, list[str]] = {}
        for law in LAWS.values():
            gains = {gain.name: gain_schema(gain, loop) for gain in law.gains}
            sharing.setdefault(json.dumps(gains), []).append(law.name)
        for laws in sharing.values():
            name = f"{laws[0]}.{loop}"
            choices.append(chosen(loop, laws, name))
            definitions[name] = gains_of(LAWS[laws[0]], loop)
            definitions |= {f"{name}.{_written(gain)}": gain_schema(gain, loop) for gain in LAWS[laws[0]].gains}
    return choices, definitions


def chosen(loop: str, laws: list[str], name: str) -> Row:
    """Return: where a loop has one of the laws, the gains are those of the definition of that name."""
    controller = {"type": "object", "properties": {loop: {"enum": laws}}, "required": [loop]}
    return {
        "if": {"properties": {"controller": controller}, "required": ["controller"]},
        "then": {"properties": {"gains": {"$ref": f"#/$defs/{name}"}}},
    }


def gains_of(law: Law, loop: str) -> Row:
    """Return the schema of the gains of one loop; those of the other loop are left to its own."""
    axes, others = LOOPS[loop], LOOPS["attitude" if loop == "position" else "position"]
    properties = {
        f"{axis}.{_written(gain)}": {"$ref": f"#/$defs/{law.name}.{loop}.{_written(gain)}"}
        for axis in axes
        for gain in law.gains
    }
    return {**closed(properties), "patternProperties": {f"^({'|'.join(others)})\\.": {}}}


def _written(gain: GainInfo) -> str:
    return gain.name.rstrip("_")


def gain_schema(gain: GainInfo, loop: str) -> Row:
    """Return the schema of one gain: value, unit and, where a search had one, its range."""
    bound = "exclusiveMinimum" if gain.exclusive else "minimum"
    value = {"type": "number", bound: gain.least}
    unit = {"const": ucum(gain.unit_in(loop))}
    ends = {"type": "number"}
    return {
        "description": gain.meaning,
        **closed({"value": value, "unit": unit, "low": ends, "high": ends}, optional=("low", "high")),
    }


def schema_text() -> str:
    """Return the schema as the text of a file."""
    return json.dumps(gains_schema(), indent=1, ensure_ascii=False) + "\n"


@cache
def validator() -> Any:
    """Return a validator of the schema, of the package jsonschema."""
    from jsonschema import Draft202012Validator

    return Draft202012Validator(gains_schema())
