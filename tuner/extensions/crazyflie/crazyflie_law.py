"""The Crazyflie's firmware: a PID on the angle around a PID on the rate, in degrees, D of both on the measurement.

    e = r - y,    w_sp = angle_p e + angle_i int e - angle_d y',    w = LP(y')
    b0 u = authority output,    output = p (w_sp - w) + i int (w_sp - w) - d LP_d(w') + ff w_sp,    |output| <= 32767

Use it for a Crazyflie with the PID controller of its firmware: the gains are its parameters.

output counts, 65535 of which are the full thrust of a motor; `authority` is the angular acceleration that a count gives. The rate
of a reference is not heard, so a heading that turns is followed late. The integrals, in deg s and deg, are bounded by limits of
their own and by nothing else, and in force in the period in which they are formed. The gyro's filter is sampled with the loop at
500 Hz, the firmware's with the gyro at 1 kHz.
bitcraze/crazyflie-firmware: src/utils/src/pid.c, src/modules/src/controller/attitude_pid_controller.c, platform_defaults_cf2.h.
"""

from collections.abc import Mapping
from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.filters import Delays, Section, low_pass, settled_section, step_section
from plant.laws.law import Blocks, Law, Span
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.autopilots.law_parts import bounded, gain_rows, limited
from tuner.extensions.autopilots.scales import accelerations, crazyflie_factors

SOURCE = "bitcraze/crazyflie-firmware, src/utils/src/pid.c and platform_defaults_cf2.h"
DEGREES = 57.29577951308232
# Counts that an output goes to, and those of full thrust.
MAX_COUNT, FULL = 32767.0, 65535.0


class Gains(NamedTuple):
    """angle_p [1/s], angle_i [1/s2], angle_d [1], angle_i_limit [deg s]; p [counts s/deg], i [counts/deg], d [counts s2/deg],
    ff [counts s/deg], i_limit [deg]; gyro_cutoff, d_cutoff [Hz], 0 for none; authority [y/s2]: acceleration that a count gives.
    """

    angle_p: float
    angle_i: float
    angle_d: float
    angle_i_limit: float
    p: float
    i: float
    d: float
    ff: float
    i_limit: float
    gyro_cutoff: float
    d_cutoff: float
    authority: float


class Constants(NamedTuple):
    """The gains, with filters as sampled sections."""

    angle_p: float
    angle_i: float
    angle_d: float
    angle_i_limit: float
    p: float
    i: float
    d: float
    ff: float
    i_limit: float
    gyro: Section
    derivative: Section
    authority: float


class Memory(NamedTuple):
    """angle_integral [deg s], integral [deg]; angle [y], rate [y/s]: last ones measured; what the filters keep."""

    angle_integral: float
    integral: float
    angle: float
    rate: float
    gyro: Delays
    derivative: Delays


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the filters."""
    return Constants(
        gains.angle_p,
        gains.angle_i,
        gains.angle_d,
        gains.angle_i_limit,
        gains.p,
        gains.i,
        gains.d,
        gains.ff,
        gains.i_limit,
        low_pass(gains.gyro_cutoff, h),
        low_pass(gains.d_cutoff, h),
        gains.authority,
    )


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Steady: the integral of the rate loop holds the plant, filters are settled at the measured rate; i must not be 0."""
    gyro = settled_section(measured.rate, constants.gyro)
    integral = held / (constants.authority * constants.i)
    return Memory(0.0, integral, measured.value, measured.rate, gyro, Delays(0.0, 0.0))


def limited_angle(integral: float, constants: Constants) -> float:
    """The integral of the angle loop within its limit."""
    return bounded(integral, constants.angle_i_limit)


def limited_output(output: float, constants: Constants) -> float:  # noqa: ARG001
    """The output as a signed number of 16 bits."""
    return bounded(output, MAX_COUNT)


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,  # noqa: ARG001
    h: float,
) -> tuple[float, Memory]:
    """One control period; the integrals take effect at once."""
    rate, kept_gyro = step_section(memory.gyro, measured.rate, constants.gyro)
    error = DEGREES * (setpoint.value - measured.value)
    angle_integral = limited_angle(memory.angle_integral + h * error, constants)
    turning = DEGREES * (measured.value - memory.angle) / h
    rate_setpoint = constants.angle_p * error + constants.angle_i * angle_integral - constants.angle_d * turning
    rate_error = rate_setpoint - DEGREES * rate
    integral = limited(memory.integral + h * rate_error, constants)
    derivative, kept_derivative = step_section(
        memory.derivative, DEGREES * (rate - memory.rate) / h, constants.derivative
    )
    output = limited_output(
        constants.p * rate_error + constants.i * integral - constants.d * derivative + constants.ff * rate_setpoint,
        constants,
    )
    return constants.authority * output / channel.b0, Memory(
        angle_integral, integral, measured.value, rate, kept_gyro, kept_derivative
    )


