"""Order of motors and signs of sensors in packets, learnt by pulses.

Releases differ: up to 2026.6 the first motor of the firmware is the last of the packet, later it is the first; a build for Gazebo
reads the yaw rate with the other sign. A pulse of a body rate shows which motors work against it.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError
from tuner.extensions.autopilots.instants import Instant

Array = NDArray[np.float64]
Motors = tuple[float, float, float, float]
STILL: Motors = (0.0, 0.0, 0.0, 0.0)
"""Motors at rest."""
EXPECTED_VERSIONS = "Betaflight 2025.12 to 2026.12"
"""Versions whose packets are known."""
PULSE_RATE = 2.0
"""Pulse of a body rate [rad/s]."""
PULSE_TILT = 0.15
"""Pulse of the attitude [rad]."""
PULSE_DURATION = 0.02
"""Length of a pulse [s]: filters of the gyro lag by some 2 ms."""
REST_DURATION = 0.3
"""Length of the rest before a pulse [s]."""
THROTTLE = 0.5
"""Throttle at which motors answer in both directions."""
MIN_ANSWER = 0.005
"""Smallest mean answer of the motors, whose commands have steps of 0.001."""
MIN_TILTING = 0.05
"""Smallest answer to tilt over that to the rate of pitch: 0.29 with the default level strength, 0.02 where it is estimated."""
BUILD_ADVICE = "build it as docs/how_to/confirm.md says"
ESTIMATOR_ADVICE = (
    "its attitude is its own estimate, not the one it is given: build it with -DSITL_ATTITUDE_DIRECT in EXTRA_FLAGS, as "
    "docs/how_to/confirm.md says"
)
RATE_ADVICE = (
    "its loops run slower than the control period: build it with -DVIRTUAL_GYRO_SAMPLE_RATE_HZ=8000 in EXTRA_FLAGS, as "
    "docs/how_to/confirm.md says"
)
N_FIRST_STEPS = 8
"""Control periods at the begin of a pulse: without filters motors answer the rate within 3 of them, the attitude in each."""
CORNERS = {(-1, 1): 0, (1, 1): 1, (-1, -1): 2, (1, -1): 3}
"""Signs of a motor's answers to rolling right and pitching nose down -> front left, front right, rear left, rear right."""


class Wiring(NamedTuple):
    """Packets of a build.

    Attributes:
        places: Places in the packet of motors at our rotors: front left, front right, rear left, rear right.
        yaw: Sign of our yaw rate in the state.
    """

    places: tuple[int, int, int, int]
    yaw: float = -1.0


PACKET_WIRING = Wiring((0, 1, 2, 3))
"""Motors in the order of the packet, before it is known."""


class Probed(Protocol):
    """A board that is powered up."""

    def arm(self, initial: Instant, throttle: float, held: Motors) -> None:
        """Arm it."""
        ...

    def step(self, setpoints: Instant, throttle: float) -> Motors:
        """Run one control period."""
        ...

    def close(self) -> None:
        """Power off."""
        ...


def learn_wiring(power_up: Callable[[Wiring], Probed], spins: Sequence[float], period: float, binary: Path) -> Wiring:
    """Return the wiring of a build; raises InputError where its answers fit none.

    Args:
        power_up: Starts a board.
        spins: Signs of the rotors' reaction torques about z up.
        period: Control period [s].
        binary: Program, for messages.
    """
    board = power_up(PACKET_WIRING)
    try:
        board.arm(_instant(), THROTTLE, STILL)
        answers = [
            _answer(board, pulse, period)
            for pulse in (
                _instant(rate=(PULSE_RATE, 0.0, 0.0)),
                _instant(rate=(0.0, PULSE_RATE, 0.0)),
                _instant(rate=(0.0, 0.0, PULSE_RATE)),
                _instant(angles=(0.0, PULSE_TILT, 0.0)),
            )
        ]
    finally:
        board.close()
    roll, pitch, yaw, tilt = (answer[-1] for answer in answers)
    corners = [CORNERS[int(np.sign(a)), int(np.sign(b))] if a * b else -1 for a, b in zip(roll, pitch, strict=True)]
    if sorted(corners) != [0, 1, 2, 3] or min(np.abs(roll).mean(), np.abs(pitch).mean()) < MIN_ANSWER:
        raise InputError(
            f"its motors answer pulses of roll and pitch as those of no X: {_shown(roll)} and {_shown(pitch)}; expected is "
            f"{EXPECTED_VERSIONS}: {BUILD_ADVICE}",
            file=binary,
        )
    first, second, third, fourth = (corners.index(corner) for corner in range(4))
    places = (first, second, third, fourth)
    if not any(_has_successive_changes(answer) for answer in answers):
        raise InputError(RATE_ADVICE, file=binary)
    if float(tilt @ np.sign(pitch)) < MIN_TILTING * float(np.abs(pitch).sum()):
        raise InputError(ESTIMATOR_ADVICE, file=binary)
    # The torque of yaw is against its rate; where it is with it, the build reads the rate with the other sign.
    return Wiring(places, -1.0 if float(yaw[list(places)] @ spins) <= 0.0 else 1.0)


def _instant(
    angles: tuple[float, float, float] = (0.0, 0.0, 0.0), rate: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> Instant:
    return Instant(angles, rate, (0.0, 0.0), 0.0, 0.0)


def _answer(board: Probed, pulse: Instant, period: float) -> Array:
    """Return the change of the motors (n, 4) in a pulse, after a rest."""
    before = STILL
    for _ in range(round(REST_DURATION / period)):
        before = board.step(_instant(), THROTTLE)
    pulsed = [board.step(pulse, THROTTLE) for _ in range(max(round(PULSE_DURATION / period), N_FIRST_STEPS))]
    return np.array([before, *pulsed]) - np.array(before)


def _has_successive_changes(answer: Array) -> bool:
    """Whether motors change in two successive periods; slower loops skip some."""
    changed = np.any(np.diff(answer[: N_FIRST_STEPS + 1], axis=0), axis=1)
    return bool(np.any(changed[1:] & changed[:-1]))


def _shown(answer: Array) -> str:
    return ", ".join(f"{value:+.3f}" for value in answer.tolist())
