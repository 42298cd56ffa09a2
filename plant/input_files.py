"""Reading of files from outside: regular files of a limited size.

A pipe would hang and a device would fill the memory, so what was opened is looked at before anything is read from it; and
opening does not wait, because a pipe may have no writer.
"""

import errno
import json
import os
import stat
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

from plant.errors import InputError

MAX_TEXT_BYTES, MAX_TABLE_BYTES = 2**26, 2**31
"""Largest text file, some ten times the largest in use, and largest table, packed or not [bytes]."""
MAX_JSON_BYTES, MAX_VALUES = 2**23, 200_000
"""Largest JSON text [bytes] and most values in one, fifty times the largest in use: each takes 1 kB while it is checked."""
# A system that lacks the flag has no such pipes either.
_AT_ONCE = getattr(os, "O_NONBLOCK", 0)


@dataclass(frozen=True)
class InputFile:
    """A file that is read once, when its content is first used.

    Attributes:
        path: Path, which messages name.
        held: Content in the place of that at the path, None to read it.
        most: Largest size that is read [bytes].
    """

    path: Path
    held: bytes | None = None
    most: int = MAX_TEXT_BYTES

    @cached_property
    def content(self) -> bytes:
        """Content; raises as `read_input` does."""
        return read_input(self.path, self.most) if self.held is None else self.held

    @property
    def name(self) -> str:
        """Name of the file without its folder."""
        return self.path.name

    def __fspath__(self) -> str:
        return str(self.path)

    def __str__(self) -> str:
        return str(self.path)


ReadableFile = Path | InputFile
"""A file to read, or one that is read once for several readers."""


def read_input(file: ReadableFile, most: int = MAX_TEXT_BYTES) -> bytes:
    """Return the content of a regular file of limited size.

    Raises OSError, with a reason for people, where it cannot be opened, is a folder, a pipe or a device, or is larger.
    """
    if isinstance(file, InputFile):
        _check_size(len(file.content), file.path, most)
        return file.content
    with open(file, "rb", opener=opened_at_once) as source:
        state = os.fstat(source.fileno())
        _check(state, file, most)
        # A read takes as much memory as it may return.
        content = source.read(state.st_size + 1)
        # It may have grown.
        if len(content) > state.st_size:
            content += source.read(most + 1 - len(content))
    _check_size(len(content), file, most)
    return content


def file_sha256(file: ReadableFile, most: int = MAX_TEXT_BYTES) -> str:
    """Return the SHA-256 of a file; raises as `read_input` does."""
    return sha256(read_input(file, most)).hexdigest()


def read_input_text(file: ReadableFile, encoding: str = "utf-8") -> str:
    """Return a text file with its line ends as line feeds; raises as `read_input` does, and UnicodeDecodeError."""
    return read_input(file).decode(encoding).replace("\r\n", "\n").replace("\r", "\n")


def given_content(file: ReadableFile, remedy: str, most: int = MAX_TEXT_BYTES) -> bytes:
    """Return the content of a file that a person named; InputError with a remedy where there is none."""
    try:
        return read_input(file, most)
    except FileNotFoundError:
        raise InputError(f"there is no such file; {remedy}", file=file) from None
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror}); {remedy}", file=file) from None


def given_text(file: ReadableFile, remedy: str) -> str:
    """Return the text in a file that a person named; InputError with a remedy where there is none."""
    try:
        # utf-8-sig: some editors and spreadsheets put a byte order mark in front.
        text = given_content(file, remedy).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"is not UTF-8 text ({error.reason} at byte {error.start}); save it as UTF-8", file=file
        ) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def parse_json(text: str, **options: Any) -> Any:
    """Return the content of a JSON text; ValueError, JSONDecodeError among them, where it is none or is too large or too deep.

    options: as for `json.loads`.
    """
    check_json_size(text)
    try:
        return json.loads(text, **options)
    except RecursionError:
        raise ValueError("a JSON text that is nested too deeply") from None


def check_json_size(text: str) -> None:
    """Raise ValueError for a JSON text larger than any document of the tool."""
    if len(text) > MAX_JSON_BYTES:
        raise ValueError(
            f"a JSON text of {len(text) / 2**20:,.0f} MiB, and at most {MAX_JSON_BYTES / 2**20:,.0f} MiB are read"
        )
    # Every value but the first of its list or object stands behind a comma.
    if sum(map(text.count, ",[{")) > MAX_VALUES:
        raise ValueError(f"a JSON text of more than {MAX_VALUES:,} values, which no document has")


def opened_at_once(file: str, flags: int) -> int:
    """Open a file without waiting for the other end of a pipe: an opener of `open`."""
    return os.open(file, flags | _AT_ONCE)


def _check(state: os.stat_result, file: Path, most: int) -> None:
    if not stat.S_ISREG(state.st_mode):
        kind = "a pipe" if stat.S_ISFIFO(state.st_mode) else "a device or a socket"
        raise OSError(errno.EINVAL, f"it is {kind} and no regular file", str(file))
    _check_size(state.st_size, file, most)


def _check_size(size: int, file: Path, most: int) -> None:
    if size > most:
        reason = f"it has {size / 2**20:,.0f} MiB; at most {most / 2**20:,.0f} MiB are read"
        raise OSError(errno.EFBIG, reason, str(file))
