"""Betaflight's simulator build as a process in lockstep: it runs one control period for each state that it is sent.

A small library of ours is loaded before the program (lockstep.c): it hands it sockets that lead here alone, and a clock that
stands still until a state has arrived. So equal flights do not depend on how fast or busy the machine is; docs/how_to/confirm.md
says how often they were equal to the last bit.
"""

import math
import os
import shutil
import socket
import struct
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from plant.errors import InputError
from plant.own_code import refuse_program
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.autopilots.process import BINARY
from tuner.extensions.betaflight.wiring import EXPECTED_VERSIONS, Wiring

# Longest wait for an answer [s].
PATIENCE = 20.0
# Longest wait for the end of a program that has closed its sockets [s].
ENDING = 0.5
# Simulated time before arming and after it, until filters and mixer have settled [s]; throttle that is low for sure [us].
WAKING, SETTLING, LOW = 3.0, 0.2, 950
# Longest time between packets of the sticks [s]: without them releases from 2026.12 on count the link as lost.
LINK = 0.01
# State: time, rates, acceleration, attitude w x y z, velocity, position, pressure. The time stands still: from its progress the
# program would guess how fast simulated time goes, and round.
STATE, CHANNELS, MOTORS = struct.Struct("<18d"), struct.Struct("<d16H"), struct.Struct("<4f")
AT_REST, NOWHERE, PRESSURE = (0.0, 0.0, -9.80665), (0.0,) * 6, 101325.0
MIDDLE, HALF, MAX_PULSE, ON, OFF = 1500, 500.0, 2000, 2000, 1000
LEVEL = Instant((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0)


@dataclass(frozen=True)
class Sticks:
    """Setpoints at full deflection: tilt [deg], yaw rate [deg/s]."""

    tilt: float
    yaw_rate: float

    def channels(self, setpoints: Instant, throttle: float) -> tuple[int, int, int, int]:
        """Return roll, pitch, throttle and yaw [us]; right, nose down and clockwise are positive."""
        roll, pitch = (self._stick(math.degrees(angle) / self.tilt) for angle in setpoints.tilt)
        yaw = self._stick(-math.degrees(setpoints.yaw) / self.yaw_rate)
        return roll, pitch, min(1000 + round(1000.0 * throttle), MAX_PULSE), yaw

    @staticmethod
    def _stick(share: float) -> int:
        return MIDDLE + round(HALF * min(max(share, -1.0), 1.0))


class BetaflightBoard:
    """A board of the seam `tuner.extensions.autopilots.firmware.Board`."""

    def __init__(
        self, binary: Path, folder: Path, shim: Path, sticks: Sticks, control_period: float, wiring: Wiring
    ) -> None:
        """Power up with a copy of the settings in a folder; raises InputError where nothing answers."""
        self._wiring = wiring
        self._binary, self._sticks, self._period = binary, sticks, control_period
        self._last: tuple[int, ...] = ()
        self._repeated, self._unsent = max(round(LINK / control_period), 1), 0
        self._process: subprocess.Popen[bytes] | None = None
        self._workspace = tempfile.TemporaryDirectory(prefix="gainproof-")
        pairs = [socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in range(3)]
        self._state, self._sent, self._motors = (ours for ours, _ in pairs)
        theirs = [end for _, end in pairs]
        try:
            shutil.copy(folder / "eeprom.bin", self._workspace.name)
            self._process = powered_up(binary, Path(self._workspace.name), shim, self._places(theirs), theirs)
            for end in theirs:
                end.close()
            self._answer()
        except BaseException:
            self.close()
            raise
        finally:
            for end in theirs:
                end.close()

    def _places(self, theirs: list[socket.socket]) -> dict[str, str]:
        for end in (self._state, self._sent, self._motors):
            end.settimeout(PATIENCE)
        names = ("LOCKSTEP_STATE", "LOCKSTEP_STICKS", "LOCKSTEP_MOTORS")
        places = {name: str(end.fileno()) for name, end in zip(names, theirs, strict=True)}
        return {**places, "LOCKSTEP_PERIOD": str(round(1e9 * self._period))}

    def arm(self, initial: Instant, throttle: float, held: tuple[float, float, float, float]) -> None:  # noqa: ARG002
        """Wait until sensors are calibrated, arm level and let settle; raises InputError where it does not arm."""
        motors = (0.0, 0.0, 0.0, 0.0)
        for low, switch, duration in ((True, OFF, WAKING), (True, ON, SETTLING), (False, ON, SETTLING)):
            for _ in range(round(duration / self._period)):
                sticks = self._sticks.channels(LEVEL, throttle)
                motors = self._step(LEVEL, (*sticks[:2], LOW if low else sticks[2], sticks[3], switch, ON))
        if not min(motors) > 0.0:
            raise InputError(
                f"Betaflight does not arm: its motors stand still at hover throttle; expected is {EXPECTED_VERSIONS}",
                file=self._binary,
            )

    def step(self, setpoints: Instant, throttle: float) -> tuple[float, float, float, float]:
        """Run one control period."""
        return self._step(setpoints, (*self._sticks.channels(setpoints, throttle), ON, ON))

    def close(self) -> None:
        """Power off."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        for end in (self._state, self._sent, self._motors):
            end.close()
        self._workspace.cleanup()

    def _step(self, setpoints: Instant, channels: tuple[int, ...]) -> tuple[float, float, float, float]:
        try:
            self._unsent += 1
            if channels != self._last or self._unsent >= self._repeated:
                self._sent.send(CHANNELS.pack(0.0, *channels, *(OFF,) * (16 - len(channels))))
                self._last, self._unsent = channels, 0
            self._state.send(self._packet(setpoints))
        except OSError:
            raise self._silent() from None
        motors = MOTORS.unpack(self._answer())
        first, second, third, fourth = (motors[place] for place in self._wiring.places)
        return first, second, third, fourth

    def _packet(self, setpoints: Instant) -> bytes:
        x, y, z = setpoints.rate
        rates = (x, -y, self._wiring.yaw * z)
        return STATE.pack(0.0, *rates, *AT_REST, *attitude(setpoints.angles), *NOWHERE, PRESSURE)

    def _answer(self) -> bytes:
        try:
            answer = self._motors.recv(4096)
        except OSError:
            raise self._silent() from None
        if not answer:
            raise self._silent()
        if len(answer) != MOTORS.size:
            raise InputError(
                f"answered with {len(answer)} bytes, four motors are {MOTORS.size}; expected is {EXPECTED_VERSIONS}",
                file=self._binary,
            )
        return answer

    def _silent(self) -> InputError:
        code = None if self._process is None else self._ended(self._process)
        reason = f"does not answer within {PATIENCE:g} s" if code is None else f"ended by itself, with exit code {code}"
        return InputError(
            f"{reason}; expected is {EXPECTED_VERSIONS}, and docs/how_to/confirm.md says how to build it",
            file=self._binary,
        )

    @staticmethod
    def _ended(process: "subprocess.Popen[bytes]") -> int | None:
        """Return the exit code of a process, None where it goes on; its sockets are closed before."""
        try:
            return process.wait(ENDING)
        except subprocess.TimeoutExpired:
            return None


def attitude(angles: tuple[float, float, float]) -> tuple[float, float, float, float]:
    """Return the quaternion w, x, y, z of our roll, pitch, yaw [rad]; nose up and clockwise are positive."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(0.5 * angle), math.sin(0.5 * angle)) for angle in angles)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        -(cr * sp * cy + sr * cp * sy),
        -(cr * cp * sy - sr * sp * cy),
    )


