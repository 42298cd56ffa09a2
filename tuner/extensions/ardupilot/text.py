"""ArduPilot's parameter file `.param`: one "NAME,VALUE" (Mission Planner) or "NAME VALUE" (MAVProxy) a line; the columns of
QGroundControl are read as well.

Names are at most 16 of A-Z, 0-9 and _. They changed between Copter 4.6 and 4.7, and a vehicle ignores in silence what it does not
know, so a file belongs to a version.

Names and units of Copter before 4.0 are read as the firmware itself turns them into those of 4.0 to 4.6 when it is updated.

Copter::convert_pid_parameters of ArduCopter/Parameters.cpp: rate gains became shares of the whole torque in 3.4 (times 0.9 on
frames X, V and H, 1.27 on others), their limits and the throttle shares of 1, position gains got other names in 3.6, one filter
of a rate loop became two in 4.0.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plant.errors import InputError
from plant.input_files import ReadableFile
from tuner.extensions.autopilots import parameters
from tuner.extensions.autopilots.frames import check_ardupilot_frame

WHAT = "a .param file of ArduPilot Copter"
SEPARATORS = {"comma": ",", "blank": " "}
NAME = re.compile(r"[A-Z][A-Z0-9_]{0,15}")
# The five columns of QGroundControl: vehicle, component, name, value, type.
COLUMNS = re.compile(r"\d{1,3}\t\d{1,3}\t([^\s,]+)\t([^\s,#]+)\t\d{1,2}")
# A value, then what some clients append: a comment, or the "@READONLY" of a full download.
LINE = re.compile(r"([^\s,=]+)[\s,=]+([^\s,#]+)\s*(#.*|@.*)?")


def write_param(values: Mapping[str, float], separator: str, comments: Sequence[str]) -> bytes:
    """Return the content of a file; separator: a key of SEPARATORS."""
    mark = SEPARATORS[separator]
    rows = [f"{name}{mark}{parameters.positional(value)}" for name, value in values.items()]
    return parameters.as_bytes([*(f"# {comment}" for comment in comments), *rows])


def read_param(file: ReadableFile) -> dict[str, float]:
    """Return the parameters of a file; raises InputError naming file and parameter."""
    parameters.check_stack(file, WHAT, "ArduPilot")
    values: dict[str, float] = {}
    for number, line in enumerate(parameters.read_lines(file, WHAT), start=1):
        text = line.strip()
        if not text or text.startswith(("#", "//")):
            continue
        parts = COLUMNS.fullmatch(text) or LINE.fullmatch(text)
        if parts is None or not NAME.fullmatch(parts[1]):
            message = f"must be a name of at most 16 of A-Z, 0-9, _, a comma or blanks, and a number; give {WHAT}"
            raise InputError(message, file=file, key=f"line {number}")
        parameters.enter(values, parts[1], parameters.single(parameters.read_number(parts[2], parts[1], file)), file)
    if not values:
        raise InputError(f"holds no parameter; give {WHAT}", file=file)
    check_ardupilot_frame(values, file)
    return values


# In the version that a record names: the file was of an older one.
OLDER = "older than 4.0"
SHORTS = ("RLL", "PIT", "YAW")
# Frames whose gains fell: X, V and H of FRAME, which was X by default.
CROSSED, USUAL_FRAME = (1.0, 2.0, 3.0), 1.0
CROSSED_SCALE, OTHER_SCALE = 0.9, 1.27
IMAX_SCALE, THROTTLE_SCALE = 1.0 / 4500.0, 0.001


def _renamed() -> dict[str, tuple[str, ...]]:
    """Return old name -> names since 4.0."""
    modern: dict[str, tuple[str, ...]] = {"THR_MID": ("MOT_THST_HOVER",)}
    for short in SHORTS:
        rate = f"ATC_RAT_{short}"
        filters = (f"{rate}_FLTE",) if short == "YAW" else (f"{rate}_FLTD", f"{rate}_FLTT")
        modern |= {f"RATE_{short}_{term}": (f"{rate}_{term}",) for term in ("P", "I", "D", "IMAX")}
        modern |= {f"STB_{short}_P": (f"ATC_ANG_{short}_P",), f"RATE_{short}_FILT_HZ": filters, f"{rate}_FILT": filters}
    for old, new, terms in (
        ("POS_XY", "PSC_POSXY", ("P",)),
        ("POS_Z", "PSC_POSZ", ("P",)),
        ("VEL_XY", "PSC_VELXY", ("P", "I", "IMAX")),
        ("VEL_Z", "PSC_VELZ", ("P",)),
        ("ACCEL_Z", "PSC_ACCZ", ("P", "I", "D", "IMAX")),
    ):
        modern |= {f"{old}_{term}": (f"{new}_{term}",) for term in terms}
    for old, new in (("VEL_XY", "PSC_VELXY"), ("ACCEL_Z", "PSC_ACCZ")):
        modern |= {f"{old}_FILT_HZ": (f"{new}_FLTE",), f"{new}_FILT": (f"{new}_FLTE",)}
    return modern


RENAMED = _renamed()
# Of the same loops in versions whose meaning is not known here.
FOREIGN = re.compile(
    r"(RATE|STB|STAB|HLD_LAT|HLD_LON|LOITER_LAT|LOITER_LON|NAV_LAT|NAV_LON|THR_ALT|THR_RATE|THR_ACCEL|POS|VEL|ACCEL)"
    r"_(.+_)?(P|I|D|IMAX|FILT_HZ)"
)


@dataclass(frozen=True)
class Modern:
    """Values of a parameter file under the names of 4.6.

    Attributes:
        values: Values by the names of 4.6.
        renamed: Old name -> (value, new names).
        unknown: Unsupported old names.
    """

    values: dict[str, float]
    renamed: dict[str, tuple[float, tuple[str, ...]]]
    unknown: tuple[str, ...]


def modernized(values: Mapping[str, float], file: ReadableFile) -> Modern:
    """Return parameters of versions before 4.7 in names and units of 4.6.

    Raises InputError where a parameter stands there under its old and its new name with different values.
    """
    gain = CROSSED_SCALE if values.get("FRAME", USUAL_FRAME) in CROSSED else OTHER_SCALE
    modern = {name: value for name, value in values.items() if name not in RENAMED}
    renamed = {}
    for name in values:
        for new in RENAMED.get(name, ()):
            value = _scale(name, gain) * values[name]
            if modern.setdefault(new, value) != value:
                message = f"stands there as {name} too, which is {value:.9g} in its unit; leave one of the two out"
                raise InputError(message, file=file, key=new)
            renamed[name] = (value, RENAMED[name])
    unknown = tuple(name for name in modern if FOREIGN.fullmatch(name))
    return Modern({name: value for name, value in modern.items() if name not in unknown}, renamed, unknown)


def _scale(name: str, gain: float) -> float:
    """Return the factor from an old parameter to the new; gain: of the rate gains."""
    if name.startswith("RATE_") and name.endswith(("_P", "_I", "_D")):
        return gain
    if name.startswith("RATE_") and name.endswith("_IMAX"):
        return IMAX_SCALE
    return THROTTLE_SCALE if name == "THR_MID" else 1.0
