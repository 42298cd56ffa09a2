"""Context of a metric besides the meters: intended duration of the flight, its targets and its end."""

from dataclasses import dataclass
from math import pi
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.cascade import POSITION_AXES

ROTORS = 4
COMPLETED = 0
"""The status of a flight that reached its end."""


class Bounds(Protocol):
    """Bounds that no completed flight exceeds; from these follows how much a failed one costs.

    command_peak: largest |command|, travel: furthest that the commands, summed over inputs, move in a control period, effort:
    largest sum of squared departures of the commands; all in the scale that commands are counted in.
    """

    @property
    def command_peak(self) -> float: ...  # noqa: D102

    @property
    def travel(self) -> float: ...  # noqa: D102

    @property
    def effort(self) -> float: ...  # noqa: D102

    def error(self, axis: str) -> float:
        """Return the largest |e| of an axis, in its unit."""
        ...


@dataclass(frozen=True)
class MetricLimits:
    """Bounds of the flights of a quadrotor, see `Bounds`.

    Attributes:
        position_error: |e| of x, y and z above which a flight ends [m].
        command_peak: largest rotor command that the actuator accepts, in hover thrusts (the smallest is at least
            0).
        angle: largest |e| of roll, pitch and yaw [rad].
    """

    position_error: float
    command_peak: float
    angle: float = pi

    @property
    def travel(self) -> float:
        """Four rotors, each from 0 to the peak or back."""
        return ROTORS * self.command_peak

    @property
    def effort(self) -> float:
        """Four rotors, each at 0 or at the peak; hover is 1."""
        return ROTORS * max(self.command_peak - 1.0, 1.0) ** 2

    def error(self, axis: str) -> float:
        """Return the largest |e| of an axis [m] or [rad]."""
        return self.position_error if axis in POSITION_AXES else self.angle


@dataclass(frozen=True)
class FlightContext:
    """Flights that share a scenario's plan.

    Attributes:
        duration: N h, planned length [s].
        h: control period [s].
        targets: step levels and windows per axis; a field may be an array that broadcasts against the flights.
        status (...): 0 where the flight completed, else why it did not.
        end_time (...): when the flight ended [s], the duration where it completed.
        limits: see `Bounds`.
    """

    duration: float
    h: float
    targets: Any
    status: NDArray[np.integer[Any]]
    end_time: NDArray[np.float64]
    limits: Bounds

    @property
    def periods(self) -> int:
        """Number of control instants N of a completed flight."""
        return round(self.duration / self.h)
