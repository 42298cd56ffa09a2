"""Files of JSON lines: only ever appended, and on the disk before anything goes on.

A process that is killed leaves at most a part of a line at the end of a file, which is not read and which the next writer
takes away.
"""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import ValidationError

from plant.errors import StoreError
from plant.input_files import MAX_TABLE_BYTES, read_input
from plant.output_files import open_in_place
from tuner.store.document import DocumentPart

Line = TypeVar("Line", bound=DocumentPart)


class JsonLines(Generic[Line]):
    """The lines of a file, each a part of a document; StoreError where the file cannot be used.

    Args:
        file: Path of the file, which need not exist.
        kind: Model of a line.
        advice: Remedy for a damaged line, as a sentence's end.
    """

    def __init__(self, file: Path, kind: type[Line], advice: str) -> None:
        self._file, self._kind, self._advice = file, kind, advice
        self._intact_bytes = 0
        self.lines = self._read()

    def append(self, lines: Sequence[Line]) -> None:
        """Write lines behind those of the file."""
        if not lines:
            return
        content = "".join(line_of(entry) + "\n" for entry in lines).encode()
        try:
            with open_in_place(self._file, "ab") as out:
                # What a killed process left of a line would spoil the next one.
                out.truncate(self._intact_bytes)
                out.write(content)
                out.flush()
                os.fsync(out.fileno())
        except OSError as error:
            raise StoreError(
                f"{self._file} cannot be written ({error.strerror}); earlier results are saved. Free disk space and retry"
            ) from error
        self._intact_bytes += len(content)
        self.lines += lines

    def _read(self) -> list[Line]:
        try:
            content = read_input(self._file, MAX_TABLE_BYTES)
        except FileNotFoundError:
            return []
        except OSError as error:
            raise StoreError(
                f"{self._file} cannot be read ({error.strerror}); make the folder's files yours again (chown)"
            ) from error
        self._intact_bytes = content.rfind(b"\n") + 1
        lines = content[: self._intact_bytes].splitlines()
        return [self._parsed(number, line) for number, line in enumerate(lines, start=1)]

    def _parsed(self, number: int, line: bytes) -> Line:
        try:
            return self._kind.model_validate_json(line)
        except ValidationError:
            raise StoreError(f"{self._file}: line {number} is damaged; {self._advice}") from None


def line_of(entry: DocumentPart) -> str:
    """Return a line of JSON, without its end."""
    return json.dumps(entry.content(), allow_nan=False)
