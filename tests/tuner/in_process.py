"""The command line in this process: as fast as a call, with the exit code and the streams of the console script."""

import sys

import pytest

from tuner.cli.main import _invoke
from tuner.text.errors import guarded


def tuner(monkeypatch, capsys, *arguments):
    """Run a command as `main` does and return exit code, standard output and standard error."""
    monkeypatch.setattr(sys, "argv", ["tuner", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        sys.exit(guarded(_invoke))
    said = capsys.readouterr()
    return ended.value.code or 0, said.out, said.err
