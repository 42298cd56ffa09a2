"""Messages of an autopilot's log on the times of the gyro; each kind of message arrives at different times."""

import numpy as np

from plant.errors import InputError
from tuner.logs.flight_log import FRD_TO_FLU, Array, FlightLog

# Motors 3, 1, 2, 4 of PX4's and ArduPilot's quad x: front left, front right, rear left, rear right.
MOTORS = (2, 0, 1, 3)
SLOWEST_COMMANDS = 50.0
"""Rate of logged motor commands below which they say too little of what the motors were told [Hz]."""


def joined(
    name: str,
    kind: str,
    digest: str,
    time: Array,
    gyro: Array,
    acceleration: Array,
    command_time: Array,
    command: Array,
) -> FlightLog:
    """Return a log on the gyro's times [s], commands held; gyro and acceleration (n, 3) are in FRD, command (m, 4) in our order.

    Raises InputError where either is missing.
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
    held = np.searchsorted(command_time, time[inside], side="right") - 1
    return FlightLog(
        name,
        kind,
        digest,
        time[inside],
        gyro[inside] * FRD_TO_FLU,
        acceleration[inside] * FRD_TO_FLU,
        command[held],
        notes,
    )
