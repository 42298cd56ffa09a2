"""Command lines of a tune: `set` lines of one profile, with remarks that name their origin."""

from collections.abc import Mapping

from plant.errors import InputError
from tuner.extensions.betaflight_adrc.adrc_law import LAW
from tuner.extensions.betaflight_adrc.equations import SCHEDULES
from tuner.extensions.betaflight_adrc.reading import Profile
from tuner.extensions.betaflight_adrc.settings import AXES, Tune

HOVER = "adrc_hover_throttle"
ESSENTIAL = tuple(f"adrc_{name}_{axis}" for name in ("wc", "wo", "b0") for axis in AXES)
"""Numbers that every file sets."""
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
    if tune.build.has("adrc_motor_tau_ms"):
        values["adrc_motor_tau_ms"] = 1e3 * gains["roll.tau"]
    changes = {name: f"{value:.0f}" for name, value in values.items() if round(value) != tune.numbers[name]}
    schedule = next(word for word, number in SCHEDULES.items() if number == round(gains["roll.schedule"]))
    return changes | ({"adrc_b0_law": schedule} if schedule != tune.schedule else {})


def values_of(tune: Tune, changes: Mapping[str, str]) -> dict[str, str]:
    """Return the settings of a file by name; of the rest only those that are changed."""
    values = {"pid_type": "ADRC", **{name: f"{tune.numbers[name]:.0f}" for name in (*ESSENTIAL, HOVER)}}
    values["adrc_b0_law"] = tune.schedule
    for name in changes:
        if name in tune.numbers:
            values[name] = f"{tune.numbers[name]:.0f}"
        elif name == "adrc_sat_z3_inhibit":
            values[name] = "ON" if tune.inhibits else "OFF"
    return values


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
    lines = [f"set {name} = {value}" for name, value in values_of(tune, changes).items()]
    return "\n".join([*(f"# {remark}" for remark in remarks), f"profile {profile.number}", *lines, "save", ""])


def _wrapped(text: str) -> list[str]:
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) > MAX_REMARK:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
