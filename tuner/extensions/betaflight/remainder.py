"""Settings of a Betaflight file besides the gains: those that its loops have and ours have not, and those of no loop."""

import re
from collections.abc import Collection, Mapping

from plant.input_files import ReadableFile
from tuner.extensions.autopilots.assembly import absent_note, record_of, settings_note, unused_note
from tuner.extensions.betaflight.map import FILTERS, NAMES, OTHERS, SWITCHES
from tuner.extensions.betaflight.native_loops import (
    FOLLOWING,
    NATIVE_LAW,
    NATIVE_SWITCHES,
    NATIVE_TABLE,
    SILENT,
    USUAL_MODES,
)
from tuner.extensions.betaflight.rpm_filter import FIXED, RPM_TABLE, TELEMETRY
from tuner.gains import VehicleRecord

CARRIED = frozenset({name for names in NAMES.values() for name in names[:2]} | {"angle_p_gain", "angle_limit"})
"""Settings that our PID carries."""
NATIVE_CARRIED = NATIVE_LAW.parameters | frozenset(RPM_TABLE) | frozenset(SILENT) | {"angle_limit"}
"""Settings that an export of the firmware's loops writes."""
ACTING = {*NATIVE_TABLE, *NATIVE_SWITCHES, *SWITCHES, *USUAL_MODES, *OTHERS, *FIXED, TELEMETRY}
ACTING |= {"pid_type", "use_integrated_yaw"}
# Settings that a note lists; all of them are in the JSON.
MAX_LISTED_COMMANDS = 40


def acts(name: str) -> bool:
    """Return true for a setting of the loops; name: that of 2025.12."""
    return name in ACTING or re.fullmatch(FILTERS, name) is not None


def untouched_settings(texts: Mapping[str, str]) -> tuple[str, ...]:
    """Return the names in a file that are of no loop."""
    return tuple(name for name in texts if not acts(name))


def vehicle_record(
    file: ReadableFile, version: str, settings: Mapping[str, str], texts: Mapping[str, str], is_native: bool
) -> VehicleRecord:
    """Return the record of a file: its whole numbers that act in the loops.

    Args:
        file: the file.
        version: name of the firmware with its release.
        settings: options of the import.
        texts: settings of the file, by the names of 2025.12.
        is_native: whether the file was read into the firmware's loops.
    """
    numbers = {name: float(text) for name, text in texts.items() if acts(name) and re.fullmatch(r"[+-]?\d+", text)}
    carried = NATIVE_CARRIED if is_native else CARRIED
    return record_of(file, "betaflight", version, settings, numbers, tuple(numbers), carried)


def untouched_note(untouched: Collection[str], texts: Mapping[str, str]) -> tuple[str, ...]:
    """Return the sentence on the settings of no loop."""
    if not untouched:
        return ()
    listed = {name: texts[name] for name in list(untouched)[:MAX_LISTED_COMMANDS]}
    further = len(untouched) - len(listed)
    return settings_note(
        "Not known as settings of these loops, so neither read nor written by an export (check them for misspellings)",
        listed,
        f" and {further} more" if further else "",
    )


def native_absent_note(
    texts: Mapping[str, str], usual: Mapping[str, float], called: Mapping[str, str], name: str
) -> tuple[str, ...]:
    """Return the sentence on the gains and filters that a file lacks.

    Args:
        texts: settings of the file, by the names of 2025.12.
        usual: defaults of the release.
        called: name in 2025.12 -> name in the file.
        name: the firmware with its release.
    """
    wanted = {
        called.get(entry.name, entry.name): usual.get(entry.name, entry.usual)
        for entry in NATIVE_TABLE.values()
        if entry.name in NATIVE_CARRIED and entry.name not in RPM_TABLE and not _is_silent(entry.name)
    }
    return absent_note({called.get(one, one): text for one, text in texts.items()}, wanted, name)


def _is_silent(name: str) -> bool:
    return name in SILENT and name not in FOLLOWING.values()


def native_terms_note(values: Mapping[str, float], called: Mapping[str, str]) -> tuple[str, ...]:
    """Return the sentence on terms that an export switches off; values: complete, by the names of 2025.12."""
    terms = {called.get(name, name): values.get(name, 0.0) for name in SILENT if _is_silent(name)}
    return unused_note(terms, terms, "Terms that our law has not are left out, and an export switches them off")


def replaced_low_passes(texts: Mapping[str, str], values: Mapping[str, float]) -> tuple[str, ...]:
    """Return sentences on low-passes at a fixed cut-off that do not act.

    Those that follow the throttle replace them. values: complete, by the names of 2025.12.
    """
    return tuple(
        f"{name} = {texts[name]} does not act where {low} is above 0, and that is {values[low]:g} Hz"
        f"{'' if low in texts else ' (default)'}: read is a low-pass at {values[low]:g} Hz."
        for name, low in FOLLOWING.items()
        if name in texts and values[low] > 0.0 and values[name] != values[low]
    )


def remaining_filters_note(texts: Mapping[str, str]) -> tuple[str, ...]:
    """Return the sentence on filters that our law has not."""
    read = {*NATIVE_TABLE, *NATIVE_SWITCHES, *FIXED, "gyro_notch2_hz", "dterm_notch_hz"}
    filters = {name: text for name, text in texts.items() if re.fullmatch(FILTERS, name) and name not in read}
    return settings_note("Filters and loop rate of the vehicle, which our loops have not and an export leaves", filters)
