"""Files that hold parameters in another form than a parameter file: flight logs, scripts, files that include others."""

from pathlib import Path
from typing import NamedTuple, TypeVar

from plant.input_files import InputFile
from tuner.extensions.autopilots.parameters import positional
from tuner.extensions.logs.flight_log import MAX_LOG_BYTES
from tuner.extensions.logs.logged_parameters import LoggedParameters
from tuner.text.sentences import first_texts

__all__ = ["MAX_LOG_BYTES", "MAX_NAMES", "Resolved", "log_notes", "plain_file"]
File = TypeVar("File", Path, InputFile, Path | InputFile)
MAX_NAMES = 10
"""Largest number of parameters or lines that a sentence names."""


class Resolved(NamedTuple):
    """The parameters of a file as text, and sentences on it."""

    text: str
    notes: tuple[str, ...] = ()


def plain_file(file: File, resolved: Resolved | None) -> File | InputFile:
    """Return a file with its parameters as text; itself where it is a parameter file."""
    if resolved is None:
        return file
    return InputFile(file.path if isinstance(file, InputFile) else file, resolved.text.encode())


def log_notes(log: LoggedParameters) -> tuple[str, ...]:
    """Return the sentences on the parameters of a log."""
    count = f"Read are {len(log.values):,} parameters of a flight log, as they were when it began."
    if not log.changed:
        return (count,)
    changes = [f"{name} {positional(old)} to {positional(new)}" for name, (old, new) in log.changed.items()]
    return (count, f"Changed during the log, and not read so: {first_texts(changes, MAX_NAMES)}.")
