"""A firmware's program that answers over its standard input and output: it is called, so it is in step by itself."""

import socket
import subprocess
from collections.abc import Sequence
from pathlib import Path

from plant.errors import InputError
from plant.own_code import refuse_program

# Longest waits for an answer and for the end of a process that has closed its line [s]; longest line [bytes].
PATIENCE, ENDING, LONGEST = 20.0, 0.5, 10_000
BINARY = "--binary"
BUILT = "docs/how_to/confirm.md says how to build it"


class FirmwareProcess:
    """A process that is given bytes and answers with bytes; every problem is an InputError about one file."""

    def __init__(self, command: Sequence[str], file: Path, under: str = "") -> None:
        """Start a command.

        Args:
            command: Program and arguments.
            file: Subject of problems.
            under: Words on what runs it.
        """
        refuse_program(file, BINARY)
        self._file, self._under = file, under
        self._line, theirs = socket.socketpair()
        self._line.settimeout(PATIENCE)
        with theirs:
            try:
                self._process = subprocess.Popen(
                    command, stdin=theirs.fileno(), stdout=theirs.fileno(), stderr=subprocess.DEVNULL
                )
            except OSError as error:
                self._line.close()
                raise InputError(
                    f"cannot be run: {error.strerror}; {BUILT}", file=Path(command[0]), key=BINARY
                ) from None

    def send(self, content: bytes) -> None:
        """Give it bytes."""
        try:
            self._line.sendall(content)
        except OSError:
            raise self._silent() from None

    def receive(self, size: int) -> bytes:
        """Return so many bytes of its answer."""
        heard = b""
        while len(heard) < size:
            try:
                part = self._line.recv(size - len(heard))
            except OSError:
                raise self._silent() from None
            if not part:
                raise self._silent()
            heard += part
        return heard

    def receive_line(self) -> bytes:
        """Return one line of its answer."""
        heard = b""
        while not heard.endswith(b"\n") and len(heard) < LONGEST:
            heard += self.receive(1)
        return heard

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait()
        self._line.close()

    def error(self, problem: str) -> InputError:
        """Return the error of a problem."""
        return InputError(f"{problem}; {BUILT}", file=self._file, key=BINARY)

    def _silent(self) -> InputError:
        try:
            code = self._process.wait(ENDING)
            return self.error(f"ended by itself, with exit code {code}{self._under}")
        except subprocess.TimeoutExpired:
            return self.error(f"does not answer within {PATIENCE:g} s")
