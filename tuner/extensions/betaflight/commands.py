"""Settings of one PID profile after command lines in their order.

A later `set` replaces an earlier one, `simplified_tuning apply` stores what the sliders are worth at that line, and `defaults`
resets everything, or one group.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from plant.errors import InputError, shortened
from plant.input_files import ReadableFile
from tuner.extensions.betaflight.map import USUAL, Release
from tuner.extensions.betaflight.native_loops import NATIVE_TABLE
from tuner.extensions.betaflight.presets import WHAT, command_lines, options_note, stated_versions
from tuner.extensions.betaflight.remainder import acts
from tuner.extensions.betaflight.sliders import applied_settings
from tuner.extensions.betaflight.text import PROFILE, is_in_range, range_text, read_release, read_selected

INTEGER = re.compile(r"[+-]?\d{1,9}")
SETTING = re.compile(r"set\s+([a-z0-9_]+)\s*=\s*(\S.*)", re.IGNORECASE)
OTHER_PROFILE = re.compile(r"(rate|battery_)profile\b.*")
APPLY = re.compile(r"simplified_tuning\s+apply", re.IGNORECASE)
"""Command that turns sliders into gains."""
DISABLE = re.compile(r"simplified_tuning\s+disable", re.IGNORECASE)
DEFAULTS = re.compile(r"defaults\b(?!\s+show)(?:.*\bgroup_id\s+(\d+))?.*")
"""Command that sets everything, or one group, to its default."""
GROUPS = {"544": re.compile(r"rpm_filter_\w+"), "554": re.compile(r"dyn_notch_\w+")}
"""Number of a group -> its settings: PG_RPM_FILTER_CONFIG and PG_DYN_NOTCH_CONFIG of src/main/pg/pg_ids.h."""
LOADED = "# Loaded over the lines above"
"""Line of ours between the present settings and a file that is loaded over them."""
SWITCHES_OFF = {"simplified_pids_mode": "OFF", "simplified_dterm_filter": "OFF", "simplified_gyro_filter": "OFF"}


@dataclass
class ProfileSettings:
    """Settings of a PID profile after all lines of a file.

    Attributes:
        values: Name -> value as text.
        texts: Name -> the values that the file sets in their order, of which the last one counts.
        applied: Settings that the sliders stored, as they are now.
        n_settings: PID profile -> number of its settings in the file.
        refused: Settings of a preset that the firmware does not store -> value and range as text.
    """

    values: dict[str, str] = field(default_factory=dict[str, str])
    texts: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    applied: dict[str, str] = field(default_factory=dict[str, str])
    n_settings: dict[int, int] = field(default_factory=dict[int, int])
    refused: dict[str, str] = field(default_factory=dict[str, str])

    @property
    def repeated(self) -> dict[str, list[str]]:
        """Settings that the file sets to several values: name -> values in their order."""
        return {name: texts for name, texts in self.texts.items() if len(texts) > 1}


def read_cli(file: ReadableFile, profile: int) -> dict[str, str]:
    """Return the settings that hold in a PID profile; raises InputError naming file and setting."""
    return read_profile(file, profile).values


def read_profile(file: ReadableFile, profile: int) -> ProfileSettings:
    """Return the settings of a PID profile; raises InputError naming file and setting.

    Settings before the first `profile` hold in every profile; those of a profile hold until the next one. Rate and battery
    profiles have settings of their own, none of which acts in the loops: where two of them differ, both are left out.
    """
    lines = command_lines(file)
    session = _Session(file, profile, read_release(file) or USUAL, is_preset=bool(stated_versions(lines)))
    for line in lines:
        session.execute(line)
    settings = session.settings
    settings.values = settings.values | {k: v for k, v in _agreed(session.others).items() if k not in settings.values}
    if not settings.values and profile not in settings.n_settings:
        remedy = f"check options of the preset, or give {WHAT}" if options_note(lines) else f"give {WHAT}"
        raise InputError(f"holds no setting of profile {profile}; {remedy}", file=file)
    return settings


@dataclass
class _Session:
    """A command line in use.

    Attributes:
        file: Path of the file for messages.
        profile: Number of the PID profile that is read.
        release: Release of the firmware.
        is_preset: Whether the file is written by hand for any vehicle; a board prints only values that it stores.
        settings: Settings so far.
        selected: Number of the PID profile that `set` changes, None for every one.
        others: Rate or battery profile -> its settings.
        other: Name of the rate or battery profile that is open, "" for none.
    """

    file: ReadableFile
    profile: int
    release: Release
    is_preset: bool = False
    settings: ProfileSettings = field(default_factory=ProfileSettings)
    selected: int | None = None
    others: dict[str, dict[str, str]] = field(default_factory=dict[str, dict[str, str]])
    other: str = ""

    def execute(self, line: str) -> None:
        """Carry out one line; a line of no interest does nothing."""
        if line.startswith("###"):
            raise InputError(f"holds the error '{shortened(line)}' of the firmware; give {WHAT}", file=self.file)
        if line == LOADED:
            self.settings.texts.clear()
        # The firmware ignores the rest of a line from this mark on.
        text = line.partition("#")[0].strip()
        if match := SETTING.fullmatch(text):
            self._set(match[1].lower(), match[2])
        elif match := PROFILE.fullmatch(text):
            self.selected, self.other = int(match[1]), ""
            self.settings.n_settings.setdefault(self.selected, 0)
        elif OTHER_PROFILE.fullmatch(text):
            self.other = text
            self.others.setdefault(text, {})
        elif match := DEFAULTS.fullmatch(text):
            self._reset(match[1])
        elif APPLY.fullmatch(text):
            self._store(applied_settings(self.settings.values, self.release, self.file))
        elif DISABLE.fullmatch(text):
            self.settings.values |= SWITCHES_OFF

    def _set(self, name: str, value: str) -> None:
        current = self.release.renamed.get(name, name)
        if acts(current):
            # Words may be in either case.
            value = value if current in NATIVE_TABLE else value.upper()
        elif self.other:
            self.others[self.other][name] = value
            return
        if self.selected is not None:
            self.settings.n_settings[self.selected] += 1
        if self.selected not in (None, self.profile):
            return
        if self.is_preset and (allowed := self._refusing_range(current, value)):
            self.settings.refused[name] = f"{value} (allowed {allowed})"
            return
        self.settings.values[name] = value
        texts = self.settings.texts.setdefault(name, [])
        if texts[-1:] != [value]:
            texts.append(value)
        self.settings.applied.pop(name, None)

    def _refusing_range(self, name: str, value: str) -> str:
        """Return the range of a setting that excludes a value, or ""."""
        entry = NATIVE_TABLE.get(name)
        if entry is None or not INTEGER.fullmatch(value) or is_in_range(entry, float(value), self.release):
            return ""
        return range_text(entry)

    def _store(self, applied: Mapping[str, str]) -> None:
        """Store what the sliders give."""
        self.settings.values |= applied
        self.settings.applied |= applied
        for name in applied:
            self.settings.texts.pop(name, None)

    def _reset(self, group: str | None) -> None:
        if group is None:
            self.settings = ProfileSettings()
            self.others, self.other, self.selected = {}, "", None
        elif group in GROUPS:
            pattern = GROUPS[group]
            self.settings.values = {k: v for k, v in self.settings.values.items() if not pattern.fullmatch(k)}


def _agreed(others: Mapping[str, Mapping[str, str]]) -> dict[str, str]:
    """Return the settings in which all rate and battery profiles agree."""
    texts: dict[str, set[str]] = {}
    for settings in others.values():
        for name, value in settings.items():
            texts.setdefault(name, set()).add(value)
    return {name: values.pop() for name, values in texts.items() if len(values) == 1}


def loaded_over(before: ReadableFile, after: ReadableFile) -> str:
    """Return a vehicle's file with another one loaded into its active profile.

    Raises InputError for a preset of another release.
    """
    later, release = command_lines(after), read_release(before)
    if any((match := DEFAULTS.fullmatch(line)) and match[1] is None for line in later):
        return "\n".join(later) + "\n"
    versions = stated_versions(later)
    if versions and release is not None and release.name not in versions:
        wanted = f"{before} is of {release.name}; give a preset of that release"
        message = f"is a preset for Betaflight {', '.join(versions)}, and {wanted}"
        raise InputError(message, file=after, key="FIRMWARE_VERSION")
    profile = f"profile {read_selected(before) or 0}"
    return "\n".join([*command_lines(before), profile, LOADED, *later]) + "\n"
