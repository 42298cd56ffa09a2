"""Written lines against the table of settings of a firmware's command line."""

import re
from pathlib import Path

import pytest

import tuner
from tuner.extensions.betaflight_adrc.settings import BUILDS, SETTINGS, default_tune

LINES = [
    line.split() for line in Path(__file__).with_name("command_line.txt").read_text().splitlines() if line[0] != "#"
]
TABLE = {name: (default, allowed) for name, default, *allowed in LINES}
BUILD = BUILDS["pr"]


def test_every_setting_has_the_range_of_the_command_line():
    assert {name for name in SETTINGS if BUILD.has(name)} == set(TABLE) - {"pid_type"}
    for name, setting in SETTINGS.items():
        if BUILD.has(name):
            default, allowed = TABLE[name]
            ends = [f"{setting.low:.0f}", f"{setting.high:.0f}"]
            assert (setting.text(default_tune(BUILD).numbers[name]), list(setting.words) or ends) == (default, allowed)


def accepts(name, value):
    """Return True for a line that the command line stores."""
    allowed = TABLE[name][1]
    return int(allowed[0]) <= int(value) <= int(allowed[1]) if allowed[0].isdigit() else value in allowed


@pytest.mark.parametrize("end", ["low", "high"])
def test_every_written_line_is_accepted(vehicle, end):
    """All settings of the build are changed to an end of their range, so that the file has a line for each."""
    settings = {name: setting.text(getattr(setting, end)) for name, setting in SETTINGS.items() if BUILD.has(name)}
    lines = tuner.adrc(vehicle(), build="pr", settings=settings).lines
    written = dict(re.findall(r"^set (\S+) = (\S+)$", lines, re.MULTILINE))
    assert set(written) == set(TABLE) and all(accepts(name, value) for name, value in written.items())
