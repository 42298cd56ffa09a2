"""The Crazyflie's controllers as a process, called at every control instant (`stabilizer.py`).

It is called and answers, so it is in step by itself: it has no clock, and equal flights are equal to the last bit.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from plant.errors import shortened
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.autopilots.process import FirmwareProcess
from tuner.extensions.crazyflie.stabilizer import ATTITUDE_RATE, IN, OUT

# The part of a refusal that an error shows.
MAX_MESSAGE = 300
STABILIZER = Path(__file__).with_name("stabilizer.py")
# Counts of full thrust; places of the motors 1 to 4 at our rotors: front left, front right, rear left, rear right.
FULL, PLACES = 65535.0, (3, 0, 2, 1)
# Control periods in which it is turned by hand, and in which it is then held until the gyro's filter has settled.
TURNS, STILL = 100, 50
# Outputs of roll, pitch and yaw's control as sums over the counts of motors 1 to 4.
ROLL, PITCH, YAW = (-0.5, -0.5, 0.5, 0.5), (0.5, -0.5, -0.5, 0.5), (-0.25, 0.25, -0.25, 0.25)


class CrazyflieBoard:
    """A board of the seam `tuner.extensions.autopilots.firmware.Board`."""

    def __init__(self, interpreter: Path, module: Path, parameters: Mapping[str, float]) -> None:
        """Power up with parameters; raises InputError where the module is none or refuses one."""
        self._parameters = parameters
        command = [str(interpreter), str(STABILIZER), str(module.parent.resolve())]
        self._process = FirmwareProcess(command, module, f", under {interpreter}")
        try:
            self._process.send(json.dumps(dict(parameters)).encode("ascii") + b"\n")
            self._check(self._process.receive_line())
        except BaseException:
            self.close()
            raise

    def arm(self, initial: Instant, throttle: float, held: tuple[float, float, float, float]) -> None:
        """Reset it without thrust, then turn it until its integrals hold it; InputError where its motors turn."""
        still = replace(initial, rate=(0.0, 0.0, 0.0), tilt=initial.angles[:2], yaw=initial.angles[2])
        commands = self.step(still, 0.0)
        if any(commands):
            given = ", ".join(f"{command:g}" for command in commands)
            raise self._process.error(f"turns its motors at no thrust ({given})")
        turned = replace(still, rate=turning(held, self._parameters))
        for begin in (*[turned] * TURNS, *[still] * STILL):
            self.step(begin, throttle)

    def step(self, setpoints: Instant, throttle: float) -> tuple[float, float, float, float]:
        """Run one control period."""
        self._process.send(IN.pack(*frame(setpoints, throttle)))
        counts = OUT.unpack(self._process.receive(OUT.size))
        first, second, third, fourth = (counts[place] / FULL for place in PLACES)
        return first, second, third, fourth

    def close(self) -> None:
        """Power off."""
        self._process.close()

    def _check(self, answer: bytes) -> None:
        try:
            refused = str(json.loads(answer)["refused"])
        except (ValueError, KeyError, TypeError):
            raise self._process.error(f"answers with nonsense ({shortened(repr(answer))})") from None
        if refused:
            raise self._process.error(f"cannot be run: {shortened(' '.join(refused.split()), MAX_MESSAGE)}")


def turning(held: tuple[float, float, float, float], parameters: Mapping[str, float]) -> tuple[float, float, float]:
    """Return rates [rad/s, our axes] whose integrals hold motor commands after `TURNS` periods."""
    counts = [FULL * held[place] for place in np.argsort(PLACES)]
    filled = []
    for axis, mixing, sign in zip(("roll", "pitch", "yaw"), (ROLL, PITCH, YAW), (-1.0, 1.0, -1.0), strict=True):
        output, gain = float(np.dot(mixing, counts)), parameters.get(f"pid_rate.{axis}_ki", 0.0)
        filled.append(sign * math.radians(output / gain) * ATTITUDE_RATE / TURNS if gain else 0.0)
    return filled[0], filled[1], filled[2]


def frame(setpoints: Instant, throttle: float) -> tuple[float, ...]:
    """Return an instant in the firmware's units: degrees, angles of pitch nose up, gyro about our axes, thrust in counts."""
    x, y, z = map(math.degrees, setpoints.rate)
    roll, pitch, yaw = map(math.degrees, setpoints.angles)
    to_roll, to_pitch, to_yaw = map(math.degrees, (*setpoints.tilt, setpoints.yaw))
    return x, y, z, roll, -pitch, yaw, to_roll, -to_pitch, to_yaw, FULL * throttle
