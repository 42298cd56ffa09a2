"""Python processes of this tool's own: they import from the folders of their parent and from no other place.

A file typing.py, numpy.py or sitecustomize.py of the working folder, of PYTHONPATH or of the user's own site would run in place
of the module of that name. `-I` leaves all three out.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

HOME = Path(__file__).resolve().parents[1]
"""Folder of the packages."""
SAFE_PATH = "PYTHONSAFEPATH"


def python_command(program: str, *arguments: str, excluded: Path | None = None) -> list[str]:
    """Return the command of an isolated Python.

    Args:
        program: text of the program.
        arguments: arguments of the program.
        excluded: folder from which nothing is imported.
    """
    folders = [folder for folder in sys.path if os.path.isabs(folder)]
    if excluded is not None:
        folders = [folder for folder in folders if not is_same(folder, excluded)]
    # Behind all others, so that a file beside the packages of a clone replaces no module either.
    folders += [] if str(HOME) in folders else [str(HOME)]
    return [sys.executable, "-I", "-c", f"import sys; sys.path[:] = {folders!a}; {program}", *arguments]


@contextmanager
def without_working_folder() -> Iterator[None]:
    """Keep the working folder off the search path of libraries' processes."""
    before = os.environ.get(SAFE_PATH)
    os.environ[SAFE_PATH] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[SAFE_PATH]
        else:
            os.environ[SAFE_PATH] = before


def is_same(folder: str, other: Path) -> bool:
    """Return True for two names of one folder, links resolved."""
    return os.path.realpath(folder) == os.path.realpath(other)