def on_airframe(vehicle: Vehicle) -> Mapping[str, Mapping[str, float]]:
    """Return the acceleration that a count gives about each axis.

    It is in rad/s2; thrust is proportional to counts (battery compensation).
    """
    rotors = actuation(vehicle)
    count = rotors.thrust_max / FULL
    return {"authority": accelerations(rotors, crazyflie_factors(rotors), count, vehicle, "the Crazyflie's X mixing")}


row = gain_rows(SOURCE)

LAW = Law(
    name="crazyflie",
    title="Crazyflie: angle PID, rate PID, gyro and D filters",
    blocks=Blocks("angle PID, rate PID", measured="low-pass"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        row("angle_p", "pid_attitude.*_kp", Span(6.0, 2.0, 20.0), Span(1.0, 0.3, 4.0)),
        row(
            "angle_i", "pid_attitude.*_ki", Span(3.0, 0.0, 20.0), Span(0.3, 0.0, 1.0),
            meaning="rate asked for per integrated angle error", unit="s^-2", term="integral term of the angle",
        ),
        row(
            "angle_d", "pid_attitude.*_kd", Span(0.0, 0.0, 1.0),
            meaning="rate asked for per measured rate of the angle", term="derivative term of the angle",
        ),
        row(
            "angle_i_limit", "angle_i_limit", Span(20.0, 5.0, 400.0),
            meaning="limit of the integrated angle error, deg s", scale="log", firmware=True,
        ),
        row("p", "pid_rate.*_kp", Span(250.0, 50.0, 1000.0), meaning="counts per deg/s of rate error", unit="1"),
        row(
            "i", "pid_rate.*_ki", Span(500.0, 10.0, 2000.0), Span(100.0, 10.0, 500.0),
            meaning="counts per deg of integrated rate error", unit="1", exclusive=True, term="",
        ),
        row(
            "d", "pid_rate.*_kd", Span(2.5, 0.0, 10.0),
            meaning="counts per deg/s2 of measured angular acceleration", unit="1",
        ),
        row("ff", "pid_rate.*_kff", Span(0.0, 0.0, 100.0), meaning="counts per deg/s asked for", unit="1"),
        row(
            "i_limit", "i_limit", Span(33.3, 5.0, 500.0), Span(166.7, 5.0, 500.0),
            meaning="limit of the integrated rate error, deg", firmware=True,
        ),
        row("gyro_cutoff", "gyro_cutoff", Span(80.0, 30.0, 200.0), Span(0.0, 0.0, 40.0), firmware=True),
        row(
            "d_cutoff", "pid_rate.om*FiltCut", Span(0.0, 0.0, 100.0), Span(0.0, 0.0, 40.0),
            meaning="cut-off of the second-order low-pass on D, 0 for none", unit="Hz", cutoff=True,
        ),
        row(
            "authority", "authority", Span(0.002, 1e-05, 0.1), Span(0.0002, 1e-05, 0.001),
            meaning="angular acceleration that a count of output gives",
        ),
    ),
    sampling="filters: bilinear, cut-off exact; D: backward difference; integrals: forward Euler, in force at once",
    promises=frozenset({"rejects"}),
    limits=(limited_angle, limited, limited_output),
    winds_up=True,
    shared={"gyro_cutoff": ATTITUDE_AXES},
    axes={
        "yaw": {
            "angle_i": Span(1.0, 0.0, 20.0),
            "angle_d": Span(0.35, 0.0, 1.0),
            "angle_i_limit": Span(360.0, 5.0, 400.0),
            "p": Span(120.0, 20.0, 1000.0),
            "i": Span(16.7, 1.0, 500.0),
            "d": Span(0.0, 0.0, 10.0),
            "i_limit": Span(166.7, 5.0, 500.0),
        },
    },
    on_airframe=on_airframe,
)  # fmt: skip
