"""Betaflight with ADRC: level gain around a rate loop with observer, the law of pull request 15400 in flight.

    w_sp = LP3(angle_p/10 (r - y)) + r',    w = LP1(LP1(y')),    e = z1 - LP2(w),    b = s(t/h) b_0
    z1' = z2 - 3 wo e,    z2' = z3 + b v - z2/tau - 3 wo^2 e,    z3' = -sigma z3 - wo^3 e
    v = (wc^2 (w_sp - z1) - 2 wc z2 - z3)/b,    |v| <= limit,    b0 u = authority v

Use it for a vehicle that flies `pid_type = ADRC`: its gains are the settings. In a simulated flight the gate is open, and the
collective t of the schedule is that of hover, as `authority`, the acceleration that a unit of output v gives, is. A leak
sigma leaves a small error under a constant disturbance. The equations by loop are in `equations.py`.
Betaflight pull request 15400: src/main/flight/adrc.c, build b11; src/main/flight/pid.c.
"""

from dataclasses import replace
from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.filters import Stages, settled_stages, stage_share, stages_share, step_stage, step_stages
from plant.laws.law import Blocks, Law, Span
from plant.primitives import clip, maximum, minimum, select
from tuner.extensions.autopilots.law_parts import bounded, gain_rows
from tuner.extensions.betaflight import betaflight_law
from tuner.extensions.betaflight.betaflight_law import DEGREES, on_airframe
from tuner.extensions.betaflight_adrc.equations import (
    CRITICAL_DAMPING,
    MAX_STEP,
    AxisConstants,
    AxisMemory,
    Gate,
    gyro_share,
    limited_acceleration,
    limited_disturbance,
    limited_rate,
    schedule_scale,
    step_axis,
    with_output,
)

SOURCE = "Betaflight pull request 15400, src/main/flight/adrc.c of build b11"
MIN_SCALE = 1.0


class Gains(NamedTuple):
    """angle_p [0.1/s], angle_cutoff, gyro_lpf1, gyro_lpf2, lpf [Hz]; wc, wo [rad/s]; b0 [deg/s3]; schedule, hover [%],
    scale_max [1]; sigma [0.1/s]; tau [s]; limit [1]; throttle [1]; authority [y/s2].
    """

    angle_p: float
    angle_cutoff: float
    gyro_lpf1: float
    gyro_lpf2: float
    lpf: float
    wc: float
    wo: float
    b0: float
    schedule: float
    hover: float
    scale_max: float
    sigma: float
    tau: float
    limit: float
    throttle: float
    authority: float


class Constants(NamedTuple):
    """Level gain [1/s], shares of filters, observer, scale, limit, authority [y/s2]."""

    outer: float
    angle: float
    order: float
    gyro1: float
    gyro2: float
    axis: AxisConstants
    scale: float
    limit: float
    authority: float


class Memory(NamedTuple):
    """Stages of the level gain's low-pass [deg/s], gyro's filters [deg/s], observer."""

    angle: Stages
    gyro1: float
    gyro2: float
    axis: AxisMemory


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the filters; the observer is no faster than half the loop."""
    wo = minimum(gains.wo, MAX_STEP / h)
    inverse_tau = select(gains.tau > 0.0, 1.0 / select(gains.tau > 0.0, gains.tau, 1.0), 0.0)
    raw = schedule_scale(gains.schedule, 100.0 * gains.throttle / maximum(gains.hover, 5.0))
    leak = 0.1 * gains.sigma
    axis = AxisConstants(
        gains.wc,
        gains.wc,
        wo,
        gains.b0,
        gyro_share(gains.lpf, h),
        0.0,
        leak,
        leak,
        inverse_tau,
        gains.limit,
        CRITICAL_DAMPING,
    )
    return Constants(
        0.1 * gains.angle_p,
        stages_share(gains.angle_cutoff, 3.0, h),
        select(gains.angle_cutoff > 0.0, 3.0, 0.0),
        stage_share(gains.gyro_lpf1, h),
        stage_share(gains.gyro_lpf2, h),
        axis,
        clip(raw, MIN_SCALE, gains.scale_max),
        gains.limit,
        gains.authority,
    )


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Steady: z3 holds the plant, the filters are settled at the measured rate."""
    rate, output = DEGREES * measured.rate, held / constants.authority
    z3 = 0.0 - constants.axis.b0 * constants.scale * output
    return Memory(settled_stages(0.0), rate, rate, AxisMemory(rate, rate, rate, 0.0, z3, 0.0, output))


