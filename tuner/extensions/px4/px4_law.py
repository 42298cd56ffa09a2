"""PX4: angle P around a rate PID, D on the derivative of the filtered rate, gyro and D low-passes and a notch.

    w_sp = angle_p (r - y) + r',    w = LP(N(y')),    a = LP_d(w')
    b0 u = authority tau,    tau = p (w_sp - w) + I - d a + ff w_sp
    I' = i (w_sp - w) max(0, 1 - ((w_sp - w)/400 deg/s)^2),  |I| <= i_limit

Use it for a vehicle that flies PX4: the gains are its parameters, which `tuner import` reads and `tuner export` writes.

tau is PX4's normalised torque, `authority` the angular acceleration that a unit of it gives the vehicle, so that p, i, d and ff
are MC_*RATE_P, _I, _D and _FF. I is in force one period after it is formed; it does not grow further where the allocation
saturates. In level flight the weight of yaw (MC_YAW_WEIGHT) cancels, see the source.

LP is a Butterworth low-pass of second order, LP_d one of first order (AlphaFilter; the description of IMU_DGYRO_CUTOFF still says
second), and the rate that is differentiated is the filtered one (pull request PX4/PX4-Autopilot#15018, 2020). PX4 filters and
differentiates at the gyro's own rate, often 8 kHz, and hands the last sample to the loop; here everything steps with the loop.
PX4 1.16:
src/lib/rate_control/rate_control.cpp, src/modules/mc_att_control/AttitudeControl, src/modules/sensors/vehicle_angular_velocity.
"""

from collections.abc import Mapping
from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.filters import (
    Delays,
    Section,
    low_pass,
    notch,
    settled_section,
    stage_share,
    step_section,
    step_stage,
)
from plant.laws.law import Blocks, Law, Span
from plant.primitives import maximum
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.autopilots.law_parts import gain_rows, limited, outward_stopped
from tuner.extensions.autopilots.scales import accelerations, linearized_slope, px4_factors

SOURCE = "PX4 1.16, src/lib/rate_control/rate_control.cpp and parameter metadata"
# Error of the rate at which nothing is integrated any more: 400 deg/s.
LARGEST_ERROR = 6.981317007977318


class Gains(NamedTuple):
    """angle_p [1/s]; p [s/y], i [1/y], d [s2/y], ff [s/y], i_limit [1]: of the normalised output; gyro_cutoff, d_cutoff, notch,
    notch_width [Hz], 0 for none; authority [y/s2]: acceleration that a unit of output gives.
    """

    angle_p: float
    p: float
    i: float
    d: float
    ff: float
    i_limit: float
    gyro_cutoff: float
    d_cutoff: float
    notch: float
    notch_width: float
    authority: float


class Constants(NamedTuple):
    """The gains, with filters as sampled sections; derivative: share of a new sample."""

    angle_p: float
    p: float
    i: float
    d: float
    ff: float
    i_limit: float
    gyro: Section
    derivative: float
    notch: Section
    authority: float


class Memory(NamedTuple):
    """integral [1]; previous: last filtered rate [y/s]; acceleration: filtered [y/s2]; state of the other filters."""

    integral: float
    previous: float
    gyro: Delays
    acceleration: float
    notch: Delays


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the filters."""
    return Constants(
        gains.angle_p,
        gains.p,
        gains.i,
        gains.d,
        gains.ff,
        gains.i_limit,
        low_pass(gains.gyro_cutoff, h),
        stage_share(gains.d_cutoff, h),
        notch(gains.notch, gains.notch_width, h),
        gains.authority,
    )


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Steady: the integral holds the plant, the filters are settled at the measured rate."""
    rate = measured.rate
    return Memory(
        held / constants.authority,
        rate,
        settled_section(rate, constants.gyro),
        0.0,
        settled_section(rate, constants.notch),
    )


