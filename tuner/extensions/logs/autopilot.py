"""Messages of an autopilot's log on the times of the gyro; each kind of message arrives at different times."""

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError
from tuner.extensions.logs.flight_log import FRD_TO_FLU, Array, FlightLog

# Motors 3, 1, 2, 4 of PX4's and ArduPilot's quad x: front left, front right, rear left, rear right.
MOTORS = (2, 0, 1, 3)
SLOWEST_COMMANDS = 50.0
"""Smallest rate [Hz] of logged motor commands from which the commands between them can be reconstructed."""


def joined(
    name: str,
    kind: str,
    digest: str,
    time: Array,
    gyro: Array,
    acceleration: Array,
    command_time: Array,
    command: Array,
    setpoint: Array | None,
) -> FlightLog:
    """Return a log on the gyro's times, commands and setpoints held; InputError where gyro or commands are missing.

    Args:
        name: Name of the file.
        kind: Kind of the log.
        digest: Digest of the file.
        time: Time of the gyro (n,) [s].
        gyro: Body rates (n, 3) [rad/s], FRD.
        acceleration: Specific force (n, 3) [m/s2], FRD.
        command_time: Times (m,) [s].
        command: Command of the motors (m, 4), in our order.
        setpoint: Times [s] and setpoints of the rates [rad/s], FRD (k, 4); None where the log has none.
    """
    for what, series in (("gyro samples", time), ("motor commands", command_time)):
        if len(series) < 2:
            raise InputError(f"has {len(series)} {what}; log the inertial sensors and the motor outputs", file=name)
    rate = 1.0 / max(float(np.median(np.diff(command_time))), 1e-9)
    notes = (
        (f"motor commands at {rate:.0f} Hz only; log them at {SLOWEST_COMMANDS:.0f} Hz or more",)
        if rate < SLOWEST_COMMANDS
        else ()
    )
    inside = (time >= command_time[0]) & (time <= command_time[-1])
    held = _last_before(time[inside], command_time)
    if setpoint is not None and len(setpoint):
        setpoint = setpoint[_last_before(time[inside], setpoint[:, 0]), 1:] * FRD_TO_FLU
    return FlightLog(
        name,
        kind,
        digest,
        time[inside],
        gyro[inside] * FRD_TO_FLU,
        acceleration[inside] * FRD_TO_FLU,
        command[held],
        notes,
        setpoint if setpoint is not None and len(setpoint) else None,
    )


def _last_before(time: Array, of_samples: Array) -> NDArray[np.intp]:
    """Return the index (n,) of the last sample before each time; of the first before all samples."""
    return np.maximum(np.searchsorted(of_samples, time, side="right") - 1, 0)
