"""Turns the reference table of a study file into a spec: strict about kind and keys, paths relative to the study."""

from collections.abc import Mapping
from pathlib import Path

from plant.errors import InputError, UnknownNameError
from plant.references.parameters import Parameter, parameters
from plant.references.spec import ReferenceSpec
from plant.registry import Registry


def from_table(
    kinds: Registry[type[ReferenceSpec]], mapping: Mapping[str, object], base: Path | None, key: str
) -> ReferenceSpec:
    """Return the spec that a table like {kind = "steps", x = 1.0} describes.

    Args:
        kinds: the registry.
        mapping: the table.
        base: the folder that a relative path starts from (none: the working directory).
        key: the dotted key of the table, for messages.

    Raises UnknownNameError on an unknown kind or key, else InputError.
    """
    given = dict(mapping)
    kind = _kind(kinds, given.pop("kind", None), key)
    by_name = {parameter.name: parameter for parameter in parameters(kind)}
    for name in given:
        if name not in by_name:
            raise UnknownNameError("key", name, ["kind", *by_name], key=f"{key}.{name}")
    for parameter in by_name.values():
        if parameter.default is None and parameter.name not in given:
            raise InputError(f"is missing; write {_line(parameter)}", key=f"{key}.{parameter.name}")
    if "path" in by_name:
        given["path"] = _resolved(given["path"], base, f"{key}.path")
    try:
        return kind(**given)
    except InputError as error:
        if error.file:  # in a file that the table points to: the error names its place there
            raise
        raise InputError(error.message, key=f"{key}.{error.key}" if error.key else key) from error


def _kind(kinds: Registry[type[ReferenceSpec]], name: object, key: str) -> type[ReferenceSpec]:
    if not isinstance(name, str):
        given = "is missing" if name is None else f"is {name!r}"
        raise InputError(f"{given}; it must be one of {', '.join(sorted(kinds))}", key=f"{key}.kind")
    try:
        return kinds.find(name)
    except UnknownNameError as error:
        raise error.located(key=f"{key}.kind") from None


def _line(parameter: Parameter) -> str:
    value = '"<file>"' if parameter.unit == "path" else f"<number>  # {parameter.unit}"
    return f"{parameter.name} = {value}: {parameter.meaning}"


def _resolved(path: object, base: Path | None, key: str) -> str:
    if not isinstance(path, str) or not path.strip():
        raise InputError(f"is {path!r}; it must be the path of a file", key=key)
    return str(Path(path) if base is None else base / path)
