"""The command line: a command is its signature, one call of the library, one print; nothing numerical lives here.

The families of commands import nothing heavy, because `tuner --help` must not wait for compilers and plotting libraries: the
library's names load when a command calls them, and what prints an answer when there is one.
"""

import os
import sys
from copy import copy
from functools import cache
from importlib import import_module
from typing import Any

from typer.main import get_command, get_command_name

from tuner.cli import begin, evaluate, read, tune, vehicle
from tuner.cli.app import CODE, app, with_code_first
from tuner.extension import extensions
from tuner.text.errors import guarded, leave, seldom_collected
from tuner.text.signals import end_at_interrupts

FAMILIES = (begin, tune, read, evaluate, vehicle)
"""Modules of the core whose import registers their commands."""
for module in filter(None, (entry.command_module for entry in extensions().values())):
    import_module(module)


def main() -> None:
    """Entry point of the console script."""
    # Matrices here are small: more threads of a linear algebra library would only spin, for 0.3 s of a run.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Nobody's plugin is to check our documents: pydantic would read what every installed package offers, for 0.02 s.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Before and after the command's own work.
    end_at_interrupts()
    with seldom_collected():
        leave(guarded(_invoke))


def _invoke() -> Any:
    # A width of 0, which some programs without a terminal hand on, is none: nothing at all would fit.
    if not os.environ.get("COLUMNS", "1").strip("0"):
        del os.environ["COLUMNS"]
    arguments = with_code_first(sys.argv[1:])
    return commands(named_command(arguments))(arguments, prog_name="tuner")


def named_command(arguments: list[str]) -> str:
    """Return the name of the command of a line, "" without one.

    Every --code stands before it.
    """
    rest = iter(arguments)
    for argument in rest:
        if argument == CODE:
            next(rest, None)
        elif not argument.startswith("-"):
            return argument
    return ""


@cache
def commands(name: str) -> Any:
    """Return the application with one command, with all for an unused name.

    To build all takes 10 ms.
    """
    part = copy(app)
    part.registered_commands = [
        entry
        for entry in app.registered_commands
        if name == (entry.name or get_command_name(getattr(entry.callback, "__name__", "")))
    ]
    return get_command(part if part.registered_commands else app)
