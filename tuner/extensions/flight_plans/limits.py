"""Limits of an identification flight: what its excitations, and air and noise alone, take of them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from plant.errors import InputError
from tuner.extensions.flight_plans import choosing
from tuner.extensions.flight_plans.excitation import PAUSE, Excitation, begins
from tuner.extensions.flight_plans.flying import FLIGHTS, Flown, SimulatedVehicle

MAX_HEIGHT = 1.0
"""Largest excursion of the height [m]."""
MOTOR_RANGE = 0.9
"""Share of the range from hover to idle or full command that motors may use."""
ROTOR_RMS, ROTOR_PEAK = 6.0, 30.0
"""Limits of the acceleration of a rotor over its hover speed [1/s]: RMS over `flying.HEATING`, and peak.

Motors are sized by their RMS torque, for windings heat with the square of the current (D. Collins, Why RMS torque is important
for motor sizing, linearmotiontips.com, 2015). The torque that accelerates a rotor is
T times this acceleration of the one that hover takes, T = J w / Q, 0.10 to 0.15 s of five shipped airframes. So 6/s are 0.6 to
0.9 of hover's torque and heat 1.3 to 1.8 times as much as hover; 30/s are 3 to 4.5 times hover's torque, as full throttle takes.
"""
STILL = 0.5
"""Share of a limit that air and noise alone may take."""


def peaks_of_hover(simulated: SimulatedVehicle, limits: Mapping[str, float]) -> dict[str, float]:
    """Return the peaks of flights without excitation; InputError where these leave no room for one."""
    flown = simulated.flown([], choosing.STREAM, FLIGHTS)
    peaks = flown.peaks
    name, limit = max(limits.items(), key=lambda entry: peaks[entry[0]] / entry[1])
    if peaks[name] > STILL * limit or not flown.completed:
        has_option = name in ("tilt", "rate")
        advice = f"allow more (--{name}), or " if has_option else ""
        raise InputError(
            f"air and noise alone take the {name.replace('_', ' ')} to {100.0 * peaks[name] / limit:.0f} % of the limit, and "
            f"more than {100.0 * STILL:.0f} % leave no room for an experiment; {advice}give gains that fly the vehicle well "
            "(--gains)",
            key=f"--{name}" if has_option else "--gains",
        )
    return peaks


def shares_of_limits(flown: Flown, excitations: Sequence[Excitation], limits: Mapping[str, float]) -> list[float]:
    """Return the largest share of a limit that each excitation takes."""
    parts = [
        flown.peaks_between(begin, begin + entry.duration + PAUSE)
        for entry, begin in zip(excitations, begins(excitations), strict=True)
    ]
    return [max(part[name] / limit for name, limit in limits.items()) for part in parts]


def reduce_amplitudes(excitations: Sequence[Excitation], shares: Sequence[float]) -> tuple[Excitation, ...]:
    """Return excitations reduced by their excess over limits.

    shares: largest share of a limit that each takes; where none exceeds 1, a flight was lost or the excess is of a pause, and all
    are weaker by the margin.
    """
    if max(shares) <= 1.0:
        return tuple(_by(entry, choosing.MARGIN) for entry in excitations)
    return tuple(
        _by(entry, choosing.MARGIN / share) if share > 1.0 else entry
        for entry, share in zip(excitations, shares, strict=True)
    )


def _by(excitation: Excitation, factor: float) -> Excitation:
    return choosing.quantize_amplitude(replace(excitation, amplitude=factor * excitation.amplitude))