def attenuated(error: float, constants: Constants) -> float:  # noqa: ARG001
    """Return the part of the rate error that is integrated."""
    share = error / LARGEST_ERROR
    return error * maximum(0.0, 1.0 - share * share)


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Memory]:
    """One control period; the integral takes effect one period after it is formed."""
    notched, kept_notch = step_section(memory.notch, measured.rate, constants.notch)
    rate, kept_gyro = step_section(memory.gyro, notched, constants.gyro)
    acceleration = step_stage(memory.acceleration, (rate - memory.previous) / h, constants.derivative)
    rate_setpoint = constants.angle_p * (setpoint.value - measured.value) + setpoint.rate
    error = rate_setpoint - rate
    output = constants.p * error + memory.integral - constants.d * acceleration + constants.ff * rate_setpoint
    integrated = attenuated(outward_stopped(error, channel.b0 * applied.excess, constants.authority), constants)
    integral = limited(memory.integral + h * constants.i * integrated, constants)
    command = constants.authority * output / channel.b0
    return command, Memory(integral, rate, kept_gyro, acceleration, kept_notch)


def on_airframe(vehicle: Vehicle) -> Mapping[str, Mapping[str, float]]:
    """Return the authority about each axis, with thrust linearised (THR_MDL_FAC)."""
    rotors = actuation(vehicle)
    return {"authority": accelerations(rotors, px4_factors(rotors), linearized_slope(rotors), vehicle, "PX4")}


row = gain_rows(SOURCE)

LAW = Law(
    name="px4",
    title="PX4: angle P, rate PID, gyro and D filters",
    blocks=Blocks("angle P, rate PID", measured="notch and low-pass"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        row("angle_p", "MC_*_P", Span(4.0, 1.0, 12.0), Span(0.95, 0.1, 2.0)),
        row("p", "MC_*RATE_P", Span(0.15, 0.01, 0.5), Span(1.8, 1.2, 5.0)),
        row("i", "MC_*RATE_I", Span(0.2, 0.01, 1.0), Span(0.4, 0.02, 2.0)),
        row("d", "MC_*RATE_D", Span(0.003, 0.0, 0.01), Span(0.2, 0.0, 1.0)),
        row("ff", "MC_*RATE_FF", Span(0.0, 0.0, 0.1)),
        row("i_limit", "MC_*R_INT_LIM", Span(0.3, 0.05, 1.0), Span(9.8, 1.0, 20.0)),
        row("gyro_cutoff", "IMU_GYRO_CUTOFF", Span(40.0, 20.0, 120.0), Span(0.0, 0.0, 40.0)),
        row(
            "d_cutoff", "IMU_DGYRO_CUTOFF", Span(30.0, 10.0, 100.0), Span(5.0, 0.0, 20.0),
            meaning="cut-off of the first-order low-pass on the angular acceleration, 0 for none", unit="Hz", cutoff=True,
        ),
        row(
            "notch", "IMU_GYRO_NF0_FRQ", Span(0.0, 0.0, 120.0), Span(0.0, 0.0, 40.0),
            meaning="centre of the notch on the gyro, 0 for none", unit="Hz", cutoff=True,
        ),
        row(
            "notch_width", "IMU_GYRO_NF0_BW", Span(20.0, 5.0, 50.0), Span(5.0, 1.0, 20.0),
            meaning="width of the notch on the gyro", unit="Hz", cutoff=True,
        ),
        row("authority", "authority", Span(100.0, 1.0, 2000.0), Span(1.0, 0.5, 2.0)),
    ),
    sampling="filters of the gyro: bilinear, cut-off exact; D: backward difference of the filtered rate, first-order low-pass by "
    "backward Euler; integral: forward Euler, in force one period after it is formed",
    promises=frozenset({"rejects"}),
    limits=(attenuated, limited),
    shared=dict.fromkeys(("gyro_cutoff", "d_cutoff", "notch", "notch_width"), ATTITUDE_AXES),
    axes={
        "pitch": {"p": Span(0.15, 0.01, 0.6)},
        "yaw": {
            "angle_p": Span(2.8, 0.5, 5.0),
            "p": Span(0.2, 0.01, 0.6),
            "i": Span(0.1, 0.01, 1.0),
            "d": Span(0.0, 0.0, 0.01),
        },
    },
    on_airframe=on_airframe,
)  # fmt: skip
