"""The JSON Schemas of study files: shipped studies keep them, a misspelt key and a name that no registry has break them."""

import json
import tomllib
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from tests.tuner.in_process import tuner
from tuner.study.file_schema import DIALECT, study_schemas
from tuner.study.files import SHIPPED
from tuner.study.kinds import kind_of_layers
from tuner.study.layers import read_layers

SCHEMA_OF = {
    "tuning": "study",
    "plant": "plant-study",
    "contest": "contest-study",
    "trials": "trials-study",
}
STUDIES = sorted(
    path for path in SHIPPED.rglob("*.toml") if "plant" in path.read_text() or "scenario" in path.read_text()
)
PROGRAMS = sorted((SHIPPED.parent / "docs" / "ask_and_tell").glob("*.toml"))


@cache
def schema_called(name: str) -> dict[str, Any]:
    return study_schemas()[name]()


@cache
def validator_called(name: str) -> Draft202012Validator:
    return Draft202012Validator(schema_called(name))


def read(path: Path) -> tuple[dict[str, Any], Draft202012Validator]:
    """The content of a study file, and the validator of its kind."""
    kind = kind_of_layers(read_layers(path)).name
    return tomllib.loads(path.read_text(encoding="utf-8")), validator_called(SCHEMA_OF[kind])


@pytest.mark.parametrize("name", study_schemas())
def test_a_schema_is_one_and_the_command_prints_it(name, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "schema", name)
    assert code == 0 and json.loads(out) == {"$schema": DIALECT, **schema_called(name)}
    Draft202012Validator.check_schema(schema_called(name))


def test_every_kind_of_study_has_files_here():
    assert {kind_of_layers(read_layers(path)).name for path in (*STUDIES, *PROGRAMS)} == set(SCHEMA_OF)


@pytest.mark.parametrize("path", [*STUDIES, *PROGRAMS], ids=lambda path: path.stem)
def test_a_shipped_study_keeps_its_schema(path):
    table, validator = read(path)
    assert [f"{error.json_path}: {error.message}" for error in validator.iter_errors(table)] == []


@pytest.mark.parametrize("path", [*STUDIES, *PROGRAMS], ids=lambda path: path.stem)
def test_a_misspelt_key_breaks_the_schema(path):
    table, validator = read(path)
    assert not validator.is_valid({**table, "scenarioo": []})
    for key, value in table.items():
        wrong = deepcopy(value)
        entry = wrong[0] if isinstance(wrong, list) else wrong
        # Keys of [gains] are addresses, and what lies over a contender's tables is checked with them.
        if isinstance(entry, dict) and key != "gains":
            entry["titel"] = 1
            assert not validator.is_valid({**table, key: wrong}), key


WRONG = [
    ("quickstart", ("scenario", 0, "duration"), "10"),
    ("quickstart", ("scenario", 0, "search"), 0),
    ("quickstart", ("seed",), -1),
    ("quickstart", ("objective", 0, "risk"), "meen"),
    ("quickstart", ("search", "algorithm"), "nsga"),
    ("quickstart", ("airframe", "name"), "hummingbrd"),
    ("dc_motor", ("scenario", 0, "reference", "angle"), {"kind": "stepp", "size": 1.0}),
    ("dc_motor", ("scenario", 0, "reference", "angle"), {"kind": "step", "sise": 1.0}),
    ("dc_motor", ("channel", 0, "every"), 0),
]


@pytest.mark.parametrize(("name", "place", "value"), WRONG, ids=str)
def test_a_wrong_value_breaks_the_schema(name, place, value):
    table, validator = read(SHIPPED / f"{name}.toml")
    level = table
    for key in place[:-1]:
        level = level[key]
    level[place[-1]] = value
    (error,) = validator.iter_errors(table)
    assert list(error.absolute_path) == list(place)


def test_a_study_needs_a_controller_or_a_target():
    table, validator = read(SHIPPED / "quickstart.toml")
    del table["controller"]
    assert not validator.is_valid(table) and validator.is_valid({**table, "target": "px4"})


def objects(schema):
    """Every schema of a table inside a schema."""
    if isinstance(schema, list):
        return [found for part in schema for found in objects(part)]
    if not isinstance(schema, dict):
        return []
    inner = [found for part in schema.values() for found in objects(part)]
    return [schema, *inner] if schema.get("additionalProperties") is False else inner


@pytest.mark.parametrize("name", study_schemas())
def test_every_key_has_its_meaning(name):
    tables = [table for table in objects(schema_called(name)) if "kind" not in table["properties"]]
    bare = [
        key
        for table in tables
        for key, entry in table["properties"].items()
        if "description" not in entry and "$ref" not in entry and entry.get("type") != "array" and "anyOf" not in entry
    ]
    assert tables and bare == []
