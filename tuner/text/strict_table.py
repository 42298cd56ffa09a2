"""Tables with a closed set of keys and errors in plain words."""

import ast
import re
import sys
from collections.abc import Mapping
from functools import cache
from inspect import getsource
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from plant.errors import InputError, UnknownNameError
from plant.quadrotor.gains import GROUPS
from tuner.text.input_errors import Fault, dotted
from tuner.text.toml_text import shown

Location = tuple[int | str, ...]

NO_TEXTS: Mapping[str, str] = MappingProxyType({})
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
    "<path or points>": 'a path in quotes, or a table like { points = [{ "roll.k1" = 20.0 }] }',
}


@cache
def _meanings(module: str) -> dict[str, dict[str, str]]:
    """Return the texts below the fields of a module's classes."""
    texts: dict[str, dict[str, str]] = {}
    statements = ast.parse(getsource(sys.modules[module])).body
    for kind in [statement for statement in statements if isinstance(statement, ast.ClassDef)]:
        for entry, below in pairwise(kind.body):
            match entry, below:
                case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(text))):
                    texts.setdefault(kind.name, {})[name] = text
    return texts


class StrictTable(BaseModel):
    """A table with a closed set of keys, each of one type.

    The text below a field is its meaning.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False, defer_build=True)

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Take over the meanings of the fields; pydantic does that too, but takes 0.3 to 0.8 s of each start for it."""
        for name, text in _meanings(cls.__module__).get(cls.__name__, {}).items():
            cls.model_fields[name].description = text


def translate_error(
    error: ValidationError,
    path: Path,
    root: type[BaseModel],
    lines: Mapping[str, str] = NO_TEXTS,
    homes: Mapping[str, str] = NO_TEXTS,
) -> InputError:
    """Return the first problem of a pydantic error as an InputError.

    Args:
        error: Errors of pydantic.
        path: The file.
        root: The table that was validated.
        lines: Hint for a missing required key; [] represents any entry of a list.
        homes: Place of a key that stands at the top by mistake.
    """
    problem = min(map(Fault.of, error.errors()), key=_importance)
    location = problem.place
    # The branches of unions are no part of the key.
    key = dotted(part for part in location if isinstance(part, int) or not part.startswith("<"))
    if problem.kind == "extra_forbidden":
        if _unquoted_gain(location):
            line = f'"{location[1]}.{location[-1]}" = {shown(problem.given)}'
            return InputError(f"the dot is part of the key here; write it in quotes: {line}", file=path, key=key)
        home = homes.get(str(location[-1])) if len(location) == 1 else None
        if home:
            return InputError(f"this is a key of {home}; put it there", file=path, key=key)
        return UnknownNameError("key", str(location[-1]), keys_at(location[:-1], root), file=path, key=key)
    return InputError(_message(problem, key, lines), file=path, key=key)


def _message(problem: Fault, key: str, lines: Mapping[str, str]) -> str:
    location, kind, given, limits = problem.place, problem.kind, problem.given, problem.context
    if kind == "missing":
        line = lines.get(re.sub(r"\[\d+\]", "[]", key), f"{location[-1]} = ...")
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
    """Return True for a gain without quotes, a nested table in TOML."""
    return location[0] == "gains" and len(location) > 2 and location[1] in GROUPS


def keys_at(location: Location, root: type[BaseModel]) -> list[str]:
    """Return the keys of the table at a location of the schema."""
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
