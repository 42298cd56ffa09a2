"""End of a command: its exit code, and one message where it failed; a traceback with --debug or of a defect of the tool."""

import gc
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

from plant.errors import ToolError, one_line
from plant.output_files import write_new_file
from plant.own_code import ANNOUNCEMENTS, place_of_error
from tuner.text.inert_stream import inert_streams
from tuner.text.signals import CRASHED, ENDINGS, SIGNALLED, Interrupted, Signals

BROKEN = 1
"""A limit is broken, or a difference is found: of commands that check something."""
USER_ERROR = 2
"""Exit code where what was given, a file or the disk is in the way."""
NOTHING_FEASIBLE = 3
"""Exit code of a run that came to its end and found no candidate that keeps every limit."""
NO_BASIS = 3
"""Exit code of a judgement that has no basis, so that nothing is judged."""
CLOSED_PIPE = SIGNALLED + 13
"""Exit code after the reader of the output is gone: that of a process that SIGPIPE ended, which Windows lacks."""
DEFECT = f"Error: a defect of the tool ended the command; report the lines above (exit code {CRASHED}, no verdict)"
"""Line below the traceback of an error that is no user's."""
NEW_OBJECTS = 300_000
"""New objects after which circles of garbage are looked for, more than a short run makes; Python's own number is 700."""


class RenamedKeyWarning(FutureWarning):
    """A key under a name that a later version does not read."""


def guarded(run: Callable[[], Any]) -> int:
    """Run the command line and return its exit code; --debug anywhere prints the traceback of an error."""
    debug = "--debug" in sys.argv
    if debug:
        sys.argv.remove("--debug")
    with inert_streams(), warnings_in_lines(), code_announced():
        return _guarded(run, debug)


def leave(code: int) -> NoReturn:
    """End the process; it does not look for circles of garbage once more, which takes 0.7 s after a run."""
    gc.freeze()
    sys.exit(code)


def _guarded(run: Callable[[], Any], debug: bool) -> int:
    signals = Signals()
    try:
        with signals:
            return finished(run)
    except BrokenPipeError:
        let_go_of_output()
        return CLOSED_PIPE
    except BaseException as error:
        # A library may make another error of the signal, a damaged file for instance.
        number = error.number if isinstance(error, Interrupted) else signals.number
        line = message(error, number)
        if line is None and not isinstance(error, Exception):
            raise
        if number is not None:
            ENDINGS.append(error)
        let_go_of_output()
        with suppress(OSError):
            if debug or line is None:
                traceback.print_exception(error)
            if not debug or line is None:
                print(one_line(line or DEFECT), file=sys.stderr)
        if line is None:
            return CRASHED
        return USER_ERROR if number is None else SIGNALLED + number


@contextmanager
def seldom_collected() -> Iterator[None]:
    """Look for circles of garbage after so many new objects; at Python's pace, imports and drawing take a third more time."""
    usual = gc.get_threshold()
    gc.set_threshold(NEW_OBJECTS)
    try:
        yield
    finally:
        gc.set_threshold(*usual)


@contextmanager
def warnings_in_lines() -> Iterator[None]:
    """Print each `RenamedKeyWarning` once, in a line on standard error; a command reads a file several times."""
    usual, shown = warnings.showwarning, set[str]()

    def show(message: Any, category: type[Warning], *rest: Any, **named: Any) -> None:
        if not issubclass(category, RenamedKeyWarning):
            usual(message, category, *rest, **named)
        elif str(message) not in shown:
            shown.add(str(message))
            print(one_line(f"Warning: {message}"), file=sys.stderr)

    warnings.showwarning = show
    try:
        yield
    finally:
        warnings.showwarning = usual


@contextmanager
def code_announced() -> Iterator[None]:
    """Print a line on standard error before a study's code first runs; first for this user."""

    def announce(digest: str, sentence: str) -> None:
        from plant.backends.cache import cache_folder
        from plant.backends.sealed import private_folder

        folder = private_folder(cache_folder() / "code")
        if folder is not None and (folder / digest).exists():
            return
        print(one_line(sentence), file=sys.stderr)
        if folder is not None:
            with suppress(OSError):
                write_new_file(folder / digest, b"")

    ANNOUNCEMENTS.append(announce)
    try:
        yield
    finally:
        ANNOUNCEMENTS.remove(announce)


def finished(run: Callable[[], Any]) -> int:
    """Run to the end and have standard output take everything; return the exit code."""
    try:
        code = run()
    except SystemExit as ended:
        code, cause = ended.code, _swallowed(ended)
        if cause is not None:
            raise cause from None
    sys.stdout.flush()
    return int(code or 0)


def _swallowed(ended: SystemExit) -> Exception | None:
    """Return the error that a library turned into exit code 1.

    rich and click end so where the reader of the output is gone, click at any EOFError too.
    """
    error = ended.__context__
    while error is not None and not isinstance(error, BrokenPipeError | EOFError):
        error = error.__cause__ or error.__context__
    return error


def message(error: BaseException, number: int | None) -> str | None:
    """Return the line about an error, None for a mistake of ours; number: of a signal, where one came before."""
    notes = getattr(error, "__notes__", [])
    if number is not None or isinstance(error, KeyboardInterrupt):
        return f"Interrupted; {notes[-1]}." if notes else "Interrupted."
    if isinstance(error, ToolError):
        return f"Error: {error}"
    if place := place_of_error(error):
        return f"Error: {place}: {type(error).__name__}: {error}; correct this line, or see all of it with --debug"
    if isinstance(error, OSError):
        # Files are the only things outside this process that the tool touches: a full disk, a folder without permission.
        where = f"{error.filename}: " if error.filename else ""
        state = f"earlier results are saved. Free disk space and {notes[-1]}" if notes else "nothing more was written"
        return f"Error: {where}{error.strerror or error}; {state}"
    return None


def let_go_of_output() -> None:
    """Drop output that standard output refuses; the interpreter would fail at it once more when it ends."""
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
