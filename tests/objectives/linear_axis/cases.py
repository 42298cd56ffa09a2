"""Axes that the tests of certificates share: the Hummingbird's rotors at 250 Hz with one period of computing."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.linear_axis.channel_model import AxisLoop, RotorLag
from plant.laws import hybrid, ladrc, pid

Array = NDArray[np.float64]

ROTORS = RotorLag(0.02, 0.006)
LADRC = AxisLoop("ladrc", ladrc.Gains(6.0, 1.0, 10.0), ROTORS)
PID = AxisLoop("pid", pid.Gains(60.0, 60.0, 14.0, 0.005), ROTORS)
HYBRID = AxisLoop("hybrid", hybrid.Gains(10.0, 5.0, 6.0, 5.0, 0.1), ROTORS)


def transfer(part: tuple[Array, Array, Array], s: complex) -> complex:
    """Return c (s - a)^-1 b."""
    a, b, c = part
    return complex((c @ np.linalg.solve(s * np.eye(len(a)) - a, b)).item())


def is_negative(matrix: Any) -> bool:
    return bool(np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).max(axis=0) < 0.0)
