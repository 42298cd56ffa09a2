"""The command line: a command is its signature, one call of the library, one print; nothing numerical lives here.

The families of commands import nothing heavy, because `tuner --help` must not wait for compilers and plotting libraries: the
library's names load when a command calls them, and what prints an answer when there is one.
"""

import os
import signal
import sys
from typing import Any

from tuner.cli import begin, judge, read, trials, tune, vehicle
from tuner.cli.app import app
from tuner.text.errors import guarded

FAMILIES = (begin, tune, trials, read, judge, vehicle)
"""Modules whose import registers their commands."""


def main() -> None:
    """Entry point of the console script."""
    # Before and after the command's own work, Ctrl-C ends the process without a word.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(guarded(_invoke))


def _invoke() -> Any:
    # A width of 0, which some programs without a terminal hand on, is none: nothing at all would fit.
    if not os.environ.get("COLUMNS", "1").strip("0"):
        del os.environ["COLUMNS"]
    return app(prog_name="tuner")
