"""Targets by name, of core and extensions, and their options."""

from collections.abc import Sequence
from functools import cache

from plant.errors import InputError, UnknownNameError, check_name
from plant.input_files import ReadableFile
from plant.quadrotor.airframes import Airframe
from tuner.exchange.c99 import export as c99
from tuner.exchange.target import FIRMWARE, ExportTarget, ImportedController, Importer, flag
from tuner.extension import objects, refuse_lacking
from tuner.text.pairs import named_text


@cache
def exporters() -> dict[str, ExportTarget]:
    """Return every target by name, in the order of listings: those of the core first."""
    return {c99.TARGET.name: c99.TARGET} | objects("targets")


@cache
def importers() -> dict[str, Importer]:
    """Return the way back of the targets that have one, by name."""
    return {name: target.importer for name, target in exporters().items() if target.importer}


def exporter(name: str) -> ExportTarget:
    """Return the target of a name; raises UnknownNameError."""
    name = name.lower()
    refuse_lacking("targets", name, key="--to")
    check_name("target", name, exporters(), key="--to")
    return exporters()[name]


def importer(name: str) -> Importer:
    """Return the importer of a target; raises UnknownNameError."""
    check_name("source", name, importers(), key="--from")
    return importers()[name]


def import_parameters(source: str, file: ReadableFile, airframe: Airframe, given: Sequence[str]) -> ImportedController:
    """Return the controller of a parameter file; given: options as NAME=VALUE texts."""
    chosen = importer(source)
    return chosen.read(file, airframe, settings_of(chosen, given))


def settings_of(target: ExportTarget | Importer, given: Sequence[str]) -> dict[str, str]:
    """Return a value for every option from "NAME=VALUE" texts and defaults; raises InputError naming the option."""
    options = {option.name: option for option in target.options}
    values: dict[str, str] = {}
    for entry in given:
        name, value = named_text(entry, "--set", _example(target))
        if name not in options:
            if name == FIRMWARE:
                raise InputError(f"given '{value}'; '{target.name}' does not ask for it, leave it out", key=flag(name))
            if not options:
                raise InputError(f"given '{entry}'; '{target.name}' has no options", key="--set")
            raise UnknownNameError(f"option of '{target.name}'", name, options, key="--set")
        if name in values:
            raise InputError(f"'{name}' is given twice; leave one out", key="--set")
        values[name] = value
    for option in target.options:
        if option.name not in values:
            if option.default is None:
                raise InputError(
                    f"'{target.name}' needs {option.name} ({option.about}): {flag(option.name)}"
                    f"{' ' if option.name == FIRMWARE else '='}{' or '.join(option.choices) or 'NUMBER'}",
                    key=flag(option.name),
                )
            values[option.name] = option.default
        elif option.choices and values[option.name] not in option.choices:
            allowed = ", ".join(option.choices)
            raise InputError(f"given '{values[option.name]}'; allowed: {allowed}", key=flag(option.name))
    return values


def _example(target: ExportTarget | Importer) -> str:
    option = target.options[0] if target.options else None
    return "NAME=VALUE" if option is None else f"{option.name}={option.default or (option.choices or ('1',))[0]}"
