"""PX4's own rate and attitude control, called function by function: its sources are compiled as they stand (px4_judge.cpp).

In double precision every float of them is made a double first.
"""

import ctypes
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.clients.firmware_sources import checkout
from tests.tuner.extensions.autopilots.in_double import built_in_double
from tuner.extensions.px4.bench import LIBRARIES

Array = NDArray[np.float64]

JUDGE = replace(LIBRARIES, source=Path(__file__).with_name("px4_judge.cpp"))
SHARED = ("-shared", "-fPIC")
_folder = TemporaryDirectory(prefix="px4-judge-")


@cache
def _library(precision: str) -> Path:
    sources, folder = checkout(LIBRARIES), Path(_folder.name)
    if precision == "double":
        return built_in_double(JUDGE, sources, folder, options=SHARED)
    return JUDGE.compile(sources, folder / "in_single", SHARED)


def _pointer(values: Array) -> Any:
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


class Px4Code:
    """PX4's controllers in one precision; skips the test where there are no sources."""

    def __init__(self, precision: str) -> None:
        """Load the library; precision: double or single."""
        self._code: Any = ctypes.CDLL(str(_library(precision)))
        self._code.px4_attitude.restype = ctypes.c_double
        assert self._code.px4_scalar_bytes() == {"double": 8, "single": 4}[precision]

    def torque(
        self, rate_hz: float, gains: Sequence[float], rates: Array, setpoints: Array, saturated: NDArray[np.intc]
    ) -> Array:
        """Return the normalised torque (n,) for rates and setpoints (n,) [rad/s]."""
        torque = np.empty_like(rates)
        self._code.px4_rate_loop(
            ctypes.c_double(rate_hz),
            (ctypes.c_double * len(gains))(*gains),
            len(rates),
            _pointer(rates),
            _pointer(setpoints),
            saturated.ctypes.data_as(ctypes.POINTER(ctypes.c_int)),
            _pointer(torque),
        )
        return torque

    def rate_setpoint(self, axis: int, gain: float, angle: float, setpoint: float, yaw_rate: float = 0.0) -> float:
        """Return the rate setpoint [rad/s] about an axis for angles [rad]."""
        numbers = map(ctypes.c_double, (gain, angle, setpoint, yaw_rate))
        return self._code.px4_attitude(ctypes.c_int(axis), *numbers)
