"""Betaflight's command line as a file: `set name = value`, within a PID profile, as `diff` and `dump` print it.

The firmware answers a wrong name or value with a line that begins with ###ERROR and goes on. Within a batch that is still open it
then refuses to save; `batch end` before `save` would clear the error, and half of the settings would be stored.
"""

import re
from collections.abc import Mapping, Sequence

from plant.errors import InputError, UnsupportedVersionError, shortened
from plant.input_files import ReadableFile
from tuner.exchange.target import whole_number
from tuner.extensions.autopilots.parameters import ParameterInfo, as_bytes
from tuner.extensions.betaflight.map import NAMES, RELEASES, Release
from tuner.extensions.betaflight.presets import WHAT, command_lines, stated_versions

PROFILE = re.compile(r"profile\s+([0-9])")
VERSION = re.compile(r"#\s*(\w+) / .*?\s(\d+\.\d+)(?:\.\d+\S*)?\s.*")
# INAV writes no blanks around the first slash; the date tells its line from a remark.
OTHER_VERSION = re.compile(r"#\s*([A-Za-z]\w*)/\S+\s(\d+\.\d+)(?:\.\d+\S*)?\s+[A-Z][a-z]{2}\s+\d+ \d{4}\b.*")
INAV_SETTING = re.compile(r"set\s+((mc|fw)_[pid]_(roll|pitch|yaw)|nav_\w+)\s*=.*")
EXPORTED = re.compile(r"# (For|Rollback to the defaults of) Betaflight \d+\.\d+\b.*")
"""Line of an export, whose names are those of a file that states no release."""
WIRING = re.compile(r"(mixer|map|mmix \d+|resource MOTOR \d+)\s+(\S.*)")
FEATURE = re.compile(r"feature (-?)(3D)")
MIXER = re.compile(r"mixer\s+(\w+)")
PROFILES = 4
# Gains with the same range in every release.
SAME_RANGE = frozenset(name for names in NAMES.values() for name in names[:4])


def profile(options: Mapping[str, str]) -> int:
    """Return the PID profile of the options."""
    return whole_number(options, "profile", 0, PROFILES - 1)


def write_cli(values: Mapping[str, str], profile: int, comments: Sequence[str], selected: int | None = None) -> bytes:
    """Return a file that sets and saves values in a PID profile: all or none.

    selected: the profile that the vehicle flies afterwards, if another one.
    """
    body = (f"set {name} = {value}" for name, value in values.items())
    last = () if selected in (None, profile) else (f"profile {selected}",)
    return as_bytes(
        [*(f"# {comment}" for comment in comments), "batch start", f"profile {profile}", *body, *last, "save"]
    )


def read_release(file: ReadableFile) -> Release | None:
    """Return the release that printed a file, or a preset's newest.

    None where the file states none. Raises InputError for another firmware, UnsupportedVersionError for an unknown release.
    """
    lines = command_lines(file)
    matches = [match for line in lines if (match := VERSION.fullmatch(line) or OTHER_VERSION.fullmatch(line))]
    if not matches and any(INAV_SETTING.fullmatch(line) for line in lines):
        raise _other_firmware("INAV", file)
    if not matches:
        return _preset_release(stated_versions(lines), file)
    firmware, version = matches[0][1], matches[0][2]
    if firmware != "Betaflight":
        raise _other_firmware(f"{firmware} {version}", file)
    if version not in RELEASES:
        message = f"was printed by {firmware} {version}; known are Betaflight {', '.join(RELEASES)}"
        raise UnsupportedVersionError(message, file=file, key="version")
    return RELEASES[version]


def _preset_release(versions: Sequence[str], file: ReadableFile) -> Release | None:
    """Return the newest supported release of a preset; None where it states none."""
    supported = [release for name, release in RELEASES.items() if name in versions]
    if versions and not supported:
        message = f"is a preset for Betaflight {', '.join(versions)}; known are Betaflight {', '.join(RELEASES)}"
        raise UnsupportedVersionError(shortened(message), file=file, key="FIRMWARE_VERSION")
    return supported[-1] if supported else None


def _other_firmware(name: str, file: ReadableFile) -> InputError:
    message = (
        f"{name} is not supported: its gains, defaults and mixers are others than those of Betaflight; give {WHAT}"
    )
    return InputError(message, file=file, key="version")


def states_release(file: ReadableFile) -> bool:
    """Return True for a file of a release, or of an export."""
    return read_release(file) is not None or any(map(EXPORTED.fullmatch, command_lines(file)))


def read_selected(file: ReadableFile) -> int | None:
    """Return the active PID profile: the last one that the command line prints; None without any."""
    matches = [match for line in command_lines(file) if (match := PROFILE.fullmatch(line))]
    return int(matches[-1][1]) if matches else None


def read_mixer(file: ReadableFile) -> str | None:
    """Return the mixer that a file names, None without any."""
    matches = [match for line in command_lines(file) if (match := MIXER.fullmatch(line))]
    return matches[-1][1] if matches else None


def read_wiring(file: ReadableFile) -> dict[str, str]:
    """Return the settings that have commands of their own: mixer, outputs, channels, 3D; the last line of each counts."""
    values: dict[str, str] = {}
    for line in command_lines(file):
        text = " ".join(line.split())
        if match := WIRING.fullmatch(text):
            values[match[1]] = match[2]
        elif match := FEATURE.fullmatch(text):
            values[f"feature {match[2]}"] = "OFF" if match[1] else "ON"
    return values


def parse_integer(text: str, name: str, file: ReadableFile) -> float:
    """Return a setting as a whole number; raises InputError naming it."""
    if not re.fullmatch(r"[+-]?\d{1,9}", text):
        raise InputError(f"given '{shortened(text)}'; this must be a whole number", file=file, key=name)
    return float(int(text))


def read_numbers(
    texts: Mapping[str, str], table: Mapping[str, ParameterInfo], release: Release | None, file: ReadableFile
) -> dict[str, float]:
    """Return the settings of a table as numbers.

    Raises InputError naming one that is no whole number, or that the firmware would not hold.

    Args:
        texts: settings of the file, by the names of 2025.12.
        table: entries of the settings that are wanted.
        release: release that printed the file, None if the file names none.
        file: path of the file for the message.
    """
    numbers = {name: parse_integer(text, name, file) for name, text in texts.items() if name in table}
    for name, value in numbers.items():
        if not is_in_range(table[name], value, release):
            allowed = range_text(table[name])
            message = f"given {value:.0f}; allowed {allowed}, beyond which the firmware stores nothing: give {WHAT}"
            raise InputError(message, file=file, key=name)
    return numbers


def is_in_range(entry: ParameterInfo, value: float, release: Release | None) -> bool:
    """Return True if a release stores a value; True, too, if the range of that release is not known."""
    has_range = release is None or release.current or entry.name in SAME_RANGE
    return not has_range or entry.low <= value <= entry.high


def range_text(entry: ParameterInfo) -> str:
    """Return the range of a setting in words."""
    return f"{entry.low:g} to {entry.high:g}"
