"""Betaflight's command line as a file: `set name = value`, within a PID profile, as `diff` and `dump` print it.

The firmware answers a wrong name or value with a line that begins with ###ERROR and goes on. Within a batch that is still open it
then refuses to save; `batch end` before `save` would clear the error, and half of the settings would be stored.
"""

import re
from collections.abc import Iterator, Mapping, Sequence

from plant.errors import InputError, UnsupportedVersionError, shortened
from plant.input_files import ReadableFile
from tuner.exchange.target import whole_number
from tuner.extensions.autopilots.parameters import ParameterInfo, as_bytes, read_lines
from tuner.extensions.betaflight.map import NAMES, RELEASES, TABLE, Release

WHAT = "what Betaflight's command line prints for 'diff all' or 'dump all'"
SETTING = re.compile(r"set\s+([a-z0-9_]+)\s*=\s*(\S.*?)\s*")
PROFILE = re.compile(r"profile\s+([0-9])")
OTHER_PROFILE = re.compile(r"(rate|battery_)profile\b.*")
VERSION = re.compile(r"#\s*(\w+) / .*?\s(\d+\.\d+)(?:\.\d+\S*)?\s.*")
# INAV writes no blanks around the first slash; the date tells its line from a remark.
OTHER_VERSION = re.compile(r"#\s*([A-Za-z]\w*)/\S+\s(\d+\.\d+)(?:\.\d+\S*)?\s+[A-Z][a-z]{2}\s+\d+ \d{4}\b.*")
INAV_SETTING = re.compile(r"set\s+((mc|fw)_[pid]_(roll|pitch|yaw)|nav_\w+)\s*=.*")
EXPORTED = re.compile(r"# (For|Rollback to the defaults of) Betaflight \d+\.\d+\b.*")
"""Line of an export, whose names are those of a file that states no release."""
WIRING = re.compile(r"(mixer|map|mmix \d+|resource MOTOR \d+)\s+(\S.*)")
FEATURE = re.compile(r"feature (-?)(3D)")
APPLY = re.compile(r"simplified_tuning\s+apply")
"""Command that turns sliders into gains."""
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


def read_cli(file: ReadableFile, profile: int) -> dict[str, str]:
    """Return the settings that hold in a PID profile; raises InputError naming file and setting.

    Settings before the first `profile` hold in every profile; those of a profile hold until the next one. Rate and battery
    profiles have settings of their own, none of which acts in the loops: where two of them differ, both are left out.
    """
    values: dict[str, str] = {}
    others: dict[str, dict[str, str]] = {}
    inside: int | None = None
    other: dict[str, str] | None = None
    is_profile_listed = False
    for line in read_lines(file, WHAT):
        text = line.strip()
        if hit := PROFILE.fullmatch(text):
            inside, other = int(hit[1]), None
            is_profile_listed = is_profile_listed or inside == profile
        elif OTHER_PROFILE.fullmatch(text):
            inside, other = None, others.setdefault(text, {})
        elif (hit := SETTING.fullmatch(text)) and inside in (None, profile):
            _enter(values if other is None else other, hit[1], hit[2], file)
        elif APPLY.fullmatch(text):
            message = f"'{shortened(text)}' has the vehicle work its gains out; load it there, then give {WHAT}"
            raise InputError(message, file=file)
        elif text.startswith("###"):
            raise InputError(f"holds the error '{shortened(text)}' of the firmware; give {WHAT}", file=file)
    for name, value in _agreed(others):
        _enter(values, name, value, file)
    if not values and not is_profile_listed:
        raise InputError(f"holds no setting of profile {profile}; give {WHAT}", file=file)
    return values


def _agreed(others: Mapping[str, Mapping[str, str]]) -> Iterator[tuple[str, str]]:
    """Yield settings common to all profiles (rate and battery) and those of our loops."""
    pairs = [pair for settings in others.values() for pair in settings.items()]
    for name, value in pairs:
        if name in TABLE or all(value == another for same, another in pairs if same == name):
            yield name, value


def read_release(file: ReadableFile) -> Release | None:
    """Return the release that printed a file, or None.

    Raises InputError for another firmware, UnsupportedVersionError for an unknown release.
    """
    lines = [line.strip() for line in read_lines(file, WHAT)]
    matches = [match for line in lines if (match := VERSION.fullmatch(line) or OTHER_VERSION.fullmatch(line))]
    if not matches and any(INAV_SETTING.fullmatch(line) for line in lines):
        raise _other_firmware("INAV", file)
    if not matches:
        return None
    firmware, version = matches[0][1], matches[0][2]
    if firmware != "Betaflight":
        raise _other_firmware(f"{firmware} {version}", file)
    if version not in RELEASES:
        message = f"was printed by {firmware} {version}; known are Betaflight {', '.join(RELEASES)}"
        raise UnsupportedVersionError(message, file=file, key="version")
    return RELEASES[version]


def _other_firmware(name: str, file: ReadableFile) -> InputError:
    message = (
        f"{name} is not supported: its gains, defaults and mixers are others than those of Betaflight; give {WHAT}"
    )
    return InputError(message, file=file, key="version")


def states_release(file: ReadableFile) -> bool:
    """Return True for a file of a release, or of an export."""
    return read_release(file) is not None or any(map(EXPORTED.fullmatch, read_lines(file, WHAT)))


def read_selected(file: ReadableFile) -> int | None:
    """Return the active PID profile: the last one that the command line prints; None without any."""
    matches = [match for line in read_lines(file, WHAT) if (match := PROFILE.fullmatch(line.strip()))]
    return int(matches[-1][1]) if matches else None


def read_mixer(file: ReadableFile) -> str | None:
    """Return the mixer that a file names, None without any."""
    matches = [match for line in read_lines(file, WHAT) if (match := MIXER.fullmatch(line.strip()))]
    return matches[-1][1] if matches else None


def read_wiring(file: ReadableFile) -> dict[str, str]:
    """Return the settings that have commands of their own: mixer, outputs, channels, 3D; the last line of each counts."""
    values: dict[str, str] = {}
    for line in read_lines(file, WHAT):
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
        low, high = table[name].low, table[name].high
        has_range = release is None or release.current or name in SAME_RANGE
        if has_range and not low <= value <= high:
            message = (
                f"given {value:.0f}; allowed {low:g} to {high:g}, beyond which the firmware stores nothing: give {WHAT}"
            )
            raise InputError(message, file=file, key=name)
    return numbers


def _enter(values: dict[str, str], name: str, value: str, file: ReadableFile) -> None:
    if values.setdefault(name, value) != value:
        message = f"given twice, as {shortened(values[name])} and as {shortened(value)}; leave one out"
        raise InputError(message, file=file, key=name)
