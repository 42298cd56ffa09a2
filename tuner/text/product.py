"""The project's name in formats of files; files of its former name are read as those of today."""

from pydantic import BeforeValidator

NAME, FORMER_NAME = "gainproof", "holdfast"
"""The name, and that until version 0.2."""


def current_format(name: object) -> object:
    """Return the name of a format under the project's name of today; anything else unchanged."""
    is_former = isinstance(name, str) and name.startswith(f"{FORMER_NAME}-")
    return f"{NAME}{str(name).removeprefix(FORMER_NAME)}" if is_former else name


READ_FORMER = BeforeValidator(current_format)
