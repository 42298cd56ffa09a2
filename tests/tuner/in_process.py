"""The command line in this process: as fast as a call, with the exit code and the streams of the console script."""

import contextlib
import io
import os
import signal
import sys
from unittest.mock import patch

import pytest

from tuner.cli.main import _invoke, main
from tuner.text.errors import guarded

WIDTH = 80
"""Columns of the terminal that `called` writes for."""


def tuner(monkeypatch, capsys, *arguments):
    """Run a command as `main` does and return exit code, standard output and standard error."""
    monkeypatch.setattr(sys, "argv", ["tuner", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        sys.exit(guarded(_invoke))
    said = capsys.readouterr()
    return ended.value.code or 0, said.out, said.err


def called(*arguments):
    """Run a command as the console script does, at 80 columns; return exit code, standard output and standard error."""
    said, told, handler = io.StringIO(), io.StringIO(), signal.getsignal(signal.SIGINT)
    terminal = {"COLUMNS": str(WIDTH), "TERM": "dumb", "NO_COLOR": "1"}
    streams = contextlib.redirect_stdout(said), contextlib.redirect_stderr(told)
    try:
        with (
            patch.object(sys, "argv", ["tuner", *map(str, arguments)]),
            patch.dict(os.environ, terminal),
            streams[0],
            streams[1],
        ):
            main()
    except SystemExit as ended:
        return int(ended.code or 0), said.getvalue(), told.getvalue()
    finally:
        signal.signal(signal.SIGINT, handler)
    raise AssertionError("the console script ends by SystemExit")
