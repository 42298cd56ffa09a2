"""Betaflight: level gain around a rate PID in deg/s, D on the measurement, first-order low-passes, a notch, yaw's own filter.

    w_sp = LP3(angle_p/10 (r - y)) + r',    w = LP1(N(LP2(y'))),    w_d = LP_d2(LP_d1(w)),    e = w_sp - w
    output = 0.032029 LP_p(t_p p e) + I - 0.000529 t d w_d',    I' = 0.244381 i x e,    |I| <= i_limit,    |output| <= limit
    b0 u = authority output,    x = max(0, 1 - |w_sp - LP_x(w_sp)|/relax)
    t = 1 - tpa_rate (throttle - b)/(1 - b) above the breakpoint b

Use it for a vehicle that flies Betaflight: the gains are its settings, which `tuner import` reads and `tuner export` writes.

Angles and rates are in degrees; p, i, d and angle_p are the integers of the settings and yaw's I counts 2.5 times. I is in force
in the period in which it is formed; its limit and I-term relax, which stops it while the set point moves, keep it from winding
up. t is the attenuation by throttle (TPA), of D and with tpa_p of P, at the throttle that hovers, as `authority`,
the acceleration that a unit of output gives, is. Parts that act on sticks and large motions alone are absent: feed-forward, D
max, anti-gravity.
Betaflight 2025.12: src/main/flight/pid.c, pid_init.c, src/main/sensors/gyro_filter_impl.c, src/main/common/filter.c.
"""

from collections.abc import Mapping
from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.filters import (
    Delays,
    Section,
    Stages,
    notch_by_q,
    settled_section,
    settled_stages,
    stage_share,
    stages_share,
    step_section,
    step_stage,
    step_stages,
)
from plant.laws.law import Blocks, Law, Span
from plant.primitives import absolute, maximum, minimum, select
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.autopilots.law_parts import bounded, gain_rows, limited
from tuner.extensions.autopilots.scales import accelerations, betaflight_factors, command_slope, hover_share

SOURCE = "Betaflight 2025.12, src/main/flight/pid.c and src/main/cli/settings.c"
DEGREES = 57.29577951308232
P_SCALE, I_SCALE, D_SCALE = 0.032029, 0.244381, 0.000529
# Units of output that are the whole range of a motor.
FULL = 1000.0


class Gains(NamedTuple):
    """angle_p [0.1/s]; p, i, d [1]: integers of the settings; i_factor [1]; i_limit, limit [1]: of the integral and the sum;
    angle_cutoff, p_cutoff, gyro_lpf1, gyro_lpf2, notch, notch_cutoff, d_lpf1, d_lpf2 [Hz], 0 for none; authority [y/s2];
    relax [deg/s], 0 for none; relax_cutoff [Hz]; tpa_rate [%], tpa_breakpoint [us], tpa_p [1]: 1 where TPA acts on P too;
    throttle [1] at hover.
    """

    angle_p: float
    p: float
    i: float
    d: float
    i_factor: float
    i_limit: float
    limit: float
    angle_cutoff: float
    p_cutoff: float
    gyro_lpf1: float
    gyro_lpf2: float
    notch: float
    notch_cutoff: float
    d_lpf1: float
    d_lpf2: float
    relax: float
    relax_cutoff: float
    tpa_rate: float
    tpa_breakpoint: float
    tpa_p: float
    throttle: float
    authority: float


class Constants(NamedTuple):
    """Gains per rad, attenuated by throttle, and filters.

    Filters are shares of a new sample and a section; order: stages of the filter behind the level gain; relax [1/(y/s)]: share of
    the integral that a moving set point takes away.
    """

    outer: float
    p: float
    i: float
    d: float
    i_limit: float
    limit: float
    angle: float
    order: float
    p_share: float
    gyro1: float
    gyro2: float
    notch: Section
    d1: float
    d2: float
    relax: float
    relax_share: float
    authority: float


class Memory(NamedTuple):
    """integral [1]; what the filters keep [y/s]; derivative: rate behind the filters of D; asked: set point behind its own."""

    integral: float
    angle: Stages
    p: float
    gyro1: float
    gyro2: float
    notch: Delays
    d1: float
    derivative: float
    rate_setpoint: float


