"""Parameter files of ArduPilot as a source."""

import re

from plant.input_files import ReadableFile
from tuner.exchange.target import FIRMWARE
from tuner.extensions.ardupilot.facts import ardupilot_facts
from tuner.extensions.ardupilot.other_files import plain, resolved
from tuner.extensions.ardupilot.ranges import DIALECTS
from tuner.extensions.ardupilot.text import WHAT, read_param
from tuner.extensions.autopilots.assembly import LOOPS, NATIVE_LOOPS
from tuner.extensions.autopilots.parameters import stated
from tuner.extensions.autopilots.sources import Source, major_minor
from tuner.extensions.logs.dataflash import is_dataflash


def _values(file: ReadableFile) -> dict[str, float]:
    return read_param(plain(file))


def _version(file: ReadableFile) -> str | None:
    return major_minor(stated(plain(file), WHAT).version)


def _options(file: ReadableFile) -> dict[str, str]:
    """Return the dialect of a file: that of its version, or else of its names."""
    version = _version(file)
    later = set(DIALECTS["4.7"].roles.values()) - set(DIALECTS["4.6"].roles.values())
    if version is not None:
        is_later = tuple(map(int, version.split("."))) >= (4, 7)
    else:
        is_later = bool(later & set(_values(file)))
    return {FIRMWARE: "4.7" if is_later else "4.6", LOOPS.name: NATIVE_LOOPS}


SOURCE = Source(
    re.compile(
        r"#\s*Stack:\s*ArduPilot.*|(\d+\t\d+\t)?(ATC|PSC|MOT|INS|RATE|STB|FRAME|SCHED|ANGLE)_?\w*[\s,]\s*[-+0-9.].*"
    ),
    re.compile(r"\s*(?:\d+\t\d+\t(\w+)\t|([A-Z]\w*)[\s,=]).*"),
    _values,
    _version,
    _options,
    re.compile(r"(ATC_RAT|RATE)_(RLL|PIT|YAW)_[PID]"),
    versions=((3, 3), (4, 8)),
    scaling=frozenset(name for dialect in DIALECTS.values() for name in dialect.scaling),
    resolved=resolved,
    is_log=is_dataflash,
    # Its lines fit parameters of PX4 too.
    rank=3,
    facts=ardupilot_facts,
)
