"""Betaflight's active disturbance rejection: the equations of its rate loop.

    y_f = LP2(y),   e = z1 - y_f,   b = b0 s(t/h)
    z1 += T (z2 - 3 wo e),   z2 += T (z3 + b u - z2/tau - 3 wo^2 e),   z3 += -T (sigma z3 + wo^3 e)
    u = (wc^2 (r - z1) - 2 zeta wc z2 - z3)/b

    symbol  meaning                                              unit
    y, r    angular rate from the gyro, and its setpoint         deg/s
    z1..z3  estimates of rate, acceleration and disturbance      deg/s, deg/s2, deg/s3
    u       output of the axis, 1000 for the range of a motor    1
    wc, wo  bandwidths of the feedback and of the observer       rad/s
    b0      gain from u to y'' at hover                          deg/s3
    s(x)    schedule of b0 over the collective t, hover h        1
    sigma   leak of z3                                           1/s
    tau     pole of the motors in the observer, 0 for none       s
    zeta    damping ratio of the feedback, 1 in most builds      1
    T       period of the loop                                   s

All right-hand sides are of the loop before. Before lift-off the gate is shut: b u is left out, sigma is the leak on the ground,
and an update that makes |z3| larger is dropped, in the pull request's head of August at idle throttle alone. Betaflight pull
request 15400, src/main/flight/adrc.c of build b11 and at 6317fe2a; tau as in the notes of builds mp1 and mp2, zeta as in those
of b11, whose code is not published. Resets at values that are not finite are left out: inputs are finite.
"""

from typing import NamedTuple

from plant.laws.filters import stages_share, step_stage
from plant.primitives import absolute, both, clip, either, maximum, minimum, select, sqrt

MAX_RATE = 8000.0
"""Limit of |z1| [deg/s]."""
MAX_ACCELERATION = 1e5
"""Limit of |z2| [deg/s2]."""
CRITICAL_DAMPING = 2.0
"""Gain of z2 over wc at a damping ratio of 1."""
MAX_STEP = 0.5
"""Limit of wo T."""
MIN_HOVER = 0.05
"""Lower limit of the hover throttle in the schedule."""
THROTTLE_CUTOFF = 2.0
"""Cut-off of the low-pass on the collective [Hz]."""
IDLE_SHARE = 0.5
"""Commanded collective below which the throttle is idle, over the one that opens the gate."""
MIN_APPLIED_HOLD = 0.25
"""Lower limit of the time that applied collective alone takes to open the gate [s]."""
MIN_GROUND_LEAK = 1.0
"""Lower limit of the leak on the ground [1/s]."""
SCHEDULES = {"QUADRATIC": 0.0, "SQRT": 1.0, "LINEAR": 2.0, "FIXED": 3.0}
"""Schedules of b0 by the words of the command line, with the numbers of the firmware."""


class AxisConstants(NamedTuple):
    """Constants of an axis.

    Attributes:
        wc: Bandwidth of the feedback in flight [rad/s].
        ground_wc: The same on the ground [rad/s].
        wo: Bandwidth of the observer [rad/s].
        b0: Gain at hover [deg/s3].
        share: Share of each stage of the gyro's low-pass.
        reference_share: Share of the low-pass on the setpoint, 0 for none.
        leak: Leak of z3 in the air [1/s].
        ground_leak: Leak of z3 on the ground [1/s].
        inverse_tau: Pole of the motors [1/s], 0 for none.
        limit: Limit of the output.
        damping: Gain of z2 over wc, twice the damping ratio.
    """

    wc: float
    ground_wc: float
    wo: float
    b0: float
    share: float
    reference_share: float
    leak: float
    ground_leak: float
    inverse_tau: float
    limit: float
    damping: float


class AxisMemory(NamedTuple):
    """State of an axis: low-pass, estimates, filtered setpoint, output of the loop before."""

    stage1: float
    stage2: float
    z1: float
    z2: float
    z3: float
    reference: float
    output: float


class GateConstants(NamedTuple):
    """Constants of gate and schedule.

    Attributes:
        throttle: Collective that opens the gate, 0 to 1.
        rate: Rate that opens it [deg/s].
        hold: Time that the rate takes [s].
        applied_hold: Time that the applied collective takes [s], infinite where it opens nothing.
        idle_only: 1 where |z3| may grow on the ground above idle throttle, 0 where it may not.
        ramp: Blend of wc per second, 0 for a step.
        throttle_share: Share of the low-pass on the collective.
        hover: Collective at hover, 0 to 1.
        schedule: Number of the schedule.
        min_scale: Lower limit of the scale in the air.
        max_scale: Upper limit of the scale.
    """

    throttle: float
    rate: float
    hold: float
    applied_hold: float
    idle_only: float
    ramp: float
    throttle_share: float
    hover: float
    schedule: float
    min_scale: float
    max_scale: float


