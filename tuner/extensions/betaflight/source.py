"""Command lines of Betaflight as a source."""

import re

from plant.input_files import ReadableFile
from tuner.extensions.autopilots.assembly import LOOPS
from tuner.extensions.autopilots.sources import EVERY, PERIOD, PROFILE, Source, Values, fixed_options
from tuner.extensions.betaflight import text
from tuner.extensions.betaflight.commands import loaded_over, read_cli
from tuner.extensions.betaflight.facts import betaflight_facts
from tuner.extensions.betaflight.import_ import renamed
from tuner.extensions.betaflight.map import USUAL
from tuner.extensions.betaflight.native_loops import FOLLOWING, SILENT
from tuner.extensions.betaflight.presets import command_lines, resolved_preset, stated_versions


def _profile(file: ReadableFile) -> int:
    return text.read_selected(file) or 0


def _values(file: ReadableFile) -> Values:
    """Return the settings of the active profile by the names of 2025.12."""
    release = text.read_release(file)
    texts = read_cli(file, _profile(file))
    return renamed(texts, release or USUAL, release is not None, file)


def _version(file: ReadableFile) -> str | None:
    release, versions = text.read_release(file), stated_versions(command_lines(file))
    # A preset for several releases is of none of them alone.
    return None if release is None or len(versions) > 1 else release.name


SOURCE = Source(
    re.compile(r"\s*set\s+[a-z0-9_]+\s*=.*|#\s*Betaflight / .*|#\$ FIRMWARE_VERSION:.*"),
    re.compile(r"\s*set\s+([a-z0-9_]+)\s*=.*"),
    _values,
    _version,
    lambda file: {
        **fixed_options("betaflight", LOOPS.name, PERIOD, EVERY)(file),
        PROFILE: str(_profile(file)),
    },
    re.compile(r"(p|i|d|d_max)_(roll|pitch|yaw)"),
    # d_roll is the lower gain since 2025.12, and the upper one before.
    is_of_known_units=text.states_release,
    wiring=text.read_wiring,
    is_command_line=True,
    left_out=frozenset(SILENT) - set(FOLLOWING.values()),
    loaded_over=loaded_over,
    resolved=resolved_preset,
    rank=1,
    facts=betaflight_facts,
)
