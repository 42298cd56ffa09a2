"""Notches that follow the rotors and remove their harmonics from the gyro.

For every rotor, at 1 to 3 times its measured speed, a notch of quality Q on all three axes, one behind the other. The speed is
that of telemetry behind a first-order low-pass. Below a least frequency there is no notch; half of it above, a notch is whole,
and in between its share grows: the rest of the signal stays as it came. A notch stops at 0.48 of the control rate.

The rpm filter of Betaflight 2025.12 has this form (src/main/flight/rpm_filter.c: Q 5, from 100 Hz, whole at 150 Hz, telemetry
at 150 Hz) and moves each notch within 1 ms; here all of them move with every period. ArduPilot's harmonic notch (INS_HNTCH_*)
with one notch a motor and PX4's (IMU_GYRO_DNF_*) differ at the ends: the former stays at its least frequency, the latter keeps
its width instead of Q.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from plant.laws.filters import Delays, Section, notch_by_q, stage_share, step_section, step_stage
from plant.primitives import clip, minimum
from plant.quadrotor.gyro import Filtered, NoState, keep_nothing
from plant.quadrotor.sensors import Measurement
from plant.records import record_type
from plant.vectors import Rotors, Vec3

MAX_NOTCHES = 3
# Cut-off of the low-pass on measured speeds [Hz], and highest notch over the control rate.
TELEMETRY, HIGHEST = 150.0, 0.48
TURN = 6.283185307179586


class RpmNotches(NamedTuple):
    """quality [1]; least: frequency from which on notches begin [Hz]; share of a new speed that a period takes over [1]."""

    quality: float
    least: float
    share: float


class Harmonic(NamedTuple):
    """Memory of the notches at one harmonic, a rotor each."""

    one: Filtered
    two: Filtered
    three: Filtered
    four: Filtered


class Notches(NamedTuple):
    """Notches as model functions.

    Memory: type of their state. start(speed) -> Memory of a vehicle that does not turn. follow(memory, m, speed, nominal, h) ->
    (Measurement, Memory). speed: of the rotors [rad/s].
    """

    Memory: Any
    start: Callable[..., Any]
    follow: Callable[..., Any]


def rpm_notches(quality: float, least: float, control_period: float) -> RpmNotches:
    """Return notches of a quality, from a least frequency [Hz] on, at a control period [s]."""
    return RpmNotches(quality, least, stage_share(TELEMETRY, control_period))


def weight_of(frequency: float, least: float) -> float:
    """Weight [1] of a notch at a frequency [Hz]: 0 up to the least one, 1 from half of that above it."""
    return clip(2.0 * (frequency - least) / least, 0.0, 1.0)


def step_weighted(state: Any, x: float, section: Section, weight: float) -> tuple[float, Any]:
    """A signal of which a share goes through a section, and what that keeps."""
    y, after = step_section(state, x, section)
    return x + weight * (y - x), after


def notch_rotor(
    state: Filtered, rate: Vec3, speed: float, harmonic: float, numbers: RpmNotches, h: float
) -> tuple[Vec3, Filtered]:
    """A rate [rad/s] behind the notch at a harmonic of a rotor's speed [rad/s], and what it keeps."""
    frequency = minimum(harmonic * speed / TURN, HIGHEST / h)
    section, weight = notch_by_q(frequency, numbers.quality, h), weight_of(frequency, numbers.least)
    x, kept_x = step_weighted(state.x, rate.x, section, weight)
    y, kept_y = step_weighted(state.y, rate.y, section, weight)
    z, kept_z = step_weighted(state.z, rate.z, section, weight)
    return Vec3(x, y, z), Filtered(kept_x, kept_y, kept_z)


def notch_all(
    state: Harmonic, rate: Vec3, speed: Rotors, harmonic: float, numbers: RpmNotches, h: float
) -> tuple[Vec3, Harmonic]:
    """A rate behind the notches at a harmonic of all rotors, and what they keep."""
    past_one, one = notch_rotor(state.one, rate, speed.r1, harmonic, numbers, h)
    past_two, two = notch_rotor(state.two, past_one, speed.r2, harmonic, numbers, h)
    past_three, three = notch_rotor(state.three, past_two, speed.r3, harmonic, numbers, h)
    past_four, four = notch_rotor(state.four, past_three, speed.r4, harmonic, numbers, h)
    return past_four, Harmonic(one, two, three, four)


def empty() -> Harmonic:
    """Memory of notches that have heard no rate."""
    none = Delays(0.0, 0.0)
    still = Filtered(none, none, none)
    return Harmonic(still, still, still, still)


def filter_speeds(state: Rotors, speed: Rotors, share: float) -> Rotors:
    """Speeds of the rotors as telemetry tells them, behind its low-pass."""
    return Rotors(
        step_stage(state.r1, speed.r1, share),
        step_stage(state.r2, speed.r2, share),
        step_stage(state.r3, speed.r3, share),
        step_stage(state.r4, speed.r4, share),
    )


def skip(
    state: NoState,
    rate: Vec3,
    speed: Rotors,
    harmonic: float,
    numbers: RpmNotches,
    h: float,  # noqa: ARG001
) -> tuple[Vec3, NoState]:
    """Leave a rate as it is."""
    return rate, state


def with_rate(m: Measurement, rate: Vec3) -> Measurement:
    """Return a measurement with another rate."""
    return Measurement(m.position, m.velocity, m.angles, rate, m.thrust_direction, m.heading)


def no_notches() -> Notches:
    """Return notches that leave measurements as they are and keep nothing."""

    def start(speed: Rotors) -> NoState:  # noqa: ARG001
        return NoState()

    def follow(
        state: NoState,
        m: Measurement,
        speed: Rotors,
        nominal: Any,
        h: float,  # noqa: ARG001
    ) -> tuple[Measurement, NoState]:
        return m, state

    return Notches(NoState, start, follow)


def notches_of(harmonics: int) -> Notches:
    """Return the notches at so many harmonics of each rotor, 0 to 3."""
    if harmonics == 0:
        return no_notches()
    present, absent = (Harmonic, empty, notch_all), (NoState, keep_nothing, skip)
    First, first_start, first_step = present
    Second, second_start, second_step = present if harmonics > 1 else absent
    Third, third_start, third_step = present if harmonics > 2 else absent
    Memory = record_type("NotchMemory", {"speed": Rotors, "first": First, "second": Second, "third": Third})

    def start(speed: Rotors) -> Any:
        return Memory(speed, first_start(), second_start(), third_start())

    def follow(state: Any, m: Measurement, speed: Rotors, nominal: Any, h: float) -> tuple[Measurement, Any]:
        numbers = nominal.notches
        seen = filter_speeds(state.speed, speed, numbers.share)
        past_first, first = first_step(state.first, m.rate, seen, 1.0, numbers, h)
        past_second, second = second_step(state.second, past_first, seen, 2.0, numbers, h)
        past_third, third = third_step(state.third, past_second, seen, 3.0, numbers, h)
        return with_rate(m, past_third), Memory(seen, first, second, third)

    return Notches(Memory, start, follow)
