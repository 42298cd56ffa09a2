"""Places of errors: inner tables with the path to them, `[airframe]` in front of `name` and the file in front of both."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from pydantic_core import ErrorDetails

from plant.errors import InputError


class Fault(NamedTuple):
    """A problem that pydantic found: its type, the steps to the value, the value, pydantic's message and what that names."""

    kind: str
    place: tuple[int | str, ...]
    given: Any
    message: str
    context: dict[str, Any]

    @classmethod
    def of(cls, found: ErrorDetails) -> "Fault":
        """Return a problem as pydantic tells it."""
        return cls(found["type"], found["loc"], found["input"], found["msg"], found.get("ctx", {}))


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
