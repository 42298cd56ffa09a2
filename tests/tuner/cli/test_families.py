"""The assembly of the command line: every command is registered by its family, every answer has a printer."""

import importlib
import inspect

import pytest

import tuner
from tuner.cli import main, printing
from tuner.cli.app import app
from tuner.extension import added, extensions, load
from tuner.store.document import DocumentPart


def test_every_command_is_registered_by_a_family():
    homes = {command.callback.__module__ for command in app.registered_commands if command.callback}
    extended = {record.command_module for record in extensions().values() if record.commands}
    assert homes == {family.__name__ for family in main.FAMILIES} | extended


@pytest.mark.parametrize("kind", printing.PRINTERS)
def test_the_printer_of_an_answer_is_there(kind):
    printer = load(printing.PRINTERS[kind])
    assert next(iter(inspect.signature(printer).parameters.values())).annotation == kind


def test_what_the_library_returns_has_a_printer():
    """Every type that stands behind JSON, of all modules of the interface."""
    kinds = set()
    for home in (*tuner._HOMES, *{reference.partition(":")[0] for reference in added("api").values()}):
        module = importlib.import_module(home)
        for name, value in vars(module).items():
            if inspect.isclass(value) and value.__module__ == home and hasattr(value, "json"):
                # A part of a document has none of its own; pydantic offers an old method of that name.
                if issubclass(value, DocumentPart):
                    continue
                kinds.add(name)
    assert kinds - {"ComparedResults", "Results"} <= set(printing.PRINTERS)
