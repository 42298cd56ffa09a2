"""Context of a metric beside the meters: intended duration of the flight, its targets and its end."""

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plant.targets import Targets

COMPLETED = 0
"""The status of a flight that reached its end."""


@dataclass(frozen=True)
class MetricLimits:
    """Bounds that no completed flight exceeds; from these follows how much a failed one costs.

    position_error: |e| of x, y and z above which a flight ends [m]. command_peak: largest rotor command that the
    actuator accepts, in hover thrusts (the smallest is at least 0). angle: largest |e| of roll, pitch and yaw [rad].
    """

    position_error: float
    command_peak: float
    angle: float = pi


@dataclass(frozen=True)
class FlightContext:
    """Flights that share a scenario's plan.

    duration: N h, planned length [s]. h: control period [s]. targets: step levels and windows per axis; a field may
    be an array that broadcasts against the flights. status (...): 0 where the flight completed, else why it did not.
    end_time (...): when the flight ended [s], the duration where it completed. limits: see `MetricLimits`.
    """

    duration: float
    h: float
    targets: Targets
    status: NDArray[np.integer[Any]]
    end_time: NDArray[np.float64]
    limits: MetricLimits

    @property
    def periods(self) -> int:
        """Number of control instants N of a completed flight."""
        return round(self.duration / self.h)
