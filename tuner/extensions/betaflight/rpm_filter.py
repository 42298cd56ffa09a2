"""Betaflight's RPM filter as our notches that follow the rotors, and back.

It acts on vehicles whose motors answer with their speed (`dshot_bidir`). Its notches grow whole over `rpm_filter_fade_range_hz`
(src/main/flight/rpm_filter.c); ours are whole half of their least frequency above it.
"""

from collections.abc import Mapping
from dataclasses import replace

from plant.quadrotor.nominal import ControlOptions
from tuner.extensions.autopilots.assembly import settings_note
from tuner.extensions.autopilots.parameters import ParameterInfo, parameter_table

RPM_TABLE = parameter_table(
    ParameterInfo("rpm_filter_harmonics", "1", 0.0, 3.0, 3.0, "controller.rpm_notches"),
    ParameterInfo("rpm_filter_q", "1/100", 250.0, 3000.0, 500.0, "controller.rpm_notch_q"),
    ParameterInfo("rpm_filter_min_hz", "Hz", 30.0, 200.0, 100.0, "controller.rpm_notch_min"),
    ParameterInfo("rpm_filter_fade_range_hz", "Hz", 0.0, 1000.0, 50.0, "controller.rpm_notch_min"),
)
TELEMETRY = "dshot_bidir"
# Settings that ours has not, as they are by default.
FIXED = {"rpm_filter_weights": "100,100,100", "rpm_filter_lpf_hz": "150"}


def rpm_settings(options: ControlOptions) -> dict[str, float]:
    """Return the settings of notches, unrounded; nothing where there are none, for a vehicle then keeps its filter."""
    if not options.rpm_notches:
        return {}
    least = options.rpm_notch_min
    return dict(
        zip(RPM_TABLE, (float(options.rpm_notches), 100.0 * options.rpm_notch_q, least, 0.5 * least), strict=True)
    )


def with_notches(options: ControlOptions, values: Mapping[str, float]) -> ControlOptions:
    """Return options with the notches of settings; values: those of `RPM_TABLE` among others, or none of them."""
    if not RPM_TABLE.keys() <= values.keys():
        return options
    harmonics, quality, least, _ = (values[name] for name in RPM_TABLE)
    return replace(options, rpm_notches=round(harmonics), rpm_notch_q=0.01 * quality, rpm_notch_min=least)


def rpm_read(
    options: ControlOptions, values: Mapping[str, float], texts: Mapping[str, str]
) -> tuple[ControlOptions, tuple[str, ...]]:
    """Return options with a vehicle's RPM filter, and notes on the differences.

    values: complete, those of `RPM_TABLE` among others; texts: all settings of its file.
    """
    if not values["rpm_filter_harmonics"]:
        return options, ()
    if texts.get(TELEMETRY, "OFF") != "ON":
        idle = (
            f"The RPM filter acts where {TELEMETRY} = ON, which the file does not say: no notches follow the rotors.",
        )
        return options, idle if any(name in texts for name in RPM_TABLE) else ()
    given = {name: texts.get(name, usual) for name, usual in FIXED.items()}
    others = {name: text for name, text in given.items() if text.replace(" ", "") != FIXED[name]}
    fade, usual_fade = values["rpm_filter_fade_range_hz"], 0.5 * values["rpm_filter_min_hz"]
    others |= {"rpm_filter_fade_range_hz": f"{fade:g} in place of {usual_fade:g}"} if fade != usual_fade else {}
    return with_notches(options, values), settings_note("Our notches that follow the rotors have not", others)


def rpm_differences(options: ControlOptions) -> tuple[str, ...]:
    """Return the sentence on the RPM filter's requirements; none where it is not set."""
    if not options.rpm_notches:
        return ()
    return (
        f"The RPM filter acts only with {TELEMETRY} = ON and ESCs that tell their speed; the file does not set it.",
    )