class Gate(NamedTuple):
    """State that the axes share: is_open (1 or 0), timers [s], blend of wc, filtered collective and scale of b0.

    On the ground `stops` is 1 where |z3| may not grow.
    """

    is_open: float
    stops: float
    rate_time: float
    applied_time: float
    blend: float
    collective: float
    scale: float


class Terms(NamedTuple):
    """Terms of the output."""

    p: float
    i: float
    d: float


def observer_bandwidth(wo: float, period: float) -> float:
    """Return wo within the limit of the loop period [rad/s]."""
    return minimum(wo, MAX_STEP / period)


def gyro_share(cutoff: float, period: float) -> float:
    """Return the share of each of two stages of the gyro's low-pass; cutoff [Hz], 0 for none."""
    return stages_share(cutoff, 2.0, period)


def ground_bandwidth(ground_wc: float, gain: float, wc: float, wo: float, b0: float) -> float:
    """Return wc on the ground [rad/s].

    Args:
        ground_wc: Upper limit [rad/s], 0 to fly with wc.
        gain: Upper limit of 2 wc wo/b0, the output per deg/s of noise, 0 for none.
        wc: Bandwidth of the feedback in flight [rad/s].
        wo: Bandwidth of the observer [rad/s].
        b0: Gain at hover [deg/s3].
    """
    by_gain = select(gain > 0.0, gain * b0 / (2.0 * wo), wc)
    return select(ground_wc > 0.0, minimum(minimum(ground_wc, wc), by_gain), wc)


def schedule_scale(schedule: float, ratio: float) -> float:
    """Return the scale of b0 before its limits; ratio: collective over that of hover."""
    root = sqrt(maximum(ratio, 0.0))
    rest = select(schedule > 2.5, 1.0, ratio)
    return select(schedule < 0.5, ratio * ratio, select(schedule < 1.5, root, rest))


def limited_scale(scale: float, is_open: float, constants: GateConstants) -> float:
    """Return the scale within its limits; it is at least 1 while the gate is shut."""
    return clip(scale, select(is_open > 0.5, constants.min_scale, 1.0), constants.max_scale)


def step_gate(
    gate: Gate, constants: GateConstants, peak: float, applied: float, commanded: float, period: float
) -> Gate:
    """Advance gate and schedule by one loop.

    Args:
        gate: State after the loop before.
        constants: Thresholds and schedule.
        peak: Largest |rate| of the three axes [deg/s].
        applied: Collective after the mixer in the loop before, 0 to 1.
        commanded: Collective before the headroom of airmode, 0 to 1.
        period: Period of the loop [s].
    """
    by_command = commanded >= constants.throttle
    is_above_idle = commanded >= constants.throttle * IDLE_SHARE
    is_turning = both(peak > constants.rate, is_above_idle)
    rate_time = select(by_command, gate.rate_time, select(is_turning, gate.rate_time + period, 0.0))
    by_rate = both(is_turning, rate_time >= constants.hold)
    is_lifting = both(applied >= constants.throttle, is_above_idle)
    applied_time = select(is_lifting, gate.applied_time + period, 0.0)
    by_applied = both(is_lifting, applied_time >= constants.applied_hold)
    was_open = gate.is_open > 0.5
    is_open = select(either(either(was_open, by_command), either(by_rate, by_applied)), 1.0, 0.0)
    ramped = select(constants.ramp > 0.0, minimum(1.0, gate.blend + period * constants.ramp), 1.0)
    collective = step_stage(gate.collective, applied, constants.throttle_share)
    scale = schedule_scale(constants.schedule, collective / maximum(constants.hover, MIN_HOVER))
    may_grow = both(constants.idle_only > 0.5, is_above_idle)
    return Gate(
        is_open,
        select(either(is_open > 0.5, may_grow), 0.0, 1.0),
        select(was_open, gate.rate_time, rate_time),
        select(was_open, gate.applied_time, applied_time),
        select(is_open > 0.5, ramped, 0.0),
        collective,
        limited_scale(scale, is_open, constants),
    )


def released(memory: AxisMemory, before: Gate, after: Gate) -> AxisMemory:
    """Return the state of an axis, without output where the gate opens."""
    opens = both(before.is_open < 0.5, after.is_open > 0.5)
    return with_output(memory, select(opens, 0.0, memory.output))


