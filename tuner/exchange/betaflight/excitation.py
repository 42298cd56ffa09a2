"""An experiment in Betaflight's CHIRP mode (2025.12, a build with USE_CHIRP): settings of the present PID profile.

Names, units and ranges as in cli/settings.c, the chirp as in common/chirp.c: a rate set point that begins at its top, sweeps
exponentially, and takes the next axis, roll, pitch, yaw, each time that the mode is switched on. Its lag-lead filter passes all
alike where both its frequencies are the same.
"""

from collections.abc import Mapping, Sequence
from math import ceil, degrees

from tuner.analysis.flight_plan.choosing import TargetCapabilities
from tuner.analysis.flight_plan.excitation import Excitation, Shape
from tuner.analysis.flight_plan.flying import SimulatedVehicle
from tuner.exchange.autopilot.parameters import as_bytes
from tuner.exchange.excitation_target import ExcitationTarget

AXES = ("roll", "pitch", "yaw")
FLAT = 30
"""Both frequencies of the filter [Hz]."""
HEAD = (
    "# paste into the CLI, in the PID profile that flies",
    "# begin with half the amplitude: half of every chirp_amplitude_",
)
LEAST = 1.0
"""Below it the firmware shrinks the amplitude with the frequency [Hz]."""


def settings(excitations: Sequence[Excitation]) -> dict[str, int]:
    """Return the settings by name; an axis without an excitation has amplitude 0."""
    first = excitations[0]
    sizes = {entry.axis: round(degrees(entry.amplitude)) for entry in excitations}
    return {
        "chirp_lag_freq_hz": FLAT,
        "chirp_lead_freq_hz": FLAT,
        **{f"chirp_amplitude_{axis}": sizes.get(axis, 0) for axis in AXES},
        "chirp_frequency_start_deci_hz": round(10.0 * first.first),
        "chirp_frequency_end_deci_hz": round(10.0 * first.last),
        "chirp_time_seconds": ceil(first.duration),
    }


def files(excitations: Sequence[Excitation], simulated: SimulatedVehicle) -> Mapping[str, bytes]:  # noqa: ARG001
    """Return the lines to paste into the command line."""
    lines = [f"set {name} = {value}" for name, value in settings(excitations).items()]
    return {"chirp.txt": as_bytes([*HEAD, *lines, "save"])}


EXCITATIONS = ExcitationTarget(
    "betaflight",
    TargetCapabilities(
        dict.fromkeys(AXES, "rate"),
        shape=Shape(dwell=0.0, fade_in=0.0, fade_out=0.0, cosine=True),
        alike=True,
        least=LEAST,
    ),
    files,
    (
        "It needs a build with USE_CHIRP and the mode CHIRP on a switch; each time it is switched on, the next axis is excited.",
        "The mode excites no lift; move the throttle up and down yourself between two axes, or thrust and drag stay unknown.",
        "The firmware follows rates faster than the simulated angle loops, so that the vehicle moves more at high frequencies.",
    ),
)
