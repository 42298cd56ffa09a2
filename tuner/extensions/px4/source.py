"""Parameter files of PX4 as a source."""

import re

from plant.input_files import ReadableFile
from tuner.extensions.autopilots.assembly import LOOPS
from tuner.extensions.autopilots.parameters import stated
from tuner.extensions.autopilots.sources import EVERY, PERIOD, Source, fixed_options, major_minor
from tuner.extensions.logs.ulog import is_ulog
from tuner.extensions.px4.facts import px4_facts
from tuner.extensions.px4.map import PX4
from tuner.extensions.px4.other_files import plain, resolved
from tuner.extensions.px4.text import WHAT, read_params


def _options(file: ReadableFile) -> dict[str, str]:
    """Return the options of a PX4 file with its loop rate."""
    rate = _values(file).get("IMU_GYRO_RATEMAX", 0.0)
    options = fixed_options("px4", LOOPS.name, PERIOD, EVERY)(file)
    return options | ({PERIOD: f"{1.0 / rate:.9g}"} if rate > 0.0 else {})


def _values(file: ReadableFile) -> dict[str, float]:
    return read_params(plain(file))


def _version(file: ReadableFile) -> str | None:
    return major_minor(stated(plain(file), WHAT).version)


SOURCE = Source(
    re.compile(r"#\s*Stack:\s*PX4.*|\d+\t\d+\t(MC|MPC|IMU|CA|SYS|THR)_\w+\t\S+\t[69]\s*|\s*param set(-default)? .*"),
    re.compile(r"\d+\t\d+\t(\w+)\t.*"),
    _values,
    _version,
    _options,
    re.compile(r"MC_(ROLL|PITCH|YAW)RATE_[PID]"),
    # Gains of the velocity loops are in units of acceleration since 1.11.
    versions=((1, 11), (1, 17)),
    scaling=frozenset(PX4.scaling),
    resolved=resolved,
    is_log=is_ulog,
    rank=2,
    facts=px4_facts,
)