def with_output(memory: AxisMemory, output: float) -> AxisMemory:
    """Return the state of an axis with the output that was applied."""
    stages = memory.stage1, memory.stage2
    return AxisMemory(*stages, memory.z1, memory.z2, memory.z3, memory.reference, output)


def limited_rate(z1: float, constants: AxisConstants) -> float:  # noqa: ARG001
    """The estimate of the rate within its limit."""
    return clip(z1, -MAX_RATE, MAX_RATE)


def limited_acceleration(z2: float, constants: AxisConstants) -> float:  # noqa: ARG001
    """The estimate of the acceleration within its limit."""
    return clip(z2, -MAX_ACCELERATION, MAX_ACCELERATION)


def limited_disturbance(output: float, constants: AxisConstants) -> float:
    """The output that cancels the disturbance within the limit of the sum."""
    return clip(output, -constants.limit, constants.limit)


def observe(
    memory: AxisMemory, constants: AxisConstants, b: float, gate: Gate, inhibited: float, rate: float, period: float
) -> AxisMemory:
    """Advance low-pass and observer by one loop.

    Args:
        memory: State after the loop before.
        constants: Constants of the axis.
        b: Scheduled gain [deg/s3].
        gate: Gate of this loop.
        inhibited: 1 where |z3| may not grow in the air.
        rate: Rate from the gyro [deg/s].
        period: Period of the loop [s].
    """
    stage1 = step_stage(memory.stage1, rate, constants.share)
    stage2 = step_stage(memory.stage2, stage1, constants.share)
    error, wo = memory.z1 - stage2, constants.wo
    is_flying = gate.is_open > 0.5
    push = select(is_flying, b * memory.output, 0.0) - constants.inverse_tau * memory.z2
    z1 = memory.z1 + period * (memory.z2 - 3.0 * wo * error)
    z2 = memory.z2 + period * (memory.z3 + push - 3.0 * wo * wo * error)
    leaked = memory.z3 - period * select(is_flying, constants.leak, constants.ground_leak) * memory.z3
    updated = leaked - period * (wo * wo * wo) * error
    grows = absolute(updated) > absolute(leaked)
    z3 = select(both(either(gate.stops > 0.5, inhibited > 0.5), grows), leaked, updated)
    return AxisMemory(
        stage1,
        stage2,
        limited_rate(z1, constants),
        limited_acceleration(z2, constants),
        b * limited_disturbance(z3 / b, constants),
        memory.reference,
        memory.output,
    )


def damping_gain(wc: float, constants: AxisConstants) -> float:
    """Return the gain of z2 [1/s]: 2 zeta wc, less the pole of the motors but at least half of wc."""
    full, pole = constants.damping * wc, constants.inverse_tau
    return select(pole > 0.0, maximum(full - pole, 0.5 * wc), full)


def feedback(memory: AxisMemory, constants: AxisConstants, blend: float, b: float) -> Terms:
    """Return the terms of the output, none of them limited by itself."""
    wc = constants.ground_wc + (constants.wc - constants.ground_wc) * blend
    return Terms(
        wc * wc * (memory.reference - memory.z1) / b,
        -memory.z3 / b,
        -damping_gain(wc, constants) * memory.z2 / b,
    )


def step_axis(
    memory: AxisMemory,
    constants: AxisConstants,
    gate: Gate,
    rate: float,
    setpoint: float,
    inhibited: float,
    period: float,
) -> tuple[Terms, AxisMemory]:
    """Return the terms of an axis, and its state after the loop; the mixer then gives `output`.

    Args:
        memory: State after the loop before, with the output that was applied then.
        constants: Constants of the axis.
        gate: Gate and schedule of this loop.
        rate: Rate from the gyro [deg/s].
        setpoint: Rate setpoint [deg/s].
        inhibited: 1 where |z3| may not grow in the air.
        period: Period of the loop [s].
    """
    b = constants.b0 * gate.scale
    observed = observe(memory, constants, b, gate, inhibited, rate, period)
    filtered = step_stage(memory.reference, setpoint, constants.reference_share)
    reference = select(constants.reference_share > 0.0, filtered, setpoint)
    referred = AxisMemory(*observed[:5], reference, observed.output)
    return feedback(referred, constants, gate.blend, b), referred


def seeded(rate: float) -> AxisMemory:
    """Return the state after a reset at a rate [deg/s]."""
    return AxisMemory(rate, rate, rate, 0.0, 0.0, rate, 0.0)


SHUT = Gate(0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
"""Gate after arming."""
