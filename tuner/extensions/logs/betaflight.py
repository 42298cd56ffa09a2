"""Blackbox logs of Betaflight as its decoder writes them as CSV (`blackbox_decode`).

Columns: `time (us)`, `gyroADC[0..2]` in deg/s, `accSmooth[0..2]` in counts, `motor[0..3]`, and `setpoint[0..2]` in deg/s where
they are logged; a unit may stand behind a name in brackets. Gyro and accelerometer turn as in FLU but for the sign of the
accelerometer's x, which nothing here asks.
"""

import re
from collections.abc import Collection

import numpy as np

from plant.errors import InputError
from tuner.extensions.logs.csv_table import header, read_columns
from tuner.extensions.logs.flight_log import STANDARD_GRAVITY, Array, FlightLog
from tuner.extensions.logs.mapping import ACCELERATION, GYRO

SEEN = 4096
# Its motors 4, 2, 3, 1: front left, front right, rear left, rear right.
MOTORS = (3, 1, 2, 0)
COLUMNS = (
    "time",
    *[f"{kind}[{i}]" for kind in ("gyroADC", "accSmooth") for i in range(3)],
    *[f"motor[{i}]" for i in MOTORS],
)
SETPOINTS = tuple(f"setpoint[{i}]" for i in range(3))
COUNTS = (256.0, 512.0, 1024.0, 2048.0, 4096.0, 8192.0)
"""Counts of the accelerometers for 1 g."""
# Idle and full command of motor outputs: DSHOT, and pulses in us.
DSHOT, PULSES = (48.0, 2047.0), (1000.0, 2000.0)


def is_betaflight(content: bytes) -> bool:
    """Return true for a file with the decoder's line of names first."""
    return b"loopIteration" in content[:SEEN] and b"gyroADC[0]" in content[:SEEN]


def read_betaflight(content: bytes, name: str, digest: str) -> FlightLog:
    """Return the log; raises InputError where a column is missing."""
    head = header(content[: 8 * SEEN].decode("utf-8", "replace"), ",")
    names = {re.sub(r" \(.*\)$", "", entry): entry for entry in head}
    units = {key: entry[len(key) :].strip(" ()") for key, entry in names.items()}
    columns = [names[entry] for entry in columns_of(names, name)]
    table = read_columns(content, name, columns)
    acceleration, note = _acceleration(table[:, 4:7], units["accSmooth[0]"], name)
    turning = GYRO.get(units["gyroADC[0]"], GYRO["deg/s"])
    return blackbox_log((name, "Betaflight blackbox as CSV", digest), _in_units(table, turning, acceleration), (note,))


def columns_of(names: Collection[str], name: str) -> list[str]:
    """Return the columns to read, rate setpoints last; InputError without one.

    A log without setpoints is read without them.
    """
    missing = [entry for entry in COLUMNS if entry not in names]
    if missing:
        raise InputError(f"lacks the columns {', '.join(missing)}; log gyro, accelerometer and motors", file=name)
    return [*COLUMNS, *(SETPOINTS if set(SETPOINTS) <= set(names) else ())]


def blackbox_log(origin: tuple[str, str, str], table: Array, notes: tuple[str, ...]) -> FlightLog:
    """Return the log of a table.

    Args:
        origin: Name, kind and digest of the log.
        table: Columns (n, 11 or 14) as of `columns_of` in SI units, motors as they are.
        notes: Assumptions so far.
    """
    command, note = _command(table[:, 7:11])
    setpoint = table[:, 11:14] if table.shape[1] > len(COLUMNS) else None
    return FlightLog(
        *origin, table[:, 0], table[:, 1:4], table[:, 4:7], command, notes=(*notes, note), setpoint=setpoint
    )


def _in_units(table: Array, turning: float, acceleration: Array) -> Array:
    """Return a table in SI units, motors as they are; turning: the unit of rates [rad/s]."""
    return np.column_stack(
        [1e-6 * table[:, 0], turning * table[:, 1:4], acceleration, table[:, 7:11], turning * table[:, 11:]]
    )


def _acceleration(counts: Array, unit: str, name: str) -> tuple[Array, str]:
    if unit in ACCELERATION:
        return counts * ACCELERATION[unit], f"accelerometer in {unit}"
    with np.errstate(over="ignore", invalid="ignore"):
        middle = float(np.nanmedian(np.linalg.norm(counts, axis=1))) if len(counts) else np.nan
    if not (np.isfinite(middle) and middle > 0.0):
        raise InputError("has an accelerometer that is 0 throughout; log accSmooth", file=name)
    one = min(COUNTS, key=lambda entry: abs(np.log(middle / entry)))
    return counts * STANDARD_GRAVITY / one, f"accelerometer taken to count {one:g} for 1 g"


def _command(outputs: Array) -> tuple[Array, str]:
    pulses = bool(len(outputs)) and float(np.nanmin(outputs, initial=np.inf)) >= 900.0
    (idle, full), kind = (PULSES, "pulses of 1000 to 2000 us") if pulses else (DSHOT, "DSHOT of 48 to 2047")
    return (outputs - idle) / (full - idle), f"motors taken as {kind}"
