"""A study with [choices], as the contest that it is: a contender for each combination, which race by successive halving."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

from plant.errors import InputError, UnknownNameError
from plant.law_registry import LAWS, law
from plant.quadrotor.cascade import POSITION_AXES
from plant.quadrotor.gains import GROUPS
from plant.texts import PlainTable, PlainValue
from tuner.extensions.contests.reading import checked_tables, contest_from_table, put_in_contest
from tuner.extensions.contests.study import Contest
from tuner.extensions.contests.tables import CONTEST_TABLES, ChoicesTable
from tuner.extensions.contests.terms import terms_of
from tuner.study.layers import Layer, merged, merged_layers
from tuner.study.own_code import use_files_of
from tuner.study.reading import key_parts, put
from tuner.study.schema import ControllerTable, OwnCodeTable
from tuner.text.input_errors import located
from tuner.text.toml_text import tables_in

# Combinations of a study; beyond it the first rung alone takes as long as a search of each.
MAX_COMBINATIONS = 64
# Tables of a contender that hold numbers to be searched, or how.
NUMBERS = ("gains", "search", "pick")
CHOICES, HALVING, CHANNEL, CONTROLLER = "choices", "halving", "channel", "controller"
Combination = tuple[tuple[str, PlainValue], ...]
"""A value of each choice, by its key."""


def choices_from_layers(path: Path, layers: tuple[Layer, ...], overrides: Mapping[str, PlainValue]) -> Contest:
    """Check a study with [choices] whose files have been read."""
    table = merged_layers(layers)
    for key, value in overrides.items():
        put_in_contest(table, key, value, path)
    with located(path, ""):
        return contest_from_table(path, contest_of_choices(table, path), layers)


def contest_of_choices(table: PlainTable, path: Path) -> PlainTable:
    """Return the content of the contest between all combinations."""
    for other in CONTEST_TABLES:
        if other in table and other != HALVING:
            raise InputError(
                "cannot be combined with [choices], whose combinations are the contenders; leave one out", key=other
            )
    given = checked_tables(ChoicesTable, table, path)
    base = {key: value for key, value in table.items() if key != CHOICES}
    allowed = [table for table in terms_of(base).individual if table not in NUMBERS]
    choices = dict(_checked(given.choices, allowed))
    number = prod(map(len, choices.values()))
    if number > MAX_COMBINATIONS:
        raise InputError(f"given {number} combinations; allowed: up to {MAX_COMBINATIONS}", key=CHOICES)
    use_files_of(path, {"law": _own_laws(base)})
    combinations: list[Combination] = [
        tuple(zip(choices, values, strict=True)) for values in product(*choices.values())
    ]
    contents = [_content(base, combination, path) for combination in combinations]
    gains = [_gains_at_hand(content) for content in contents]
    for key in _gains(base):
        if not any(key in entries for entries in gains):
            every = {name for content in contents for name in _gain_names(content, key) or ()}
            raise UnknownNameError("gain of any choice", key.partition(".")[2], every, key=f"gains.{key}")
    entries: list[PlainValue] = [
        {"name": _name(combination), **_individual(content, choices), "gains": fitting}
        for combination, content, fitting in zip(combinations, contents, gains, strict=True)
    ]
    return {**base, HALVING: given.halving.model_dump(exclude_unset=True), "contender": entries}


def _individual(content: PlainTable, choices: Iterable[str]) -> PlainTable:
    """Return the individual tables of a combination; of [controller] chosen keys."""
    parts = [key_parts(key) for key in choices]
    tables = {top: content[top] for top, *_ in parts}
    controller = content.get(CONTROLLER)
    if CONTROLLER in tables and isinstance(controller, Mapping):
        tables[CONTROLLER] = {rest[0]: controller[rest[0]] for top, *rest in parts if top == CONTROLLER and rest}
    return tables


def _own_laws(base: PlainTable) -> OwnCodeTable | None:
    given = base.get("law")
    return OwnCodeTable.model_validate(given) if isinstance(given, dict) else None


def _checked(
    choices: Mapping[str, Any], allowed: Sequence[str], above: str = ""
) -> Iterator[tuple[str, list[PlainValue]]]:
    """Yield the key of each choice with its values; InputError where one is no choice."""
    for name, values in choices.items():
        key = f"{above}{name}"
        if isinstance(values, dict):
            yield from _checked(values, allowed, f"{key}.")
            continue
        place = f"{CHOICES}.{key}"
        if not isinstance(values, list) or len(values) < 2:
            raise InputError('given no choice; write two values or more, such as ["hybrid", "pid"]', key=place)
        if any(value in values[:i] for i, value in enumerate(values)):
            raise InputError("given a value twice; leave one out", key=place)
        if key_parts(key)[0] not in allowed:
            tables = ", ".join(f"{table}.KEY" for table in allowed)
            raise InputError(f"is not to be chosen; allowed: {tables}", key=place)
        yield key, values


def _content(base: PlainTable, combination: Combination, path: Path) -> PlainTable:
    """Return the content of the study of a combination."""
    content = deepcopy(base)
    for key, value in combination:
        place = _numbered(content, key)
        if isinstance(value, Mapping):
            _lay_over(content, place, value, key)
        else:
            put(content, place, value, path)
    return content


def _numbered(content: PlainTable, key: str) -> str:
    """Return a key with the name of a channel as its number."""
    first, *rest = key_parts(key)
    names = [str(entry.get("name")) for entry in tables_in(content.get(CHANNEL))]
    if first != CHANNEL or not rest:
        return key
    if rest[0] not in names:
        raise UnknownNameError("channel", rest[0], names, key=f"{CHOICES}.{key}")
    return ".".join([CHANNEL, str(names.index(rest[0])), *rest[1:]])


def _lay_over(content: Any, place: str, value: Mapping[str, PlainValue], key: str) -> None:
    """Lay a table of a choice over the table at its key."""
    *above, last = key_parts(place)
    level = content
    for part in above:
        level = level[int(part)] if isinstance(level, list) else level.setdefault(part, {})
    index: Any = int(last) if isinstance(level, list) else last
    before = level[index] if isinstance(level, list) else level.get(last, {})
    if not isinstance(before, Mapping):
        raise InputError("is a value, and a choice of it is none of tables", key=f"{CHOICES}.{key}")
    level[index] = merged(before, value)


def _gains(content: PlainTable) -> Mapping[str, PlainValue]:
    gains = content.get("gains")
    return gains if isinstance(gains, Mapping) else {}


def _gains_at_hand(content: PlainTable) -> PlainTable:
    """Return the entries of [gains] that fit the laws of a combination."""
    entries = _gains(content)
    return {
        key: entry
        for key, entry in entries.items()
        if (names := _gain_names(content, key)) is None or key.partition(".")[2] in names
    }


def _gain_names(content: PlainTable, key: str) -> set[str] | None:
    """Return names of gains where a key of [gains] stands; None where no law is known there."""
    place = key.partition(".")[0]
    channels = {str(entry.get("name")): entry.get("law") for entry in tables_in(content.get(CHANNEL))}
    controller = content.get(CONTROLLER)
    if place in channels:
        name = channels[place]
    elif place in GROUPS and isinstance(controller, Mapping):
        loop = "position" if GROUPS[place][0] in POSITION_AXES else "attitude"
        name = controller.get(loop, ControllerTable.model_fields[loop].default)
    else:
        return None
    if not isinstance(name, str) or name not in LAWS:
        return None
    return {gain.name.rstrip("_") for gain in law(name).gains}


def _name(combination: Combination) -> str:
    """Return the name of a contender: its values, with the key of each that is no text."""
    return " / ".join(_label(key_parts(key)[-1], value) for key, value in combination)


def _label(key: str, value: PlainValue) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        return " ".join(str(entry) for entry in value.values() if isinstance(entry, str)) or f"{key} {dict(value)}"
    return f"{key} {str(value).lower() if isinstance(value, bool) else value}"
