"""Logs of PX4 (ULog), read by the package pyulog."""

from contextlib import redirect_stdout
from io import BytesIO, StringIO
from typing import Any

import numpy as np

from plant.errors import InputError, require_package
from tuner.extensions.logs.autopilot import MOTORS, joined
from tuner.extensions.logs.flight_log import Array, FlightLog

MAGIC = b"ULog\x01\x12\x35"
SENSORS = "sensor_combined"
SETPOINTS, AXES = "vehicle_rates_setpoint", ("roll", "pitch", "yaw")
OUTPUTS = {"actuator_motors": ("control", 0.0, 1.0), "actuator_outputs": ("output", 1000.0, 2000.0)}
"""Topics of motor commands -> field, idle and full; the first that is there counts."""


class EndlessError(Exception):
    """A file that the reader goes through again and again."""


class ReadOnce(BytesIO):
    """File for pyulog 1.3 with a bounded number of reads: at a damaged last message it may step back for ever.

    A message of four bytes or more takes two reads, so no sound file asks for more reads than it has bytes.
    """

    def __init__(self, content: bytes) -> None:
        super().__init__(content)
        self._left = len(content)

    def read(self, size: int | None = -1, /) -> bytes:
        """Read as every file; EndlessError after as many reads as there are bytes."""
        self._left -= 1
        if self._left < 0:
            raise EndlessError
        return super().read(size)


def is_ulog(content: bytes) -> bool:
    """Return true for a file that begins as a ULog."""
    return content[: len(MAGIC)] == MAGIC


def read_ulog(content: bytes, name: str, digest: str) -> FlightLog:
    """Return the log; raises InputError where it is damaged or lacks a topic, MissingPackageError without pyulog."""
    require_package("pyulog", "logs", key=name)
    from pyulog import ULog

    try:
        # It prints what it finds damaged.
        with redirect_stdout(StringIO()):
            log = ULog(ReadOnce(content), [SENSORS, SETPOINTS, *OUTPUTS])
        topics = {topic.name: topic.data for topic in reversed(log.data_list) if topic.multi_id == 0}
    except EndlessError:
        raise InputError(
            "is damaged so that reading it does not end; copy it from the vehicle again", file=name
        ) from None
    # The reader meets whatever a damaged file holds, and raises as many kinds of errors.
    except Exception as error:
        raise InputError(f"is no ULog that can be read ({type(error).__name__})", file=name) from None
    sensors = _topic(topics, SENSORS, name)
    chosen = next((topic for topic in OUTPUTS if topic in topics), "actuator_motors")
    outputs = _topic(topics, chosen, name)
    field, idle, full = OUTPUTS[chosen]
    command = (_fields(outputs, [f"{field}[{i}]" for i in MOTORS], name) - idle) / (full - idle)
    return joined(
        name,
        "PX4 ULog",
        digest,
        _time(sensors, name),
        _fields(sensors, [f"gyro_rad[{i}]" for i in range(3)], name),
        _fields(sensors, [f"accelerometer_m_s2[{i}]" for i in range(3)], name),
        _time(outputs, name),
        command,
        _setpoint(topics, name),
    )


def _setpoint(topics: dict[str, Any], name: str) -> Array | None:
    """Return times [s] and setpoints of the rates [rad/s] (k, 4); None without them."""
    topic = topics.get(SETPOINTS, {})
    if not all(field in topic for field in ("timestamp", *AXES)):
        return None
    return np.column_stack([_time(topic, name), _fields(topic, list(AXES), name)])


def _topic(topics: dict[str, Any], topic: str, name: str) -> Any:
    if topic not in topics:
        raise InputError(f"lacks the topic {topic}; log it, at a high rate (SDLOG_PROFILE)", file=name)
    return topics[topic]


def _time(topic: Any, name: str) -> Array:
    return _fields(topic, ["timestamp"], name)[:, 0] * 1e-6


def _fields(topic: Any, fields: list[str], name: str) -> Array:
    missing = [field for field in fields if field not in topic]
    if missing:
        raise InputError(f"lacks the field {missing[0]}; it is damaged or of another format", file=name)
    # A damaged number may be a signalling NaN.
    with np.errstate(invalid="ignore"):
        return np.column_stack([np.asarray(topic[field], float) for field in fields])