def limited_output(output: float, constants: Constants) -> float:
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
    """One control period; the observer takes the limited output of the period before."""
    gyro2 = step_stage(memory.gyro2, DEGREES * measured.rate, constants.gyro2)
    gyro1 = step_stage(memory.gyro1, gyro2, constants.gyro1)
    level = DEGREES * constants.outer * (setpoint.value - measured.value)
    angle_rate, angle = step_stages(memory.angle, level, constants.angle, constants.order)
    rate_setpoint = angle_rate + DEGREES * setpoint.rate
    gate = Gate(1.0, 0.0, 0.0, 0.0, 1.0, 1.0, constants.scale)
    terms, axis = step_axis(memory.axis, constants.axis, gate, gyro1, rate_setpoint, 0.0, h)
    output = limited_output(terms.p + terms.i + terms.d, constants)
    return constants.authority * output / channel.b0, Memory(angle, gyro1, gyro2, with_output(axis, output))


row = gain_rows(SOURCE)
OF_BETAFLIGHT = {info.name: replace(info, source=SOURCE) for info in betaflight_law.LAW.gains}
"""Gains of Betaflight's law: its level gain and the filters of the gyro are the same."""

LAW = Law(
    name="betaflight_adrc",
    title="Betaflight with ADRC: level gain, observer of the rate (pull request 15400)",
    blocks=Blocks("level gain, PD, minus z3", measured="low-passes, observer", takes_command=True),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        *(OF_BETAFLIGHT[name] for name in ("angle_p", "angle_cutoff", "gyro_lpf1", "gyro_lpf2")),
        row(
            "lpf", "adrc_gyro_lpf_hz", Span(150.0, 50.0, 400.0), Span(0.0, 0.0, 400.0),
            meaning="cut-off of the second-order low-pass ahead of the observer, 0 for none", unit="Hz", resolution=1.0,
        ),
        row(
            "wc", "adrc_wc_*", Span(60.0, 10.0, 150.0), Span(10.0, 5.0, 20.0),
            meaning="bandwidth of the feedback of the rate", unit="rad/s", scale="log", exclusive=True, resolution=1.0,
        ),
        row(
            "wo", "adrc_wo_*", Span(100.0, 20.0, 250.0), Span(20.0, 10.0, 40.0),
            meaning="bandwidth of the observer", unit="rad/s", scale="log", exclusive=True, resolution=1.0,
        ),
        row(
            "b0", "adrc_b0_*", Span(2000.0, 300.0, 30000.0), Span(30.0, 10.0, 100.0),
            meaning="angular jerk that a unit of output gives, in deg/s3", unit="1", scale="log", exclusive=True, resolution=1.0,
        ),
        row(
            "schedule", "adrc_b0_law", Span(1.0, 0.0, 3.0),
            meaning="schedule of b0 over the throttle: 0 quadratic, 1 root, 2 linear, 3 fixed", resolution=1.0,
        ),
        row(
            "hover", "adrc_hover_throttle", Span(35.0, 5.0, 100.0),
            meaning="throttle from which on the schedule raises b0", unit="%", exclusive=True, resolution=1.0,
        ),
        row(
            "scale_max", "adrc_b0_scale_max", Span(3.0, 1.0, 50.0),
            meaning="upper limit of the scale of b0", exclusive=True, resolution=1.0,
        ),
        row(
            "sigma", "adrc_sigma_decay", Span(3.0, 0.0, 100.0),
            meaning="leak of the disturbance estimate, in 0.1/s", unit="1", resolution=1.0,
        ),
        row(
            "tau", "adrc_motor_tau_ms", Span(0.0, 0.0, 0.1),
            meaning="motor lag in the observer, 0 for none", unit="s", resolution=0.001,
        ),
        row(
            "limit", "pidsum_limit", Span(500.0, 100.0, 1000.0),
            meaning="limit of the output", scale="log", exclusive=True, firmware=True,
        ),
        OF_BETAFLIGHT["throttle"],
        OF_BETAFLIGHT["authority"],
    ),
    sampling="low-passes: backward Euler; observer: forward Euler, all from the period before",
    promises=frozenset(),
    limits=(limited_output, limited_rate, limited_acceleration, limited_disturbance),
    winds_up=True,
    shared={
        "angle_p": ("roll", "pitch"),
        **dict.fromkeys(("gyro_lpf1", "gyro_lpf2", "lpf", "schedule", "hover", "scale_max", "sigma"), ("roll", "pitch", "yaw")),
        "tau": ("roll", "pitch"),
    },
    axes={
        "yaw": {
            "angle_p": Span(20.0, 5.0, 100.0),
            "angle_cutoff": Span(0.0, 0.0, 100.0),
            "wo": Span(80.0, 20.0, 250.0),
            "limit": Span(400.0, 100.0, 1000.0),
        },
    },
    on_airframe=on_airframe,
)  # fmt: skip
