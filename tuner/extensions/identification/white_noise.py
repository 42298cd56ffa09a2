"""White noise of sensors in a log.

From third differences, in which motion hardly counts.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.logs.flight_log import FlightLog

Array = NDArray[np.float64]


def gyro_noise(logs: Sequence[FlightLog]) -> list[float]:
    """Return the RMS (3,) of the gyro's white noise [rad/s]."""
    return white_noise([log.gyro for log in logs])


def white_noise(series: Sequence[Array]) -> list[float]:
    """Return the RMS (k,) of the white noise in series (n, k): from third differences, in which motion hardly counts."""
    third = np.concatenate([np.diff(part, n=3, axis=0) for part in series])
    # The median leaves shocks out; 20 is the sum of the squares of 1, 3, 3 and 1.
    return (1.4826 * np.median(np.abs(third), axis=0) / np.sqrt(20.0)).tolist()


def gyro_density(logs: Sequence[FlightLog]) -> float:
    """Return the amplitude density of the gyro's white noise [rad/s/sqrt(Hz)].

    It is the RMS of three axes, as logged: a low-pass before the log hides a part of it.
    """
    power = np.mean([np.square(gyro_noise([log])) * 2.0 * log.period for log in logs])
    return float(np.sqrt(power))
