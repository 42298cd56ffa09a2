"""Errors that pydantic finds in a study file, in the words of a person who writes one."""

import re
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from plant.errors import InputError, UnknownNameError
from plant.quadrotor.gains import GROUPS
from tuner.study.schema import ControllerTable, ObjectiveTable, ScenarioTable, SearchTable, StudyTable
from tuner.text.input_errors import Fault, dotted
from tuner.text.toml_text import shown

Location = tuple[int | str, ...]

# What to write where a required key is missing; [] stands for any entry of a list.
LINES = {
    "seed": "seed = 2025",
    "title": 'title = "What this study asks"',
    "airframe": '[airframe] with name = "hummingbird"',
    "controller": '[controller] with attitude = "hybrid"',
    "controller.attitude": 'attitude = "hybrid"',
    "scenario": '[[scenario]] with name = "gusts"',
    "scenario[].name": 'name = "gusts"',
    "scenario[].air.gust.amplitude": "amplitude = 5.0  # m/s",
    "scenario[].air.gust.start": "start = 4.0  # s",
    "scenario[].air.gust.length": "length = 2.0  # s",
    "law.file": 'file = "my_law.py"',
    "metric.file": 'file = "my_metric.py"',
    "reference.file": 'file = "my_track.py"',
    "objective": '[[objective]] with metric = "itae.position"',
    "objective[].metric": 'metric = "itae.position"',
    "constraint[].metric": 'metric = "failure"',
    "constraint[].max": "max = 0.0",
    "guarantee[].theorem": 'theorem = "ultimate_error"',
    "guarantee[].axis": 'axis = "attitude"',
    "margin[].quantity": 'quantity = "phase_margin"',
    "contender[].name": 'name = "PID"',
    "published[].contender": 'contender = "PID"',
    "published[].metric": 'metric = "peak.roll"',
    "published[].scenario": 'scenario = "gusts"',
    "published[].value": "value = 0.083  # SI units",
    "claim[].better": 'better = "ADRC"',
    "claim[].than": 'than = ["PID"]',
    "claim[].in": 'in = ["peak.roll"]',
}
# Where a key belongs that stands at the top of the file, in front of the first table or behind the wrong one.
HOMES = {
    name: head
    for table, head in (
        (ScenarioTable, "[[scenario]]"),
        (ObjectiveTable, "[[objective]]"),
        (ControllerTable, "[controller]"),
        (SearchTable, "[search]"),
    )
    for name in table.model_fields
    if name not in StudyTable.model_fields
}
EXPECTED = {
    "string_type": "a text in quotes",
    "float_type": "a number, without unit and without quotes",
    "int_type": "a whole number",
    "bool_type": "true or false",
    "list_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "finite_number": "a finite number",
    "greater_than_equal": "at least {ge}",
    "greater_than": "above {gt}",
    "less_than": "below {lt}",
    "less_than_equal": "at most {le:,}",
}
# Where a key takes either of two types, the branch that was tried ends the location.
EXPECTED_OF_BRANCH = {
    "<number>": "a finite number, or a table like { low = 1.0, high = 9.0 }",
    "<number or text>": "a finite number or a text in quotes",
    "<list or text>": "a list of numbers or a text in quotes",
    "<text or list>": "the path of a file in quotes, or a list of them",
}


def translated(error: ValidationError, path: Path, root: type[BaseModel] = StudyTable) -> InputError:
    """Return the first problem of a pydantic error as an error of ours; root: the table that was validated."""
    problem = min(map(Fault.of, error.errors()), key=_importance)
    location = problem.place
    # The branches of unions are no part of the key.
    key = dotted(part for part in location if isinstance(part, int) or not part.startswith("<"))
    if problem.kind == "extra_forbidden":
        if _unquoted_gain(location):
            line = f'"{location[1]}.{location[-1]}" = {shown(problem.given)}'
            return InputError(f"the dot is part of the key here; write it in quotes: {line}", file=path, key=key)
        home = HOMES.get(str(location[-1])) if len(location) == 1 and root is StudyTable else None
        if home:
            return InputError(f"this is a key of {home}; put it there", file=path, key=key)
        return UnknownNameError("key", str(location[-1]), keys_at(location[:-1], root), file=path, key=key)
    return InputError(_message(problem, key), file=path, key=key)


def _message(problem: Fault, key: str) -> str:
    location, kind, given, limits = problem.place, problem.kind, problem.given, problem.context
    if kind == "missing":
        line = LINES.get(re.sub(r"\[\d+\]", "[]", key), f"{location[-1]} = ...")
        return f"this key is required and missing; write {line}"
    if kind == "too_short":
        return f"given an empty list; give at least one [[{key}]]"
    if kind == "list_type" and isinstance(given, dict):
        return f"given a single table; write its head in double brackets: [[{key}]]"
    expected = EXPECTED_OF_BRANCH.get(str(location[-1])) or EXPECTED.get(kind)
    if expected is None:
        return f"given {shown(given)}; {problem.message.lower()}"
    return f"given {shown(given)}; this must be {expected if not limits else expected.format(**limits)}"


def _importance(problem: Fault) -> int:
    # A misspelt key leaves a missing one behind: tell of the misspelling first.
    return {"extra_forbidden": 0, "missing": 2}.get(problem.kind, 1)


def _unquoted_gain(location: Location) -> bool:
    """True for an unknown key that comes from roll.k1 = 20.0, which TOML reads as a table "roll"."""
    return location[0] == "gains" and len(location) > 2 and location[1] in GROUPS


def keys_at(location: Location, root: type[BaseModel] = StudyTable) -> list[str]:
    """Return the keys that the table at a location of the schema may have."""
    level = root
    for part in location:
        if isinstance(part, str) and part in level.model_fields:
            level = _table_in(level.model_fields[part].annotation) or level
    return list(level.model_fields)


def _table_in(annotation: Any) -> type[BaseModel] | None:
    """Return the table inside list[Table], dict[str, Table] or Table | None."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    tables = (_table_in(part) for part in get_args(annotation))
    return next((table for table in tables if table is not None), None)