def shim_in(folder: Path) -> Path:
    """Compile the library that keeps step into a folder; raises InputError where there is no compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise InputError("no C compiler (cc, gcc) is installed; it builds the firmware and what keeps step with it")
    shim = folder / "lockstep.so"
    if any(mark in str(shim) for mark in " :"):
        raise InputError(
            "has a blank or a colon in its path, which ends LD_PRELOAD; set TMPDIR to another", file=folder
        )
    source = Path(__file__).with_name("lockstep.c")
    command = [compiler, "-shared", "-fPIC", "-O2", "-o", str(shim), str(source), "-ldl", "-lpthread"]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace", check=False)
    if done.returncode != 0:
        raise InputError(f"the C compiler refuses lockstep.c: {done.stderr.strip().splitlines()[-1:]}", file=compiler)
    return shim


def powered_up(
    binary: Path, folder: Path, shim: Path, places: dict[str, str], sockets: list[socket.socket]
) -> subprocess.Popen[bytes]:
    """Start the program in a folder, with sockets of ours; raises InputError where it cannot be run."""
    refuse_program(binary, BINARY)
    before = " ".join(filter(None, (str(shim), os.environ.get("LD_PRELOAD"))))
    try:
        return subprocess.Popen(
            [str(binary.resolve())],
            cwd=folder,
            env={**os.environ, "LD_PRELOAD": before, **places},
            pass_fds=[end.fileno() for end in sockets],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    except OSError as error:
        raise InputError(f"cannot be run: {error.strerror}", file=binary, key=BINARY) from None
