"""The options of an export: what a person gave, checked against what the target knows."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from plant.errors import InputError, UnknownNameError
from tuner.exchange.exporter import Option

# The option that has a flag of its own.
FIRMWARE = "firmware"


class Optioned(Protocol):
    """What takes options: an exporter or an importer."""

    @property
    def name(self) -> str:
        """Name in its registry."""
        ...

    @property
    def options(self) -> tuple[Option, ...]:
        """What may be given."""
        ...


def settings_of(optioned: Optioned, given: Sequence[str]) -> dict[str, str]:
    """Return a value for every option from "NAME=VALUE" texts and defaults; raises InputError naming the option."""
    options = {option.name: option for option in optioned.options}
    values: dict[str, str] = {}
    for entry in given:
        name, sign, value = entry.partition("=")
        if not sign:
            raise InputError(f"given '{entry}'; write NAME=VALUE, for instance {_example(optioned)}", key="--set")
        if name not in options:
            if name == FIRMWARE:
                raise InputError(
                    f"given '{value}'; '{optioned.name}' does not ask for it, leave it out", key=_flag(name)
                )
            if not options:
                raise InputError(f"given '{entry}'; '{optioned.name}' has no options", key="--set")
            raise UnknownNameError(f"option of '{optioned.name}'", name, options, key="--set")
        if name in values:
            raise InputError(f"'{name}' is given twice; leave one out", key="--set")
        values[name] = value
    for option in optioned.options:
        if option.name not in values:
            if option.default is None:
                raise InputError(
                    f"'{optioned.name}' needs {option.name} ({option.about}): {_flag(option.name)}"
                    f"{' ' if option.name == FIRMWARE else '='}{' or '.join(option.choices) or 'NUMBER'}",
                    key=_flag(option.name),
                )
            values[option.name] = option.default
        elif option.choices and values[option.name] not in option.choices:
            allowed = ", ".join(option.choices)
            raise InputError(f"given '{values[option.name]}'; allowed: {allowed}", key=_flag(option.name))
    return values


def number(settings: Mapping[str, str], name: str, low: float, high: float, unit: str) -> float:
    """Return an option as a number of that unit; raises InputError where it is none, or outside [low, high]."""
    text, with_unit = settings[name], "" if unit == "1" else f" {unit}"
    try:
        value = float(text)
    except ValueError:
        asked = f"a number{'' if unit == '1' else f' in {unit}'}"
        raise InputError(f"given '{text}'; this must be {asked}", key=_flag(name)) from None
    if not low <= value <= high:
        raise InputError(f"given {text}{with_unit}; allowed: {low:g} to {high:g}{with_unit}", key=_flag(name))
    return value


def _flag(name: str) -> str:
    return f"--{name}" if name == FIRMWARE else f"--set {name}"


def _example(optioned: Optioned) -> str:
    known = optioned.options[0] if optioned.options else None
    return "NAME=VALUE" if known is None else f"{known.name}={known.default or (known.choices or ('1',))[0]}"
