"""Periods of a controller and of its plant: which are flown, and which go together."""

from plant.airframes import Airframe
from plant.closed_loop import Timing
from plant.errors import InputError

# Periods are multiples if they are so within rounding.
MULTIPLE = 1e-9
# Shortest and longest period [s]: beyond either a digit slipped.
SHORTEST, LONGEST = 1e-5, 0.1


def timing_of(control_period: float, plant_step: float) -> Timing:
    """Return the periods [s]; InputError with the key where one is out of range or the first no multiple of the second."""
    for key, value in (("control_period", control_period), ("plant_step", plant_step)):
        if not SHORTEST <= value <= LONGEST:
            raise InputError(f"given {value:g} s; allowed: {SHORTEST:g} s to {LONGEST:g} s", key=key)
    check_multiple(control_period, plant_step, "control_period", "plant_step")
    return Timing(control_period, plant_step)


def check_plant_step(timing: Timing, airframe: Airframe) -> None:
    """Keep the integrator accurate on the fastest thing it integrates; it is unstable beyond 2.8 times the rotor lag."""
    lag = min(airframe.vehicle.lag_up, airframe.vehicle.lag_down)
    if timing.plant_step > 0.5 * lag:
        raise InputError(
            f"given {timing.plant_step:g} s; the rotors of '{airframe.name}' have a lag of {lag:g} s, so allowed: up to "
            f"{0.5 * lag:g} s",
            key="plant_step",
        )


def check_multiple(whole: float, part: float, key: str, of: str) -> None:
    """Refuse a time that is no multiple of another; key, of: their names."""
    count = round(whole / part)
    if count < 1 or abs(count * part - whole) > MULTIPLE * whole:
        near = max(count, 1) * part
        raise InputError(
            f"given {whole:g} s; this must be a multiple of {of} = {part:g} s, for instance {near:g} s", key=key
        )
