"""QGroundControl's parameter file `.params`: five columns with tabs, vehicle, component, name, value, MAV_PARAM_TYPE.

mavlink/qgroundcontrol, src/FactSystem/ParameterManager.cc. QGroundControl ignores lines that have not exactly five columns, and
refuses the file where the vehicle differs.
"""

import re
from collections.abc import Mapping, Sequence

from plant.errors import InputError
from plant.input_files import ReadableFile
from tuner.extensions.autopilots import parameters
from tuner.extensions.autopilots.frames import check_px4_frame

VERSION = "1.16"
WHAT = "a .params file of QGroundControl with parameters of PX4"
REAL, INTEGER = "9", "6"
NAME = re.compile(r"[A-Z][A-Z0-9_]{0,15}")


def write_params(values: Mapping[str, float], vehicle: int, comments: Sequence[str]) -> bytes:
    """Return the content of a file with REAL32 parameters."""
    head = [
        f"# Onboard parameters for Vehicle {vehicle}",
        "#",
        "# Stack: PX4 Pro",
        "# Vehicle: Multi-Rotor",
        f"# Version: {VERSION}.0",
        "#",
        *(f"# {comment}" for comment in comments),
        "#",
        "# Vehicle-Id Component-Id Name Value Type",
    ]
    rows = [f"{vehicle}\t1\t{name}\t{parameters.positional(value)}\t{REAL}" for name, value in values.items()]
    return parameters.as_bytes([*head, *rows])


def read_params(file: ReadableFile) -> dict[str, float]:
    """Return the parameters of the first vehicle of a file; raises InputError naming file and parameter."""
    parameters.check_stack(file, WHAT, "PX4")
    values: dict[str, float] = {}
    vehicles: set[str] = set()
    for number, line in enumerate(parameters.read_lines(file, WHAT), start=1):
        if not line.strip() or line.startswith("#"):
            continue
        cells = line.split("\t")
        if len(cells) != 5 or not NAME.fullmatch(cells[2]) or cells[4].strip() not in (REAL, INTEGER):
            message = "must be five columns with tabs: vehicle, component, name, value, 6 (INT32) or 9 (REAL32)"
            raise InputError(f"{message}; give {WHAT}", file=file, key=f"line {number}")
        vehicles.add(cells[0])
        value = parameters.read_number(cells[3].strip(), cells[2], file)
        parameters.enter(values, cells[2], parameters.single(value) if cells[4].strip() == REAL else value, file)
    if len(vehicles) > 1:
        message = f"holds vehicles {', '.join(sorted(vehicles))}; give a file of one vehicle"
        raise InputError(message, file=file)
    if not values:
        raise InputError(f"holds no parameter; give {WHAT}", file=file)
    check_px4_frame(values, file)
    return values
