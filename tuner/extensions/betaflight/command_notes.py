"""Sentences on the way in which command lines came to their settings: repetitions, sliders, options, releases, profiles."""

from collections.abc import Iterator

from plant.errors import shortened
from plant.input_files import ReadableFile
from tuner.extensions.betaflight.commands import ProfileSettings
from tuner.extensions.betaflight.presets import MAX_NAMES, command_lines, options_note, stated_versions
from tuner.extensions.betaflight.text import read_selected
from tuner.text.sentences import first_texts


def command_notes(file: ReadableFile, profile: int, settings: ProfileSettings, release: str) -> Iterator[str]:
    """Yield the sentences on command lines.

    Args:
        file: path of the file.
        profile: number of the PID profile that is read.
        settings: settings of the profile.
        release: name of the release that is assumed.
    """
    lines = command_lines(file)
    if len(versions := stated_versions(lines)) > 1:
        yield f"A preset for Betaflight {', '.join(versions)}, read as {release}."
    if settings.repeated:
        changes = [f"{name} {' to '.join(map(shortened, _ends(texts)))}" for name, texts in settings.repeated.items()]
        yield f"Set more than once; the last value counts, as on the vehicle: {first_texts(changes, MAX_NAMES)}."
    if settings.refused:
        refused = [f"{name} = {text}" for name, text in settings.refused.items()]
        yield f"The firmware refuses these settings, so the earlier values stay: {first_texts(refused, MAX_NAMES)}."
    if settings.applied:
        applied = [f"{name} = {value}" for name, value in settings.applied.items()]
        yield f"'simplified_tuning apply' stores gains and cut-offs of the sliders: {first_texts(applied, MAX_NAMES)}."
    yield from options_note(lines)
    yield from _profiles_note(settings.n_settings, profile, read_selected(file))


def _profiles_note(n_settings: dict[int, int], profile: int, active: int | None) -> Iterator[str]:
    """Yield the sentence on a file with settings of other profiles."""
    others = {number: count for number, count in n_settings.items() if number != profile and count > 0}
    if not others:
        return
    counts = ", ".join(f"{number} ({count} settings)" for number, count in sorted(others.items()))
    read = f"PID profile {profile}" + (" (active)" if profile == active else f" (active: {active})")
    if n_settings.get(profile, 0) > 0:
        yield f"Read is {read} with {n_settings[profile]} settings; the file has the profiles {counts}, too."
    else:
        yield f"Read is {read}, for which the file has no settings: its gains are the defaults. Other profiles: {counts}."


def _ends(texts: list[str]) -> list[str]:
    return [texts[0], texts[-1]]