def attenuation(rate: float, breakpoint_: float, throttle: float) -> float:
    """Return the factor [1] of TPA at a throttle [1].

    Its rate is in %, its breakpoint in us, 1000 to 2000.
    """
    begins = minimum(maximum(0.001 * breakpoint_ - 1.0, 0.0), 0.99)
    return 1.0 - 0.01 * rate * maximum(throttle - begins, 0.0) / (1.0 - begins)


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the filters; the quality of the notch is that of its lower cut-off."""
    t = attenuation(gains.tpa_rate, gains.tpa_breakpoint, gains.throttle)
    below = maximum(gains.notch * gains.notch - gains.notch_cutoff * gains.notch_cutoff, 0.0)
    has_notch = below > 0.0
    quality = select(has_notch, gains.notch * gains.notch_cutoff / select(has_notch, below, 1.0), 0.0)
    return Constants(
        0.1 * gains.angle_p,
        DEGREES * P_SCALE * gains.p * select(gains.tpa_p > 0.5, t, 1.0),
        DEGREES * I_SCALE * gains.i_factor * gains.i,
        DEGREES * D_SCALE * gains.d * t,
        gains.i_limit,
        gains.limit,
        stages_share(gains.angle_cutoff, 3.0, h),
        select(gains.angle_cutoff > 0.0, 3.0, 0.0),
        stage_share(gains.p_cutoff, h),
        stage_share(gains.gyro_lpf1, h),
        stage_share(gains.gyro_lpf2, h),
        notch_by_q(gains.notch, quality, h),
        stage_share(gains.d_lpf1, h),
        stage_share(gains.d_lpf2, h),
        select(gains.relax > 0.0, DEGREES / select(gains.relax > 0.0, gains.relax, 1.0), 0.0),
        stage_share(gains.relax_cutoff, h),
        gains.authority,
    )


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Steady: the integral holds the plant, the filters are settled at the measured rate."""
    rate = measured.rate
    return Memory(
        held / constants.authority,
        settled_stages(0.0),
        0.0,
        rate,
        rate,
        settled_section(rate, constants.notch),
        rate,
        rate,
        0.0,
    )


def relaxed(error: float, motion: float, constants: Constants) -> float:
    """Return the error that the integral takes in.

    The set point is off its low-pass by a motion [y/s].
    """
    return error * maximum(1.0 - constants.relax * absolute(motion), 0.0)


def limited_sum(output: float, constants: Constants) -> float:
    """The output within its limit."""
    return bounded(output, constants.limit)


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,  # noqa: ARG001
    h: float,
) -> tuple[float, Memory]:
    """One control period; the integral takes effect at once."""
    gyro2 = step_stage(memory.gyro2, measured.rate, constants.gyro2)
    notched, kept_notch = step_section(memory.notch, gyro2, constants.notch)
    rate = step_stage(memory.gyro1, notched, constants.gyro1)
    d1 = step_stage(memory.d1, rate, constants.d1)
    derivative = step_stage(memory.derivative, d1, constants.d2)
    level = constants.outer * (setpoint.value - measured.value)
    angle_rate, kept_angle = step_stages(memory.angle, level, constants.angle, constants.order)
    wanted = angle_rate + setpoint.rate
    usual = step_stage(memory.rate_setpoint, wanted, constants.relax_share)
    error = wanted - rate
    proportional = step_stage(memory.p, constants.p * error, constants.p_share)
    integral = limited(memory.integral + h * constants.i * relaxed(error, wanted - usual, constants), constants)
    output = limited_sum(proportional + integral - constants.d * (derivative - memory.derivative) / h, constants)
    return constants.authority * output / channel.b0, Memory(
        integral, kept_angle, proportional, rate, gyro2, kept_notch, d1, derivative, usual
    )


def on_airframe(vehicle: Vehicle) -> Mapping[str, Mapping[str, float]]:
    """Return throttle at hover [1] and authority there about each axis."""
    rotors = actuation(vehicle)
    slope = command_slope(rotors, 0.0) / FULL
    return {
        "authority": accelerations(rotors, betaflight_factors(rotors), slope, vehicle, "Betaflight"),
        "throttle": dict.fromkeys(ATTITUDE_AXES, hover_share(rotors, 0.0)),
    }


row = gain_rows(SOURCE)

