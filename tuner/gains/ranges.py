"""Ranges of gains at a control period, and of the periods themselves.

They are those of studies, gains files and imports.
"""

from math import ceil

from plant.errors import InputError
from plant.laws.filters import HALF
from plant.loop import Timing
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.gains import MAX_BANDWIDTH_PERIODS, GainAddress


def check_value(key: str, gain: GainAddress, value: float, control_period: float, origin: str = "given") -> None:
    """Refuse a value that a gain cannot have at this control period [s]; key: of the entry that gives it."""
    info, what = gain.info, f"{origin} {value:g} {gain.unit} for {gain.address} ({gain.info.meaning})"
    if value < info.least or (info.exclusive and value == info.least):
        bound = "above" if info.exclusive else "at least"
        raise InputError(f"{what}; it must be {bound} {info.least:g} {gain.unit}", key=key)
    if info.cutoff and value * control_period >= HALF:
        raise InputError(
            f"{what}; at a control period of {control_period:g} s allowed: below {HALF / control_period:g} Hz, half the sampling "
            "rate: give a lower frequency, or shorten controller.control_period",
            key=key,
        )
    # Relative 1e-9: 75 rad/s at 4 ms is the limit and not above it, whichever way the product rounds.
    if info.observer and value * control_period > MAX_BANDWIDTH_PERIODS * (1.0 + 1e-9):
        raise InputError(
            f"{what}; at a control period of {control_period:g} s the largest allowed value is "
            f"{MAX_BANDWIDTH_PERIODS / control_period:g} rad/s (bandwidth times period at most {MAX_BANDWIDTH_PERIODS}), "
            "beyond it the sampled observer is not the one designed: give a smaller value, or shorten the control period",
            key=key,
        )


# Periods are multiples if they are so within rounding.
MULTIPLE = 1e-9
# Shortest and longest period [s]: beyond either a digit slipped.
SHORTEST, LONGEST = 1e-5, 0.1
# Longest of a plant of one's own [s]: kilns and basins are sampled by the minute. Shortest step of one: stiff plants need it.
LONGEST_OF_PLANTS, SHORTEST_OF_PLANTS = 3600.0, 1e-9


def check_period(key: str, value: float, longest: float = LONGEST, shortest: float = SHORTEST) -> None:
    """Refuse a period [s] that is out of range; key: its name."""
    if not shortest <= value <= longest:
        raise InputError(f"given {value:g} s; allowed: {shortest:g} s to {longest:g} s", key=key)


def timing_of(control_period: float, plant_step: float, longest: float = LONGEST, shortest: float = SHORTEST) -> Timing:
    """Return the periods [s]; InputError with the key where one is out of range or the first no multiple of the second.

    shortest: that the plant step may be.
    """
    check_period("control_period", control_period, longest)
    check_period("plant_step", plant_step, longest, shortest)
    check_multiple(control_period, plant_step, "control_period", "plant_step")
    return Timing(control_period, plant_step)


def longest_plant_step(airframe: Airframe) -> float:
    """Return the longest plant step [s] that is accurate on the rotors.

    They are the fastest part. With steps of up to half their lag no metric of 1,664 flights was off by more than 1e-6 of itself;
    a Runge-Kutta step is unstable beyond 2.8 lags.
    """
    return 0.5 * min(airframe.vehicle.lag_up, airframe.vehicle.lag_down)


def usual_timing(control_period: float, airframe: Airframe) -> Timing:
    """Return a control period [s] in the fewest accurate and equal plant steps.

    They are no longer than `longest_plant_step`. Raises InputError with the key where the period is out of range.
    """
    check_period("control_period", control_period)
    return Timing(control_period, control_period / ceil(control_period / longest_plant_step(airframe) - MULTIPLE))


def check_plant_step(timing: Timing, airframe: Airframe) -> None:
    """Refuse a plant step beyond `longest_plant_step`; InputError with the key."""
    longest = longest_plant_step(airframe)
    if timing.plant_step > longest * (1.0 + MULTIPLE):
        raise InputError(
            f"given {timing.plant_step:g} s; the rotors of '{airframe.name}' have a lag of {2.0 * longest:g} s, so allowed: up "
            f"to {longest:g} s",
            key="plant_step",
        )


def check_multiple(period: float, part: float, key: str, of: str) -> None:
    """Refuse a time that is no multiple of another; key, of: their names."""
    count = round(period / part)
    if count < 1 or abs(count * part - period) > MULTIPLE * period:
        near, shorter = max(count, 1) * part, period / ceil(period / part)
        other = f", or plant_step = {shorter:.12g}" if of == "plant_step" else ""
        raise InputError(
            f"given {period:g} s; this must be a multiple of {of} = {part:g} s: write {near:g} s{other}", key=key
        )
