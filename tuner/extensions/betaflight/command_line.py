"""Betaflight's command line: lines are given to it as a person pastes them, and each must be answered."""

import re
import socket
import time
from contextlib import ExitStack, suppress
from pathlib import Path

from plant.errors import InputError, shortened
from tuner.extensions.betaflight.board import powered_up

PROMPT, MARK = "\n# ", "#heard"
# How often to power up, for now and then it does not answer; longest waits for the command line and for the answer to a line [s].
STARTS, OPENING, PATIENCE = 6, 5.0, 10.0
# Longest waits for more of an answer, and for the command line to open [s]; tries of a line whose answer got lost.
PAUSE, MOMENT, TRIES = 0.1, 0.5, 3
SETTING = re.compile(r"^set (\w+) = (\S+)$")


class CommandLine:
    """The command line of a board that runs in real time; closed, the board is off and keeps what was saved."""

    def __init__(self, binary: Path, folder: Path, shim: Path) -> None:
        """Power up; raises InputError where no command line answers."""
        self._binary, self._folder, self._shim = binary, folder, shim
        self._on = ExitStack()
        try:
            for _ in range(STARTS):
                self._start()
                if self._opened():
                    return
                self.close()
        except BaseException:
            self.close()
            raise
        raise InputError(
            f"no command line answers after {STARTS} starts; docs/how_to/confirm.md says how to build it", file=binary
        )

    def close(self) -> None:
        """Power off."""
        self._on.close()

    def _start(self) -> None:
        with socket.socket() as door:
            door.bind(("127.0.0.1", 0))
            door.listen(1)
            # The program takes connections until there are no more, which must not stop it.
            door.setblocking(False)
            places = {"LOCKSTEP_LINE": str(door.fileno())}
            self._process = powered_up(self._binary, self._folder, self._shim, places, [door])
            self._on.callback(self._process.wait)
            self._on.callback(self._process.kill)
            self._line = self._on.enter_context(socket.create_connection(door.getsockname()))

    def _opened(self) -> bool:
        until, heard = time.monotonic() + OPENING, ""
        with suppress(OSError):
            while time.monotonic() < until and self._process.poll() is None:
                self._line.sendall(b"#")
                heard += self._hear(MOMENT)
                self._line.sendall(f"\n{MARK}\n".encode("ascii"))
                heard += self._hear(PAUSE)
                if MARK in heard:
                    self.say("")
                    return True
        return False

    def _hear(self, wait: float) -> str:
        self._line.settimeout(wait)
        try:
            return self._line.recv(65536).decode("ascii", "replace").replace("\r", "")
        except TimeoutError:
            return ""

    def say(self, text: str) -> str:
        """Give one line; return the answer, up to the prompt, or to the end of a program that restarts after saving."""
        heard, until = "", time.monotonic() + PATIENCE
        with suppress(OSError):
            self._line.sendall(f"{text}\n{MARK}\n".encode("ascii"))
            while not (MARK in heard and heard.endswith(PROMPT)) and time.monotonic() < until:
                part = self._hear(PAUSE)
                heard += part
                if not part and self._process.poll() is not None:
                    break
        return heard.partition(f"# {MARK}")[0]

    @property
    def ended(self) -> bool:
        """Whether the program has ended, as it does after saving."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until and self._process.poll() is None:
            time.sleep(0.02)
        return self._process.poll() is not None


def load(binary: Path, folder: Path, shim: Path, lines: list[str]) -> None:
    """Give every line, the last of which saves; raises InputError naming a line that is refused or not answered."""
    line = CommandLine(binary, folder, shim)
    try:
        for text in (text.strip() for text in lines):
            if text and not text.startswith("#"):
                _give(line, text, binary)
        if not line.ended:
            raise InputError("does not restart after 'save'; nothing is known to be stored", file=binary)
    finally:
        line.close()


def _give(line: CommandLine, text: str, binary: Path) -> None:
    setting = SETTING.match(text)
    for _ in range(TRIES):
        answer = line.say(text)
        if "###" in answer:
            message = " ".join(answer.split("###")[1].split())
            raise InputError(f"refuses '{shortened(text)}': {shortened(message)}", file=binary)
        if setting is None or f"{setting[1]} set to {setting[2]}" in answer:
            return
    raise InputError(f"does not confirm '{shortened(text)}'", file=binary)