LAW = Law(
    name="betaflight",
    title="Betaflight: level gain, rate PID, gyro and D filters",
    blocks=Blocks("level gain, rate PID", measured="notch and low-passes"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        row(
            "angle_p", "angle_p_gain", Span(50.0, 10.0, 200.0), Span(10.0, 2.0, 50.0),
            meaning="rate setpoint per angle error, in 0.1/s", unit="1", resolution=1.0,
        ),
        row(
            "p", "p_*", Span(45.0, 1.0, 250.0),
            meaning="output per rate error, integer of the setting", unit="1", resolution=1.0,
        ),
        row(
            "i", "i_*", Span(80.0, 1.0, 250.0), Span(3.0, 1.0, 20.0),
            meaning="output per integrated rate error, integer of the setting", unit="1", resolution=1.0,
        ),
        row(
            "d", "d_*", Span(30.0, 0.0, 250.0),
            meaning="output per measured angular acceleration, integer of the setting", unit="1", resolution=1.0,
        ),
        row(
            "i_factor", "i_factor", Span(1.0, 0.5, 5.0),
            meaning="factor of I, 2.5 for yaw", scale="log", firmware=True,
        ),
        row(
            "i_limit", "i_limit", Span(400.0, 50.0, 500.0),
            meaning="limit of the integral: iterm_windup of pidsum_limit", firmware=True,
        ),
        row(
            "limit", "pidsum_limit", Span(500.0, 100.0, 1000.0),
            meaning="limit of the output", scale="log", firmware=True,
        ),
        row(
            "angle_cutoff", "angle_cutoff", Span(50.0, 0.0, 100.0), Span(0.0, 0.0, 100.0),
            meaning="cut-off of the third-order low-pass behind the level gain, 0 for none", unit="Hz", firmware=True,
        ),
        row(
            "p_cutoff", "yaw_lowpass_hz", Span(0.0, 0.0, 500.0),
            meaning="cut-off of the first-order low-pass on P, 0 for none", unit="Hz", firmware=True,
        ),
        row(
            "gyro_lpf1", "gyro_lpf1_static_hz", Span(250.0, 50.0, 500.0), Span(0.0, 0.0, 500.0),
            meaning="cut-off of the first low-pass on the gyro, first order, 0 for none", unit="Hz", resolution=1.0,
        ),
        row(
            "gyro_lpf2", "gyro_lpf2_static_hz", Span(500.0, 50.0, 1000.0), Span(0.0, 0.0, 1000.0),
            meaning="cut-off of the second low-pass on the gyro, first order, 0 for none", unit="Hz", resolution=1.0,
        ),
        row(
            "notch", "gyro_notch1_hz", Span(0.0, 0.0, 400.0),
            meaning="centre of the notch on the gyro, 0 for none", unit="Hz", cutoff=True, resolution=1.0,
        ),
        row(
            "notch_cutoff", "gyro_notch1_cutoff", Span(0.0, 0.0, 400.0),
            meaning="lower cut-off of that notch, 0 for none", unit="Hz", resolution=1.0,
        ),
        row(
            "d_lpf1", "dterm_lpf1_static_hz", Span(75.0, 20.0, 250.0), Span(75.0, 0.0, 250.0),
            meaning="cut-off of the first low-pass on D, first order, 0 for none", unit="Hz", resolution=1.0,
        ),
        row(
            "d_lpf2", "dterm_lpf2_static_hz", Span(150.0, 20.0, 500.0), Span(0.0, 0.0, 500.0),
            meaning="cut-off of the second low-pass on D, first order, 0 for none", unit="Hz", resolution=1.0,
        ),
        row(
            "relax", "iterm_relax", Span(8.0, 0.0, 8.0),
            meaning="motion of the rate asked for, deg/s, at which the integral stands still: 8 in angle mode, 0 for never",
            resolution=8.0,
        ),
        row(
            "relax_cutoff", "iterm_relax_cutoff", Span(15.0, 1.0, 50.0),
            meaning="cut-off of the low-pass that defines this motion", unit="Hz", scale="log", exclusive=True,
            resolution=1.0,
        ),
        row(
            "tpa_rate", "tpa_rate", Span(65.0, 0.0, 100.0), Span(0.0, 0.0, 100.0),
            meaning="what D loses up to full throttle", unit="%", resolution=1.0,
        ),
        row(
            "tpa_breakpoint", "tpa_breakpoint", Span(1350.0, 1000.0, 2000.0),
            meaning="throttle from which on D loses, 1000 to 2000", unit="us", resolution=1.0,
        ),
        row(
            "tpa_p", "tpa_mode", Span(0.0, 0.0, 1.0),
            meaning="1 where P loses as D does (PD), 0 for D alone", resolution=1.0,
        ),
        row(
            "throttle", "throttle", Span(0.4, 0.05, 1.0),
            meaning="throttle at hover, of 1", exclusive=True, airframe=True,
        ),
        row(
            "authority", "authority", Span(0.3, 0.01, 5.0), Span(0.03, 0.01, 0.1),
            meaning="angular acceleration that a unit of output gives",
        ),
    ),
    sampling="low-passes: backward Euler; notch: bilinear, centre exact; D: backward difference; integral: forward Euler, in "
    "force at once",
    promises=frozenset({"rejects"}),
    limits=(relaxed, limited, limited_sum),
    winds_up=True,
    shared={
        "angle_p": ("roll", "pitch"),
        "relax": ("roll", "pitch"),
        **dict.fromkeys(
            ("gyro_lpf1", "gyro_lpf2", "notch", "notch_cutoff", "d_lpf1", "d_lpf2", "relax_cutoff", "tpa_rate",
             "tpa_breakpoint", "tpa_p"), ATTITUDE_AXES,
        ),
    },
    axes={
        "pitch": {"p": Span(47.0, 1.0, 250.0), "i": Span(84.0, 1.0, 250.0), "d": Span(34.0, 0.0, 250.0)},
        "yaw": {
            "d": Span(0.0, 0.0, 250.0),
            "i_factor": Span(2.5, 1.0, 5.0),
            "i_limit": Span(320.0, 50.0, 500.0),
            "limit": Span(400.0, 100.0, 1000.0),
            "angle_p": Span(20.0, 5.0, 100.0),
            "angle_cutoff": Span(0.0, 0.0, 100.0),
            "p_cutoff": Span(100.0, 0.0, 500.0),
            "relax": Span(0.0, 0.0, 8.0),
        },
    },
    on_airframe=on_airframe,
)  # fmt: skip
