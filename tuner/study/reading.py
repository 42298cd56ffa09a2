"""From the text of a study file to its checked shape: syntax, keys and types, with errors that name file and key."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from plant.errors import InputError, UnknownNameError
from tuner.study.schema import StudyTable

# What to write where a required key is missing.
LINES = {
    "seed": "seed = 2025",
    "title": 'title = "What this study asks"',
    "controller": '[controller] with attitude = "hybrid"',
    "controller.attitude": 'attitude = "hybrid"',
    "scenario": '[[scenario]] with name = "gusts"',
    "objective": '[[objective]] with metric = "itae.position"',
}
EXPECTED = {
    "string_type": "a text in quotes",
    "float_type": "a number",
    "int_type": "a whole number",
    "bool_type": "true or false",
    "list_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "finite_number": "a finite number",
}


def read_study_table(path: Path, overrides: Mapping[str, Any]) -> StudyTable:
    """Return the tables of a study file, with dotted overrides ("search.generations", "scenario.0.search") put in."""
    table = parse_toml(path)
    for key, value in overrides.items():
        put(table, key, value, path)
    try:
        return StudyTable.model_validate(table)
    except ValidationError as error:
        raise translated(error, path) from None


def parse_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file; InputError where it is missing or no TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("there is no such file; `tuner new NAME` writes one to start from", file=path) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"the file cannot be read: {error}", file=path) from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"not TOML: {error}", file=path) from None


def put(table: Any, key: str, value: Any, path: Path) -> None:
    """Set a dotted key in nested tables and lists; numbers address list entries."""
    *parents, last = _parts(key)
    here = table
    for part in parents:
        here = _child(here, part, key, path)
    if isinstance(here, list):
        here[_index(here, last, key, path)] = value
    else:
        here[last] = value


def _parts(key: str) -> list[str]:
    # The keys of [gains] hold a dot themselves: gains.roll.k1 is table "gains", key "roll.k1".
    head, _, rest = key.partition(".")
    return [head, rest] if head == "gains" and rest else key.split(".")


def _child(here: Any, part: str, key: str, path: Path) -> Any:
    if isinstance(here, list):
        return here[_index(here, part, key, path)]
    child = here.setdefault(part, {})
    if not isinstance(child, (dict, list)):
        raise InputError(f"'{part}' is a value, not a table; give a key that the study has", file=path, key=key)
    return child


def _index(here: list[Any], part: str, key: str, path: Path) -> int:
    if not part.isdecimal() or int(part) >= len(here):
        raise InputError(f"'{part}' is no entry of this list; allowed: 0 to {len(here) - 1}", file=path, key=key)
    return int(part)


def translated(error: ValidationError, path: Path) -> InputError:
    """Return the first problem of a pydantic error as an error of ours."""
    problem = sorted(error.errors(), key=_importance)[0]
    key = dotted(problem["loc"])
    kind, given = problem["type"], problem["input"]
    if kind == "extra_forbidden":
        valid = keys_at(problem["loc"][:-1])
        return UnknownNameError("key", str(problem["loc"][-1]), valid, file=path, key=key)
    if kind == "missing":
        line = LINES.get(key, f"{problem['loc'][-1]} = ...")
        return InputError(f"this key is required and missing; write {line}", file=path, key=key)
    if kind in EXPECTED:
        return InputError(f"given {_shown(given)}; this must be {EXPECTED[kind]}", file=path, key=key)
    return InputError(f"given {_shown(given)}; {problem['msg'].lower()}", file=path, key=key)


def _importance(problem: Any) -> int:
    # A misspelt key leaves a missing one behind: tell of the misspelling first.
    return {"extra_forbidden": 0, "missing": 2}.get(problem["type"], 1)


def _shown(given: Any) -> str:
    text = repr(given)
    return text if len(text) <= 60 else text[:57] + "..."


def dotted(location: tuple[int | str, ...]) -> str:
    """Return a location as a key: ("scenario", 0, "air") is scenario[0].air; names of union branches are left out."""
    key = ""
    for part in location:
        if isinstance(part, int):
            key += f"[{part}]"
        elif part in _BRANCHES or part.startswith(("list[", "function-")):
            continue
        else:
            key += f".{part}" if key else part
    return key


_BRANCHES = frozenset({"float", "str", "GainTable", "int", "GustTable", "InjectionTable"})


def keys_at(location: tuple[int | str, ...]) -> list[str]:
    """Return the keys that the table at a location of the schema may have."""
    here: Any = StudyTable
    for part in location:
        if isinstance(part, int) or part in _BRANCHES or not _is_table(here):
            continue
        here = _table_in(here.model_fields[part].annotation) if part in here.model_fields else here
    return list(here.model_fields)


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _table_in(annotation: Any) -> Any:
    """Return the table inside list[Table], dict[str, Table] or Table | None."""
    if _is_table(annotation) or get_origin(annotation) not in (list, dict, Union, UnionType):
        return annotation
    inner = [_table_in(part) for part in get_args(annotation) if part not in (NoneType, str, float)]
    return inner[-1] if inner else annotation
