"""Written lines against the table of settings of a firmware's command line."""

import re
from pathlib import Path

import pytest

import tuner
from tuner.extensions.betaflight_adrc.settings import BUILDS, SETTINGS, default_tune

KEPT = {"pr": "command_line.txt", "pr-august": "august_command_line.txt"}


def kept_table(name):
    """Return default and allowed values by setting."""
    lines = [line.split() for line in Path(__file__).with_name(name).read_text().splitlines() if line[0] != "#"]
    return {name: (default, allowed) for name, default, *allowed in lines}


TABLES = {build: kept_table(name) for build, name in KEPT.items()}
EVERY_BUILD = pytest.mark.parametrize("build", TABLES)


@EVERY_BUILD
def test_every_setting_has_the_range_of_the_command_line(build):
    table, known = TABLES[build], BUILDS[build]
    assert {name for name in SETTINGS if known.has(name)} == set(table) - {"pid_type"}
    for name, setting in SETTINGS.items():
        if known.has(name):
            default, allowed = table[name]
            ends = [f"{setting.low:.0f}", f"{setting.high:.0f}"]
            assert (setting.text(default_tune(known).numbers[name]), list(setting.words) or ends) == (default, allowed)


def accepts(table, name, value):
    """Return True for a line that the command line stores."""
    allowed = table[name][1]
    return int(allowed[0]) <= int(value) <= int(allowed[1]) if allowed[0].isdigit() else value in allowed


@EVERY_BUILD
@pytest.mark.parametrize("end", ["low", "high"])
def test_every_written_line_is_accepted(vehicle, build, end):
    """All settings of the build are changed to an end of their range, so that the file has a line for each."""
    table, known = TABLES[build], BUILDS[build]
    file = vehicle()
    if not known.has("adrc_b0_law"):
        file.write_text(file.read_text().replace("set adrc_b0_law = FIXED\n", ""))
    settings = {name: setting.text(getattr(setting, end)) for name, setting in SETTINGS.items() if known.has(name)}
    lines = tuner.adrc(file, build=build, settings=settings).lines
    written = dict(re.findall(r"^set (\S+) = (\S+)$", lines, re.MULTILINE))
    assert set(written) == set(table) and all(accepts(table, name, value) for name, value in written.items())
