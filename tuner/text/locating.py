"""Errors of inner tables with the path to them: `[airframe]` in front of `name`, the file in front of both."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from plant.errors import InputError


@contextmanager
def located(path: Path | None, key: str) -> Iterator[None]:
    """Put a table in front of the key of an error raised inside, and name the file; None leaves the file to an outer one."""
    try:
        yield
    except InputError as error:
        if error.file is not None:
            raise
        inner = error.key or ""
        joined = f"{key}.{inner}" if key and inner else key or inner
        raise moved(error, path, joined) from None


def moved(error: InputError, path: Path | None, key: str) -> InputError:
    """Return the error as one of this file and key."""
    copy = type(error).__new__(type(error))
    InputError.__init__(copy, error.message, file=path, key=key or None)
    return copy
