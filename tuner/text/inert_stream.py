"""The streams of the command line: escape sequences and marks of direction in what is printed come out as their escapes.

Content of a file, a title or its name could otherwise move the cursor, colour or hide the screen, or turn its direction. JSON
stays JSON: the escapes are those that JSON has. Colours and progress bars of our own are rich's, which writes to the stream
behind (`tuner.cli.terminal`). Letters that the encoding of a stream lacks come out as escapes too, so a text of any language
passes through any pipe.
"""

import codecs
import io
import json
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

from plant.texts import inert

ESCAPED = "tuner.escaped"
"""Name of the error handler of encodings."""


def escape_unencodable(error: UnicodeError) -> tuple[str, int]:
    """Replace letters that an encoding lacks by their JSON escapes: a handler as of `codecs.register_error`."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return json.dumps(error.object[error.start : error.end])[1:-1], error.end


codecs.register_error(ESCAPED, escape_unencodable)


@contextmanager
def inert_streams() -> Iterator[None]:
    """Make inert what is printed inside; no letter of it ends in a UnicodeEncodeError."""
    plain = sys.stdout, sys.stderr
    for stream in plain:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=ESCAPED)
    sys.stdout, sys.stderr = (cast(TextIO, InertStream(stream)) for stream in plain)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = plain


class InertStream:
    """A text stream that makes inert what is written to it; everything else is that of the stream behind."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        # Where rich finds the stream for what it has made itself.
        self.rich_proxied_file = stream

    def write(self, text: str) -> int:
        """Write a text; return its length."""
        self._stream.write(inert(text))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write texts one after the other."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)
