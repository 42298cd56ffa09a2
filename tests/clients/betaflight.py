"""Betaflight's firmware, built to run on this machine, and its command line. Nothing of it is part of this project."""

import os
import re
import socket
import subprocess
import time
from pathlib import Path
from typing import Any

from tests.clients import client, program

CLI_PORT = 5761
PROMPT = "\n# "
MARK = "#heard"
# Longest waits for an answer and for the command line [s]; how often to power up: now and then the firmware does not answer.
PATIENCE, BOOT, STARTS = 20.0, 5.0, 6
# Longest waits for more of an answer, and before the command line opens [s].
PAUSE, MOMENT = 0.1, 0.5


class Firmware:
    """A vehicle of which only the command line is used: sockets on the loopback, settings in a folder of its own, killed at the end."""

    def __init__(self, folder: Path) -> None:
        """Build what confines it to the loopback; skips the test where the client is not installed."""
        site = Path(client("betaflight")).parents[1]
        (self.binary,) = site.glob("lib/python*/site-packages/betaflight/firmware/obj/betaflight_*_SITL")
        self.folder = folder
        self.process: Any = None
        self.line: Any = None
        self.shim = folder / "loopback.so"
        source = Path(__file__).with_name("loopback.c")
        subprocess.run(
            [program("gcc"), "-shared", "-fPIC", "-O1", "-o", str(self.shim), str(source), "-ldl"], check=True
        )

    def __enter__(self) -> "Firmware":
        """Power up."""
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        """Power off."""
        self.stop()

    def start(self) -> None:
        """Power up and enter the command line; what was not saved is gone."""
        for _ in range(STARTS):
            self.stop()
            ports = self.folder / "ports.txt"
            ports.unlink(missing_ok=True)
            surroundings = {**os.environ, "LD_PRELOAD": str(self.shim), "LOOPBACK_PORTS": str(ports)}
            self.process = subprocess.Popen(
                [str(self.binary)],
                cwd=self.folder,
                env=surroundings,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            if self._connected(ports) and self._entered():
                return
        raise AssertionError("the firmware's command line does not answer")

    def stop(self) -> None:
        """Power off, without saving."""
        if self.line is not None:
            self.line.close()
        if self.process is not None:
            self.process.kill()
            self.process.wait()
        self.process = self.line = None

    def _connected(self, ports: Path) -> bool:
        """Connect to the port that the command line was given; it listens a moment after it has it."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until and self.process.poll() is None:
            if ports.exists() and (found := re.search(rf"^{CLI_PORT} (\d+)$", ports.read_text(), re.MULTILINE)):
                try:
                    self.line = socket.create_connection(("127.0.0.1", int(found[1])), timeout=PATIENCE)
                except ConnectionRefusedError:
                    pass
                else:
                    return True
            time.sleep(0.02)
        return False

    def _entered(self) -> bool:
        """Ask for the command line until it echoes a comment: a firmware that is still starting drops what comes in, and one that
        has started opens it after a moment in which nothing else comes.
        """
        until, heard = time.monotonic() + BOOT, ""
        while time.monotonic() < until and self.process.poll() is None:
            self.line.sendall(b"#")
            self.line.settimeout(MOMENT)
            heard += self._hear()
            self.line.settimeout(PAUSE)
            self.line.sendall(f"\n{MARK}\n".encode("ascii"))
            heard += self._hear()
            if MARK in heard:
                self.say("")
                return True
        return False

    def _hear(self) -> str:
        try:
            return self.line.recv(65536).decode("ascii", "replace").replace("\r", "")
        except TimeoutError:
            return ""

    def say(self, text: str) -> str:
        """Give one line; the answer, up to the prompt after a comment that follows, or to the restart that a save ends with."""
        self.line.sendall(f"{text}\n{MARK}\n".encode("ascii"))
        heard, until = "", time.monotonic() + PATIENCE
        while not (MARK in heard and heard.endswith(PROMPT)) and time.monotonic() < until:
            part = self._hear()
            heard += part
            if not part and self.process.poll() is not None:
                break
        return heard.partition(f"# {MARK}")[0]

    def load(self, content: bytes) -> str:
        """Give every line of a file, as a person pastes it, and power up again; everything that was answered."""
        heard = []
        for text in content.decode("ascii").splitlines():
            heard.append(self.say(text))
            if self.process.poll() is not None:
                break
        self.start()
        return "".join(heard)

    def prints(self, command: str) -> str:
        """Return what the firmware prints of itself. Its link loses characters of long answers, so two in a row must agree."""
        last = self.say(command)
        for _ in range(20):
            again = self.say(command)
            if again == last:
                return again
            last = again
        raise AssertionError(f"no two answers to '{command}' agree")

    def settings(self, profile: int = 0) -> dict[str, str]:
        """Return every setting as the firmware prints it, those of one PID profile among them."""
        self.say(f"profile {profile}")
        return dict(re.findall(r"^set (\w+) = (.*)$", self.prints("dump"), re.MULTILINE))

    def everything(self) -> str:
        """Return all that the firmware holds, every profile and which is selected."""
        return self.prints("dump all")
