"""Kinds of requirements without flights, which extensions add."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from objectives.requirements import Screen
from tuner.extension import added, load, refuse_lacking
from tuner.text.input_errors import listed


@dataclass(frozen=True)
class RequirementKind:
    """A kind of requirement.

    Attributes:
        screen: Function of a table, system, scenarios and root seed that returns the requirements. It raises InputError with the
            key inside the table.
        choices: Key of the table -> names that it may have.
    """

    screen: Callable[[Any, Any, tuple[Any, ...], int], Screen]
    choices: Mapping[str, Collection[str]]


def requirement_kind(table: str) -> RequirementKind:
    """Return the kind of a table; InputError where no extension has it."""
    refuse_lacking("tables", table)
    return load(added("requirements")[table])


def screens_of(
    table: str, path: Path, entries: Sequence[object], system: Any, specs: Sequence[Any], root: int
) -> list[Screen]:
    """Return the requirements of a study's tables; errors name path and key."""
    return list(
        listed(table, path, entries, lambda entry: requirement_kind(table).screen(entry, system, tuple(specs), root))
    )


def choices_of(table: str) -> Mapping[str, Collection[str]]:
    """Return the choices of a table's keys, none without its extension."""
    references = added("requirements")
    return load(references[table]).choices if table in references else {}
