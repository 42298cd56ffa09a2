"""The command line: a command is its signature, one call of the library, one print; nothing numerical lives here.

The families of commands import nothing heavy, because `tuner --help` must not wait for compilers and plotting libraries: the
library's names load when a command calls them, and what prints an answer when there is one.
"""

import os
import sys
from importlib import import_module
from typing import Any

from tuner.cli import begin, evaluate, read, tune, vehicle
from tuner.cli.app import app, with_code_first
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
    return app(with_code_first(sys.argv[1:]), prog_name="tuner")
