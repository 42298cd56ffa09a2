"""From the text of a study file to its checked shape: syntax, overrides, keys and types; errors name file and key."""

import re
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from plant.errors import InputError
from plant.input_files import given_text
from plant.texts import LONGEST_TITLE, PlainTable, PlainValue, check_text, check_texts, check_title, toml_table
from tuner.study.messages import translated
from tuner.study.renamed import with_new_name, with_new_names
from tuner.study.schema import StudyTable
from tuner.study.targets import with_target

Tables = TypeVar("Tables", bound=BaseModel)


def read_study_table(path: Path, overrides: Mapping[str, PlainValue]) -> StudyTable:
    """Return the tables of a study file, with dotted overrides ("search.generations", "scenario.0.search") put in."""
    table = with_new_names(parse_toml(path), path)
    for key, value in overrides.items():
        put(table, key, value, path)
    return checked_table(path, table, StudyTable)


def checked_table(path: Path, table: Mapping[str, PlainValue], model: type[Tables]) -> Tables:
    """Return the content of a study, validated by a model.

    The model has a title and scenarios; path: the file that errors name.
    """
    # Whole tables may come from a command line or from another file.
    table = with_target(with_new_names(table, path), path)
    try:
        checked: Any = model.model_validate(table)
    except ValidationError as error:
        raise translated(error, path, model) from None
    check_title(checked.title, file=path, key="title")
    for i, scenario in enumerate(checked.scenario):
        check_text(scenario.name, LONGEST_TITLE, file=path, key=f"scenario[{i}].name")
    # Overrides come from no file.
    check_texts(table, file=path)
    return checked


def parse_toml(path: Path) -> PlainTable:
    """Return the content of a TOML file; InputError where it is missing or no TOML, with line and column."""
    table = toml_table(given_text(path, "`tuner new NAME` writes one to start from"), path)
    check_texts(table, file=path)
    return table


def put(table: Any, key: str, value: Any, path: Path) -> None:
    """Set a dotted key in nested tables and lists; scenario.0.search and scenario[0].search are the same."""
    *parents, last = key_parts(with_new_name(key))
    level = table
    for part in parents:
        level = _child(level, part, key, path)
    if isinstance(level, list):
        level[_index(level, last, key, path)] = deepcopy(value)
    else:
        level[last] = deepcopy(value)


def key_parts(key: str) -> list[str]:
    """Split a dotted key of a study: scenario[0].search is scenario, 0, search; a key of [gains] keeps its own dot."""
    parts = re.sub(r"\[(\d+)\]", r".\1", key).split(".")
    # The keys of [gains] hold a dot themselves: gains.roll.k1.low is table "gains", key "roll.k1", key "low".
    if parts[0] == "gains" and len(parts) > 2:
        parts[1:3] = [f"{parts[1]}.{parts[2]}"]
    return parts


def _child(level: Any, part: str, key: str, path: Path) -> Any:
    if isinstance(level, list):
        return level[_index(level, part, key, path)]
    child = level.setdefault(part, {})
    if not isinstance(child, dict | list):
        raise InputError(f"'{part}' is a value, not a table; give a key that the study has", file=path, key=key)
    return child


def _index(level: list[Any], part: str, key: str, path: Path) -> int:
    if not part.isdecimal() or int(part) >= len(level):
        raise InputError(f"'{part}' is no entry of this list; allowed: 0 to {len(level) - 1}", file=path, key=key)
    return int(part)
