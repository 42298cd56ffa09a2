"""How errors reach the user: one message, exit code 2, no traceback unless asked for."""

import sys
from collections.abc import Callable
from typing import Any

from plant.errors import ToolError
from tuner.cli.inert_stream import inert_streams

USER_ERROR = 2
INTERRUPTED = 130


def guarded(run: Callable[[], Any]) -> int:
    """Run the command line and return its exit code; --debug anywhere lets the traceback through."""
    debug = "--debug" in sys.argv
    if debug:
        sys.argv.remove("--debug")
    with inert_streams():
        return _guarded(run, debug)


def _guarded(run: Callable[[], Any], debug: bool) -> int:
    try:
        return int(run() or 0)
    except ToolError as error:
        if debug:
            raise
        print(f"Error: {error}", file=sys.stderr)
        return USER_ERROR
    except OSError as error:
        # Files are the only things outside this process that the tool touches: a full disk, a folder without permission.
        if debug:
            raise
        where = f"{error.filename}: " if error.filename else ""
        print(f"Error: {where}{error.strerror or error}; what was written so far is kept", file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        print("Interrupted; what was written so far is kept. `tuner resume RESULTS` goes on with it.", file=sys.stderr)
        return INTERRUPTED
