"""Betaflight's rate controller alone, in lockstep: its sources from the client's package, compiled beside the project."""

import ctypes
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.clients import client, program

Array = NDArray[np.float64]

SOURCES = ("flight/pid.c", "flight/pid_init.c", "common/filter.c", "common/maths.c")
PLACES = ("main", "main/target", "platform/SIMULATOR", "platform/SIMULATOR/include", "platform/SIMULATOR/target/SITL")
SYMBOLS = ("SITL", "TARGET=SITL", '__TARGET__="SITL"', "SIMULATOR_BUILD", "USE_SITL", "FLASH_SIZE=2048", "_GNU_SOURCE")


NEITHER = (30, 0, 1350, 1, 0, 15)
"""Throttle and settings without TPA and without I-term relax."""


class RateController:
    """The controller of three axes; built in a folder, skips the test where the client is not installed."""

    def __init__(self, folder: Path) -> None:
        """Compile."""
        (source,) = Path(client("betaflight")).parents[1].glob("lib/python*/site-packages/betaflight/firmware/src")
        library = folder / "betaflight_pid.so"
        files = [Path(__file__).with_suffix(".c"), *(source / "main" / name for name in SOURCES)]
        command = [program("gcc"), "-shared", "-fPIC", "-O1", "-std=gnu17", "-w", "-Wl,-z,lazy", "-o", str(library)]
        command += [f"-I{source / place}" for place in PLACES] + [f"-D{name}" for name in SYMBOLS]
        subprocess.run([*command, *map(str, files), "-lm"], check=True)
        self._code: Any = ctypes.CDLL(str(library))

    def run(
        self,
        gains: list[int],
        filters: list[int],
        period: int,
        setpoint: Array,
        rate: Array,
        angle: Array | None = None,
        large: Sequence[int] = NEITHER,
    ) -> Array:
        """Return the PID sums (n, 3) of setpoints and rates (n, 3) [deg/s]; with angles (n, 3) [0.1 deg] setpoints of roll and
        pitch are angles [deg].

        gains: P, I, D of roll, pitch and yaw, then the level gain. filters [Hz]: gyro 1 and 2, notch and its cut-off, D 1 and 2,
        yaw. period [us]. large: throttle [%], tpa_rate, tpa_breakpoint, tpa_mode, iterm_relax, iterm_relax_cutoff.
        """
        self._code.betaflight_start(
            *((ctypes.c_int * len(each))(*each) for each in (gains, filters, large)),
            ctypes.c_int(period),
            ctypes.c_int(angle is not None),
        )
        sums, out, numbers = np.empty_like(rate), (ctypes.c_double * 3)(), ctypes.c_double * 3
        angles = np.zeros(rate.shape, dtype=int) if angle is None else angle.astype(int)
        for k in range(len(rate)):
            self._code.betaflight_step(
                numbers(*setpoint[k]), numbers(*rate[k]), (ctypes.c_int * 3)(*angles[k].tolist()), out
            )
            sums[k] = out[:]
        return sums
