"""An experiment in Betaflight's CHIRP mode (2025.12, a build with USE_CHIRP): settings of the present PID profile.

Names, units and ranges as in cli/settings.c, the chirp as in common/chirp.c: a rate set point that begins at its top, sweeps
exponentially, and takes the next axis, roll, pitch, yaw, each time that the mode is switched on. It goes through a lag-lead
filter of its own, which lowers it between both corners. The mode excites no lift: its steps are the pilot's.
"""

from collections.abc import Mapping, Sequence
from math import ceil, degrees

from tuner.extensions.autopilots.parameters import as_bytes
from tuner.extensions.flight_plans.choosing import TargetCapabilities
from tuner.extensions.flight_plans.excitation import LAG_CORNER, LEAD_CORNER, Excitation, Shape
from tuner.extensions.flight_plans.excitation_target import ExcitationTarget, throttle_share
from tuner.extensions.flight_plans.flying import SimulatedVehicle

AXES = ("roll", "pitch", "yaw")
HEAD = "# paste into the CLI, in the PID profile that flies"
MIN_AMPLITUDE = 1.0
"""Below it the firmware shrinks the amplitude with the frequency [Hz]."""


def settings(excitations: Sequence[Excitation]) -> dict[str, int]:
    """Return the settings by name; an axis without an excitation has amplitude 0."""
    first = excitations[0]
    sizes = {entry.axis: round(degrees(entry.amplitude)) for entry in excitations}
    return {
        "chirp_lag_freq_hz": round(LAG_CORNER),
        "chirp_lead_freq_hz": round(LEAD_CORNER),
        **{f"chirp_amplitude_{axis}": sizes.get(axis, 0) for axis in AXES},
        "chirp_frequency_start_deci_hz": round(10.0 * first.first),
        "chirp_frequency_end_deci_hz": round(10.0 * first.last),
        "chirp_time_seconds": ceil(first.duration),
    }


def files(excitations: Sequence[Excitation], simulated: SimulatedVehicle) -> Mapping[str, bytes]:
    """Return the settings of the command line, and the pilot's throttle steps."""
    chirps = [entry for entry in excitations if entry.axis in AXES]
    lines = [f"set {name} = {value}" for name, value in settings(chirps).items()] if chirps else []
    made = {"chirp.txt": as_bytes([HEAD, *lines, "save"])} if chirps else {}
    for entry in excitations:
        if entry.axis == "lift":
            made["throttle_steps.txt"] = as_bytes(throttle_steps(entry, simulated))
    return made


def throttle_steps(excitation: Excitation, simulated: SimulatedVehicle) -> list[str]:
    """Return the throttle steps of a pilot, line by line."""
    hold = 0.5 / excitation.first
    share = 100.0 * throttle_share(excitation.amplitude, simulated.system.vehicle)
    return [
        "throttle steps: fly them between two axes, in hover, sticks of roll, pitch and yaw in the middle",
        f"by {share:.1f} % of the full thrust up and down about hover",
        f"begin with {0.5 * hold:g} s up, then {hold:g} s down, {hold:g} s up and so on, {excitation.duration:g} s in all",
        "end with half a step; a thrust that is some per cent off does no harm, for the log holds the commands",
    ]


EXCITATIONS = ExcitationTarget(
    "betaflight",
    TargetCapabilities(
        {**dict.fromkeys(AXES, "rate"), "lift": "acceleration"},
        lift_waves=("steps",),
        shape=Shape(dwell=0.0, fade_in=0.0, fade_out=0.0, cosine=True, lag=LAG_CORNER, lead=LEAD_CORNER),
        alike=True,
        least=MIN_AMPLITUDE,
    ),
    files,
    (
        "It needs a build with USE_CHIRP and the mode CHIRP on a switch; each time it is switched on, the next axis is excited.",
        "The mode excites no lift: throttle_steps.txt says what the pilot does between two axes.",
        "The firmware follows rates faster than the simulated angle loops, so that the vehicle moves more at high frequencies.",
    ),
)
