"""A firmware's control libraries as a process, called at every control instant (`protocol.hpp`)."""

import struct
from collections.abc import Callable, Mapping
from functools import partial
from math import atan2, cos, hypot, sin, tan
from pathlib import Path

from plant.errors import shortened
from tuner.extensions.autopilots.firmware import Bench, Commands
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.autopilots.process import FirmwareProcess

PowerUp = Callable[[], "LibraryBoard"]
FRAME, MOTORS = struct.Struct("<16d"), struct.Struct("<4d")
NOTHING = (0.0, 0.0, 0.0, 0.0)
# The part of a refusal that an error shows.
MAX_MESSAGE = 300


class LibraryBoard:
    """A board of the seam `tuner.extensions.autopilots.firmware.Board`."""

    def __init__(self, program: Path, parameters: Mapping[str, float]) -> None:
        """Power up with parameters; raises InputError where the program is none or refuses one."""
        self._process = FirmwareProcess([str(program.resolve())], program)
        try:
            lines = [f"{name} {value!r}\n" for name, value in parameters.items()]
            self._process.send("".join([*lines, "\n"]).encode("ascii"))
            refused = self._process.receive_line().decode("utf-8", "replace").strip()
            if refused:
                raise self._process.error(f"cannot be run: {shortened(refused, MAX_MESSAGE)}")
        except BaseException:
            self.close()
            raise

    def arm(self, initial: Instant, throttle: float, held: Commands) -> None:
        """Settle its filters and fill its integrals with what holds the vehicle."""
        self._fly(initial, throttle, 1.0, held)

    def step(self, setpoints: Instant, throttle: float) -> Commands:
        """Run one control period."""
        return self._fly(setpoints, throttle, 0.0, NOTHING)

    def close(self) -> None:
        """Power off."""
        self._process.close()

    def _fly(self, setpoints: Instant, throttle: float, arms: float, held: Commands) -> Commands:
        self._process.send(FRAME.pack(*frame(setpoints, throttle), arms, *held))
        first, second, third, fourth = MOTORS.unpack(self._process.receive(MOTORS.size))
        return first, second, third, fourth


def installer(parameters_of: Callable[[Bench, bytes], dict[str, float]]) -> Callable[[Bench, bytes], PowerUp]:
    """Return the install function of a firmware from that of its parameters."""

    def install(bench: Bench, content: bytes) -> PowerUp:
        power_up = partial(LibraryBoard, bench.binary, parameters_of(bench, content))
        power_up().close()
        return power_up

    return install


def frame(setpoints: Instant, throttle: float) -> tuple[float, ...]:
    """Return an instant in body axes x forward, y right, z down."""
    turned = (setpoints.rate, setpoints.angles, (*tilt_at_goal(setpoints), setpoints.yaw))
    return (*(value for x, y, z in turned for value in (x, -y, -z)), -setpoints.yaw_rate, throttle)


def tilt_at_goal(setpoints: Instant) -> tuple[float, float]:
    """Return roll and pitch [rad] at the heading of the set point.

    The thrust keeps the direction that it has with the tilt of the set point at the measured heading.
    """
    roll, pitch = setpoints.tilt
    ahead, left = tan(pitch), -tan(roll) / cos(pitch)
    turn = setpoints.angles[2] - setpoints.yaw
    ahead, left = ahead * cos(turn) - left * sin(turn), ahead * sin(turn) + left * cos(turn)
    return atan2(-left, hypot(ahead, 1.0)), atan2(ahead, 1.0)
