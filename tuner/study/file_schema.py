"""JSON Schemas of study files, for editors.

They come from the tables that `tuner check` uses, with the names of registries put in.

A schema is narrower than the check where a key has old names, and wider where names may come from the user's own files, where
a number hangs on another one, and in what lies over the tables of a base file.
"""

from collections.abc import Callable, Iterable, Mapping
from copy import deepcopy
from dataclasses import fields
from typing import Any

from pydantic import BaseModel

from objectives.margins.quantities import LIMITABLE
from objectives.metrics import METRICS
from objectives.risk import RISKS
from plant.law_registry import LAWS
from plant.model.signals import SIGNALS
from plant.quadrotor import airframes
from plant.quadrotor.gains import GROUPS
from plant.references import REFERENCES
from tuner.extension import objects
from tuner.search.names import ALGORITHMS, AUTOMATIC, CONVERGED, GENERATIONS
from tuner.study.plant_schema import PlantStudyTable
from tuner.study.requirement_kinds import choices_of
from tuner.study.schema import StudyTable
from tuner.study.targets import TARGETS

Schema = dict[str, Any]

DIALECT = "https://json-schema.org/draft/2020-12/schema"
TEXTS: Schema = {"type": "array", "items": {"type": "string"}, "minItems": 1}


def _closed(names: Iterable[str]) -> Schema:
    return {"enum": list(names)}


def _open(names: Iterable[str]) -> Schema:
    """Return the schema of names that may be others too."""
    return {"anyOf": [_closed(names), {"type": "string"}]}


def _metrics() -> list[str]:
    addresses = [
        [f"{name}.{axis}" for axis in GROUPS] if entry.scope == "axis" else [name] for name, entry in METRICS.items()
    ]
    return [address for group in addresses for address in group]


def _signal() -> Schema:
    """Return the schema of a signal: its kind with the keys of that kind."""
    kinds = [
        {
            "type": "object",
            "description": entry.meaning,
            "properties": {"kind": {"const": name}, **{field.name: {"type": "number"} for field in fields(entry)}},
            "required": ["kind"],
            "additionalProperties": False,
        }
        for name, entry in SIGNALS.items()
    ]
    return {"oneOf": kinds}


def _choices() -> dict[str, dict[str, Schema]]:
    """Return the choices of keys, by table and key."""
    law, metric, risk = _open(LAWS), _open(_metrics()), _closed(RISKS)
    scale, rate = _closed(("log", "linear")), _closed(("measured", "observer"))
    judged = {"metric": metric, "risk": risk}
    signals = {"additionalProperties": _signal()}
    kind = {"properties": {"kind": _open(REFERENCES)}, "required": ["kind"]}
    search = {"algorithm": _closed((AUTOMATIC, *ALGORITHMS)), "stop": _closed((GENERATIONS, CONVERGED))}
    return {
        "AirframeTable": {"name": _closed(airframes.names())},
        "StudyChannelTable": {"law": law},
        "ClaimTable": {"than": {"anyOf": [{"type": "string"}, TEXTS]}, "in": {"anyOf": [{"type": "string"}, TEXTS]}},
        "ConstraintTable": judged,
        "ControllerTable": {"attitude": law, "position": law, "attitude_rate": rate, "position_rate": rate},
        "GainTable": {"scale": scale},
        "GuaranteeTable": {key: _closed(names) for key, names in choices_of("guarantee").items()},
        "MarginTable": {"quantity": _closed(LIMITABLE), "at": _closed(("trims", "hover"))},
        "ObjectiveTable": judged,
        "PlantGainTable": {"scale": scale},
        "PlantScenarioTable": {"reference": signals, "disturbance": signals},
        "PublishedTable": {"contender": {"anyOf": [{"type": "string"}, TEXTS]}},
        "ScenarioTable": {"reference": kind},
        "SearchTable": search,
        "StudyTable": {"target": _closed(TARGETS)},
        "TrialConstraintTable": {"risk": risk},
        "TrialObjectiveTable": {"risk": risk},
        "TrialSearchTable": search,
        "VariableTable": {"scale": scale},
    }


def _cleaned(schema: Any) -> Any:
    """Return a schema without titles of keys and without null."""
    if isinstance(schema, list):
        return [_cleaned(entry) for entry in schema]
    if not isinstance(schema, dict):
        return schema
    result = {key: value for key, value in schema.items() if not (key == "default" and value is None)}
    parts = result.get("anyOf", [])
    if {"type": "null"} in parts:
        rest = [part for part in parts if part != {"type": "null"}]
        del result["anyOf"]
        result |= rest[0] if len(rest) == 1 else {"anyOf": rest}
    return {
        key: {name: _without_title(_cleaned(entry)) for name, entry in value.items()}
        if key == "properties"
        else _cleaned(value)
        for key, value in result.items()
    }


def _without_title(schema: Schema) -> Schema:
    return {key: value for key, value in schema.items() if key != "title"}


def _chosen(schema: Schema, keys: Mapping[str, Schema]) -> None:
    """Put choices into the keys of a table."""
    for key, choice in keys.items():
        entry = schema["properties"][key]
        if "properties" not in choice and "additionalProperties" not in choice:
            for word in ("type", "items", "minItems", "enum", "anyOf"):
                entry.pop(word, None)
        entry.update(deepcopy(choice))


def table_schema(model: type[BaseModel]) -> Schema:
    """Return the schema of the tables of a model."""
    schema, choices = _cleaned(model.model_json_schema()), _choices()
    tables = {model.__name__: schema, **schema.get("$defs", {})}
    for name in tables.keys() & choices.keys():
        _chosen(tables[name], choices[name])
    return schema


def study_schema() -> Schema:
    """Return the schema of a study of a quadrotor."""
    schema = table_schema(StudyTable)
    # A target stands in for the controller, or for its laws.
    schema["required"].remove("controller")
    controller = schema["$defs"]["ControllerTable"]
    del controller["required"]
    given = {"properties": {"controller": {"required": ["attitude"]}}, "required": ["controller"]}
    return {**schema, "anyOf": [given, {"required": ["target"]}]}


STUDY_SCHEMAS: dict[str, Callable[[], Schema]] = {
    "study": study_schema,
    "plant-study": lambda: table_schema(PlantStudyTable),
}
"""Name of `tuner schema` -> schema of a kind of study file of the core; those of extensions are in their records."""


def study_schemas() -> dict[str, Callable[[], Schema]]:
    """Return the functions that return the schema of a kind of study file, by the name of `tuner schema`."""
    return STUDY_SCHEMAS | objects("schemas")
