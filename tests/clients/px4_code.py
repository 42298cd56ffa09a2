"""PX4's own rate and attitude control as a library that whoever has it has built. Nothing of it is part of this project.

TUNER_PX4_BUILD names the folder. It holds `libpx4_judge_double.so`, `libpx4_judge_single.so` or both: PX4's rate_control.cpp,
AttitudeControl.cpp, LowPassFilter2p.hpp, NotchFilter.hpp, AlphaFilter.hpp and the two filter functions of
VehicleAngularVelocity.cpp as they stand, the first with every float a double, behind three functions in C:

    int px4_scalar_bytes(void);
    void px4_rate_loop(double rate_hz, const double gains[9], int n, const double rates[n], const double setpoints[n],
                       const int saturated[n], double torque[n]);
    double px4_attitude(int axis, double gain, double angle, double setpoint, double yaw_rate);

gains: p, i, d, ff, i_limit, gyro_cutoff, d_cutoff, notch, notch_width. The filters are settled at rates[0] and step with the
loop; saturated is the sign in which the allocation saturates. The attitude turns about one axis, its weight of yaw is 1.
"""

import ctypes
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]

NAMED = "TUNER_PX4_BUILD"


def _pointer(values: Array) -> Any:
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


class Px4Code:
    """PX4's controllers in one precision; skips the test where they are not built."""

    def __init__(self, precision: str) -> None:
        """Load the library; precision: double or single."""
        folder = os.environ.get(NAMED)
        if folder is None:
            pytest.skip(f"{NAMED} names no folder with PX4's code; tests/clients/px4_code.py says what it has to hold")
        library = Path(folder) / f"libpx4_judge_{precision}.so"
        if not library.exists():
            pytest.skip(f"no {library.name} in {folder}; tests/clients/px4_code.py says what it has to hold")
        self._code: Any = ctypes.CDLL(str(library))
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
