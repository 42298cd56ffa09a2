"""The Crazyflie's own controllers as a process that is asked at every control instant (`stabilizer.py`).

It is called and answers, so it is in step by itself: it has no clock, and equal flights are equal to the last bit.
"""

import json
import math
import socket
import subprocess
from collections.abc import Mapping
from pathlib import Path

from plant.backends.instants import Instant
from plant.errors import InputError, shortened
from tuner.engines.firmware.crazyflie.stabilizer import IN, OUT

# Longest wait for an answer [s], and for the end of a program that has closed its line [s]; longest first answer [bytes].
PATIENCE, ENDING, LONGEST = 20.0, 0.5, 10_000
STABILIZER = Path(__file__).with_name("stabilizer.py")
# Counts of full thrust; places of the motors 1 to 4 at our rotors: front left, front right, rear left, rear right.
FULL, PLACES = 65535.0, (3, 0, 2, 1)
LEVEL = Instant((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0)
BUILT = "docs/how_to/confirm.md says how to build it"


class CrazyflieBoard:
    """A board of the seam `tuner.engines.firmware.firmware.Board`."""

    def __init__(self, interpreter: Path, module: Path, parameters: Mapping[str, float]) -> None:
        """Power up with parameters; raises InputError where the module is none or refuses one."""
        self._module = module
        self._line, theirs = socket.socketpair()
        self._line.settimeout(PATIENCE)
        with theirs:
            command = [str(interpreter), str(STABILIZER), str(module.parent.resolve())]
            try:
                self._process = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=subprocess.DEVNULL)
            except OSError as error:
                self._line.close()
                raise InputError(f"cannot be run: {error.strerror}", file=interpreter, key="--binary") from None
        try:
            self._say(json.dumps(dict(parameters)).encode("ascii") + b"\n")
            self._check(self._hear_line())
        except BaseException:
            self.close()
            raise

    def arm(self, throttle: float) -> None:  # noqa: ARG002
        """Let it stand level without thrust, which resets its integrals; raises InputError where motors turn."""
        found = self.step(LEVEL, 0.0)
        if any(found):
            given = ", ".join(f"{command:g}" for command in found)
            raise self._wrong(f"turns its motors at no thrust ({given})")

    def step(self, asked: Instant, throttle: float) -> tuple[float, float, float, float]:
        """Run one control period."""
        self._say(IN.pack(*frame(asked, throttle)))
        found = OUT.unpack(self._hear(OUT.size))
        first, second, third, fourth = (found[place] / FULL for place in PLACES)
        return first, second, third, fourth

    def close(self) -> None:
        """Power off."""
        self._process.kill()
        self._process.wait()
        self._line.close()

    def _check(self, answer: bytes) -> None:
        try:
            refused = str(json.loads(answer)["refused"])
        except (ValueError, KeyError, TypeError):
            raise self._wrong(f"answers with nonsense ({shortened(repr(answer))})") from None
        if refused:
            raise self._wrong(f"cannot be run: {shortened(' '.join(refused.split()))}")

    def _say(self, content: bytes) -> None:
        try:
            self._line.sendall(content)
        except OSError:
            raise self._silent() from None

    def _hear_line(self) -> bytes:
        heard = b""
        while not heard.endswith(b"\n") and len(heard) < LONGEST:
            heard += self._hear(1)
        return heard

    def _hear(self, size: int) -> bytes:
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

    def _silent(self) -> InputError:
        try:
            return self._wrong(f"ended by itself, with exit code {self._process.wait(ENDING)}")
        except subprocess.TimeoutExpired:
            return self._wrong(f"does not answer within {PATIENCE:g} s")

    def _wrong(self, said: str) -> InputError:
        return InputError(f"{said}; {BUILT}", file=self._module, key="--binary")


def frame(asked: Instant, throttle: float) -> tuple[float, ...]:
    """Return an instant in the firmware's units: degrees, angles of pitch nose up, gyro about our axes, thrust in counts."""
    x, y, z = map(math.degrees, asked.rate)
    roll, pitch, yaw = map(math.degrees, asked.angles)
    to_roll, to_pitch, to_yaw = map(math.degrees, (*asked.tilt, asked.yaw))
    return x, y, z, roll, -pitch, yaw, to_roll, -to_pitch, to_yaw, FULL * throttle
