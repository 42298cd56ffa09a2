"""Command lines of a tune: `set` lines of one profile, with remarks that name their origin."""

from collections.abc import Mapping

from plant.errors import InputError
from tuner.extensions.betaflight_adrc.adrc_law import LAW
from tuner.extensions.betaflight_adrc.reading import Profile
from tuner.extensions.betaflight_adrc.settings import AXES, LAG, SCHEDULE, SETTINGS, Tune

HOVER = "adrc_hover_throttle"
ESSENTIAL = (*(f"adrc_{name}_{axis}" for name in ("wc", "wo", "b0") for axis in AXES), HOVER, SCHEDULE)
"""Settings that every file has; of the rest it has those that are changed."""
COMMON_SETTINGS = {
    "lpf": "adrc_gyro_lpf_hz",
    "hover": HOVER,
    "scale_max": "adrc_b0_scale_max",
    "sigma": "adrc_sigma_decay",
}
"""Gain of the law that the axes share -> setting."""
MAX_REMARK = 120


def settings_of_gains(law: str, gains: Mapping[str, float], tune: Tune) -> dict[str, str]:
    """Return the settings of gains that differ from a tune's; raises InputError for gains of another law.

    Args:
        law: Name of the attitude law.
        gains: Gains by address, such as roll.wc.
        tune: Settings of the vehicle.
    """
    if law != LAW.name:
        raise InputError(f'given gains of {law}; give those of a study with attitude = "{LAW.name}"', key="--gains")
    values = {f"adrc_{name}_{axis}": gains[f"{axis}.{name}"] for name in ("wc", "wo", "b0") for axis in AXES}
    values |= {setting: gains[f"roll.{name}"] for name, setting in COMMON_SETTINGS.items()}
    if tune.build.has(LAG):
        values[LAG] = 1e3 * gains["roll.tau"]
    values[SCHEDULE] = gains["roll.schedule"]
    return {name: SETTINGS[name].text(value) for name, value in values.items() if round(value) != tune.numbers[name]}


def command_lines_of(profile: Profile, changes: Mapping[str, str], source: str, sentence: str) -> str:
    """Return the text of a file for the command line.

    Args:
        profile: Profile with its changes.
        changes: Settings that a person changed.
        source: Origin of the plants.
        sentence: Answer of the forecast.
    """
    tune = profile.tune
    remarks = [
        f"Betaflight ADRC, build {tune.build.name}, loop of {1.0 / profile.sampling.period:.0f} Hz; {source}",
        *_wrapped(sentence),
    ]
    names = [name for name in dict.fromkeys([*ESSENTIAL, *changes]) if tune.build.has(name)]
    lines = ["set pid_type = ADRC", *(f"set {name} = {tune.text(name)}" for name in names)]
    return "\n".join([*(f"# {remark}" for remark in remarks), f"profile {profile.number}", *lines, "save", ""])


def _wrapped(text: str) -> list[str]:
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) > MAX_REMARK:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
