"""Readers of flight logs, told apart by content; `read_log` is the door to all of them."""

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from plant.errors import InputError
from plant.input_files import given_content
from tuner.extensions.logs.betaflight import is_betaflight, read_betaflight
from tuner.extensions.logs.blackbox import is_blackbox, read_blackbox
from tuner.extensions.logs.crazyflie import is_crazyflie, read_crazyflie
from tuner.extensions.logs.csv_table import read_csv
from tuner.extensions.logs.dataflash import is_dataflash, read_dataflash
from tuner.extensions.logs.flight_log import MAX_LOG_BYTES, FlightLog, checked
from tuner.extensions.logs.mapping import read_mapping
from tuner.extensions.logs.ulog import is_ulog, read_ulog


class Reader(NamedTuple):
    """A kind of log: its name, whether a content is one, and what makes a log of content, file name and digest."""

    kind: str
    knows: Callable[[bytes], bool]
    read: Callable[[bytes, str, str], FlightLog]


READERS = (
    Reader("Crazyflie SD card", is_crazyflie, read_crazyflie),
    Reader("PX4 ULog", is_ulog, read_ulog),
    Reader("ArduPilot DataFlash (.bin)", is_dataflash, read_dataflash),
    # Its head holds the words by which a table is known.
    Reader("Betaflight blackbox (.bbl)", is_blackbox, read_blackbox),
    Reader("Betaflight blackbox as CSV", is_betaflight, read_betaflight),
)
"""Every kind of log that tells itself by its content; the first that knows it reads it."""
OTHERS = "CSV with a mapping"


def read_log(file: Path, mapping: Path | None = None) -> FlightLog:
    """Return the flight log in a file; mapping: the TOML file that says what the columns of a CSV table are.

    Raises InputError, a line that names the file, where it cannot be opened, is no log that is known, or is damaged beyond use.
    """
    content = given_content(file, "give a flight log", MAX_LOG_BYTES)
    digest = sha256(content).hexdigest()
    if mapping is not None:
        return checked(read_csv(content, str(file), digest, read_mapping(mapping)))
    reader = next((entry for entry in READERS if entry.knows(content)), None)
    if reader is None:
        kinds = ", ".join([*[entry.kind for entry in READERS], OTHERS])
        what = "is empty" if not content else "is no log that is known"
        raise InputError(f"{what}; allowed: {kinds}", file=file)
    return checked(reader.read(content, str(file), digest))
