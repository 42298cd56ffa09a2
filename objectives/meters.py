"""Meters that judge a flight while it flies: one update per control instant, constant memory.

Model functions (see `plant.primitives`): a backend runs these very functions inside its loop. Each update is one
control instant t = k h, k = 0..N-1; e = reference - actual. The sums are left Riemann sums, so their error against
the integral over [0, N h] is O(h). `objectives.metrics` turns the final meters into metrics with units.

ITAE: D. Graham, R. C. Lathrop, "The synthesis of optimum transient response: criteria and standard forms", Trans.
AIEE, part II, vol. 72, no. 5, 1953. Rise, overshoot and settling as in K. J. Astrom, R. M. Murray, "Feedback
Systems", 2nd ed., Princeton University Press, 2021, section 6.3.

When a flight fails the caller keeps the whole tuple as it stands; nothing here looks at a failure.
"""

from typing import NamedTuple

from plant.primitives import absolute, maximum, select, sign
from plant.quadrotor.sample import Sample, Targets
from plant.sample import AxisSample, Target
from plant.vectors import Rotors, axpy_rotors, rotors_dot

NEVER = -1.0
"""Time of a crossing that has not happened; flights start at t = 0, so no real time is negative."""

RISE_LOW = 0.1
RISE_HIGH = 0.9

# t = k h and a moment from a study differ by rounding (75 * 0.004 < 0.1 + 0.2), which would drop a whole instant; a
# millionth of a period is far above rounding (some 1e-10 of a period at k = 1e6) and far below a period.
TIME_TOLERANCE = 1e-6


class AxisMeter(NamedTuple):
    """One axis, in its unit u (m or rad) and s.

    Attributes:
        itae: h sum t|e| [u s2], t from the start of the flight.
        iae: h sum |e| [u s].
        ise: h sum e^2 [u2 s].
        peak: max |e| [u].
        overshoot_extreme: the furthest that the actual value went past the final level since the step [u], 0 if
            it never did or the axis makes no step.
        rise_low_time, rise_high_time: when 10 % and 90 % of the step were first passed, interpolated between
            instants [s], `NEVER` until then, both the time of the step if the axis makes none.
        previous: actual value one instant ago [u].
        last_outside: end of the last period since the step that began with |e| > band [s], the time of the step
            until then.
        last_unrecovered: the same since recovery_from with recovery_band.
        steady_sum: h sum e since steady_from [u s].
    """

    itae: float
    iae: float
    ise: float
    peak: float
    overshoot_extreme: float
    rise_low_time: float
    rise_high_time: float
    previous: float
    last_outside: float
    last_unrecovered: float
    steady_sum: float


class Meters(NamedTuple):
    """All that is metered on a flight.

    Attributes:
        x, y, z, roll, pitch, yaw: the six axes.
        travel: total variation of the rotor commands, summed over rotors, in hover thrusts.
        effort: h sum over rotors of (command - 1)^2 [s].
        saturated: time with a rotor at a limit [s].
        command_peak: the largest rotor command, in hover thrusts.
    """

    x: AxisMeter
    y: AxisMeter
    z: AxisMeter
    roll: AxisMeter
    pitch: AxisMeter
    yaw: AxisMeter
    travel: float
    effort: float
    saturated: float
    command_peak: float


def start_axis(sample: AxisSample, target: Target) -> AxisMeter:
    """Return one axis's meter before the first update."""
    return AxisMeter(0.0, 0.0, 0.0, 0.0, 0.0, NEVER, NEVER, sample.actual, target.time, target.recovery_from, 0.0)


def start(sample: Sample, targets: Targets) -> Meters:
    """Return the meters before the first update; sample is the one at t = 0, which the first update then judges."""
    return Meters(
        start_axis(sample.x, targets.x),
        start_axis(sample.y, targets.y),
        start_axis(sample.z, targets.z),
        start_axis(sample.roll, targets.roll),
        start_axis(sample.pitch, targets.pitch),
        start_axis(sample.yaw, targets.yaw),
        0.0,
        0.0,
        0.0,
        0.0,
    )


def since(moment: float, t: float, h: float, if_true: float, if_false: float) -> float:
    """Return if_true from the first instant t at or after the moment on, else if_false."""
    return select(t >= moment - TIME_TOLERANCE * h, if_true, if_false)


def last_beyond(last: float, moment: float, band: float, error: float, t: float, h: float) -> float:
    """Return t + h if this instant is outside the band at or after the moment, else what stood there before."""
    return since(moment, t, h, select(absolute(error) > band, t + h, last), last)


def crossing_time(latched: float, level: float, before: float, now: float, moment: float, t: float, h: float) -> float:
    """Return when the rising signal first reached the level at or after the moment, or `NEVER`; it stays latched.

    before and now: the signal at t - h and t. Between them it is taken as a straight line. A signal already past the
    level at the moment crosses it there.
    """
    # The divisor is 1 wherever the quotient is not used, so that no unused branch divides by zero.
    divisor = select(before < level, select(level <= now, now - before, 1.0), 1.0)
    periods_ago = select(before < level, (now - level) / divisor, 1.0)
    reached = select(level <= now, maximum(t - h * periods_ago, moment), NEVER)
    return select(latched < 0.0, since(moment, t, h, reached, NEVER), latched)


def update_axis(meter: AxisMeter, sample: AxisSample, target: Target, t: float, h: float) -> AxisMeter:
    """Return one axis's meter after the instant t."""
    error = sample.reference - sample.actual
    size = absolute(error)
    direction = sign(target.final - target.start)
    step = absolute(target.final - target.start)
    before = (meter.previous - target.start) * direction
    now = (sample.actual - target.start) * direction
    beyond = maximum(meter.overshoot_extreme, (sample.actual - target.final) * direction)
    return AxisMeter(
        meter.itae + h * t * size,
        meter.iae + h * size,
        meter.ise + h * error * error,
        maximum(meter.peak, size),
        since(target.time, t, h, beyond, meter.overshoot_extreme),
        crossing_time(meter.rise_low_time, RISE_LOW * step, before, now, target.time, t, h),
        crossing_time(meter.rise_high_time, RISE_HIGH * step, before, now, target.time, t, h),
        sample.actual,
        last_beyond(meter.last_outside, target.time, target.band, error, t, h),
        last_beyond(meter.last_unrecovered, target.recovery_from, target.recovery_band, error, t, h),
        meter.steady_sum + since(target.steady_from, t, h, h * error, 0.0),
    )


def update(meters: Meters, sample: Sample, targets: Targets, h: float) -> Meters:
    """Return the meters after the control instant that the sample shows; h is the control period [s]."""
    t = sample.time
    command = sample.command
    change = axpy_rotors(command, -1.0, sample.previous)
    departure = axpy_rotors(command, -1.0, Rotors(1.0, 1.0, 1.0, 1.0))
    largest = maximum(maximum(command.r1, command.r2), maximum(command.r3, command.r4))
    return Meters(
        update_axis(meters.x, sample.x, targets.x, t, h),
        update_axis(meters.y, sample.y, targets.y, t, h),
        update_axis(meters.z, sample.z, targets.z, t, h),
        update_axis(meters.roll, sample.roll, targets.roll, t, h),
        update_axis(meters.pitch, sample.pitch, targets.pitch, t, h),
        update_axis(meters.yaw, sample.yaw, targets.yaw, t, h),
        meters.travel + absolute(change.r1) + absolute(change.r2) + absolute(change.r3) + absolute(change.r4),
        meters.effort + h * rotors_dot(departure, departure),
        meters.saturated + h * sample.saturated,
        maximum(meters.command_peak, largest),
    )
