"""The file that says what the columns of a CSV log are.

    axes = "FLU"
    time = { column = "t", unit = "s" }
    gyro = { columns = ["p", "q", "r"], unit = "deg/s" }
    acceleration = { columns = ["ax", "ay", "az"], unit = "g" }
    command = { columns = ["m1", "m2", "m3", "m4"], idle = 1000, full = 2000 }

    setpoint = { columns = ["sp", "sq", "sr"], unit = "deg/s" }

The motors stand in the order of an airframe: front left, front right, rear left, rear right. Setpoints of the rates may
be left out.
"""

from math import isfinite
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from plant.errors import InputError
from plant.input_files import given_text
from plant.texts import check_texts, toml_table
from tuner.extensions.logs.flight_log import FRD_TO_FLU, STANDARD_GRAVITY, Array, FlightLog
from tuner.text.input_errors import Fault

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
GYRO = {"rad/s": 1.0, "deg/s": np.pi / 180.0}
ACCELERATION = {"m/s2": 1.0, "g": STANDARD_GRAVITY}
AXES = {"FLU": np.ones(3), "FRD": FRD_TO_FLU}
"""Body axes of a log -> factors that make them FLU."""

Three = Annotated[list[str], Field(min_length=3, max_length=3)]
Four = Annotated[list[str], Field(min_length=4, max_length=4)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class TimeColumn(_Strict):
    """Column and unit of the time."""

    column: str
    unit: str = "s"


class Columns(_Strict):
    """Three columns along body axes x, y and z, and their unit."""

    columns: Three
    unit: str


class Commands(_Strict):
    """Columns of the four motor commands; idle, full: values at no and full command."""

    columns: Four
    idle: float = 0.0
    full: float = 1.0


class Mapping(_Strict):
    """The whole file."""

    time: TimeColumn
    gyro: Columns
    acceleration: Columns
    command: Commands
    setpoint: Columns | None = None
    axes: str = "FLU"
    separator: Annotated[str, Field(min_length=1, max_length=1)] = ","

    @property
    def columns(self) -> list[str]:
        """All columns in the order time, gyro, acceleration, command, setpoint."""
        setpoint = [] if self.setpoint is None else self.setpoint.columns
        return [self.time.column, *self.gyro.columns, *self.acceleration.columns, *self.command.columns, *setpoint]

    def log(self, origin: tuple[str, str, str], table: Array) -> FlightLog:
        """Return the log of a table (n, 11 or 14); origin: its name, kind and digest."""
        flip, span = AXES[self.axes], self.command.full - self.command.idle
        return FlightLog(
            *origin,
            table[:, 0] * TIME[self.time.unit],
            table[:, 1:4] * GYRO[self.gyro.unit] * flip,
            table[:, 4:7] * ACCELERATION[self.acceleration.unit] * flip,
            (table[:, 7:11] - self.command.idle) / span,
            setpoint=None if self.setpoint is None else table[:, 11:] * GYRO[self.setpoint.unit] * flip,
        )


def read_mapping(file: Path) -> Mapping:
    """Return the mapping in a TOML file; InputError names file and key."""
    table = toml_table(given_text(file, "give a TOML file"), file)
    check_texts(table, file=file)
    try:
        mapping = Mapping.model_validate(table)
    except ValidationError as error:
        fault = Fault.of(error.errors()[0])
        key = ".".join(map(str, fault.place))
        raise InputError(f"{fault.message}; see docs/log_formats.md for an example", file=file, key=key) from None
    for key, given, allowed in (
        ("axes", mapping.axes, AXES),
        ("time.unit", mapping.time.unit, TIME),
        ("gyro.unit", mapping.gyro.unit, GYRO),
        ("acceleration.unit", mapping.acceleration.unit, ACCELERATION),
        *([] if mapping.setpoint is None else [("setpoint.unit", mapping.setpoint.unit, GYRO)]),
    ):
        if given not in allowed:
            raise InputError(f"given '{given}'; allowed: {', '.join(allowed)}", file=file, key=key)
    span = mapping.command.full - mapping.command.idle
    if not (isfinite(span) and span > 0.0):
        raise InputError(
            f"given {mapping.command.full:g}; it must be above idle, {mapping.command.idle:g}",
            file=file,
            key="command.full",
        )
    return mapping
